"""The command policy: a vision-language model that names the next basic action.

Source: section III-C of the paper (LLaVA on three views, loss on the answer alone, stop token ``<next goal>``).
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch
from lerobot.configs import FeatureType, PolicyFeature
from lerobot.policies.pretrained import PreTrainedPolicy
from torch import Tensor
from torch.nn import functional

from lerobot_llakey import schema
from lerobot_llakey.checks.dataset import check_dataset
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.batch import check_actions, read_actions, read_hands
from lerobot_llakey.policies.command.answering import Answering
from lerobot_llakey.policies.command.chat.backend import ChatBackend
from lerobot_llakey.policies.command.checkpoints import CommandCheckpoints
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.command.decoding.answer import answer_metrics
from lerobot_llakey.policies.command.encoding import IGNORED
from lerobot_llakey.policies.command.inputs import augment, read_prompts, stack_cameras
from lerobot_llakey.policies.command.language_model import build_language_model
from lerobot_llakey.policies.command.pretrained.adapters import TakesAdapters
from lerobot_llakey.policies.command.small.model import KeyframeHead, read_last
from lerobot_llakey.policies.command.targets import ActionTarget, check_answer_lengths, make_target
from lerobot_llakey.policies.command.training_dataset import dataset_needs, learn_texts
from lerobot_llakey.policies.draws import numpy_generator, seeded_by_step
from lerobot_llakey.policies.losses import check_loss, weighted
from lerobot_llakey.policies.precision import autocast
from lerobot_llakey.policies.texts import reworded, text_column
from lerobot_llakey.policies.training_texts import training_texts
from lerobot_llakey.saved.weights import CheckedWeights


class LlakeyCommandPolicy(Answering, CommandCheckpoints, CheckedWeights, TakesAdapters, PreTrainedPolicy):
    """Names the next basic action from images and text.

    Args:
        config: the settings; its vocabulary is filled from ``dataset_meta`` when it is empty.
        dataset_stats: unused; LeRobot passes it.
        dataset_meta: metadata of the training dataset, None when a trained policy is loaded.
        assets_dir: folder of a saved pretrained model's architecture and processor; set by :meth:`from_pretrained`.

    Attributes:
        chat: asks a hosted model instead of a local one, with its counts; None unless ``backend`` is "chat".
        answered: number of answers of the model since the policy was built.
        unparsable: how many of them were outside the grammar.
        gated: number of rows that kept their instruction because the arm moved.

    Raises:
        LlakeyError: if a camera is missing, the dataset has no instructions, or the model cannot be found.
    """

    config_class = LlakeyCommandConfig
    name = "llakey_command"
    config: LlakeyCommandConfig

    def __init__(
        self,
        config: LlakeyCommandConfig,
        dataset_stats: Mapping[str, Any] | None = None,
        dataset_meta: Any | None = None,
        assets_dir: str | Path | None = None,
        **_: Any,
    ) -> None:
        super().__init__(config)
        config.learn_robot(dataset_meta)
        config.use_default_features()
        config.validate_features()
        # LeRobot's normaliser would treat text columns among the inputs as numbers.
        features = config.input_features or {}
        config.input_features = {key: features[key] for key in config.image_keys}
        if config.uses_proprioception:
            config.input_features[schema.STATE] = PolicyFeature(FeatureType.STATE, (len(config.state_names),))
        if dataset_meta is not None:
            config.learn_grammar(dataset_meta.features)
            if config.backend == "local":
                check_dataset(dataset_meta, dataset_needs(config))
            learn_texts(config, dataset_meta)
        self._texts = training_texts(dataset_meta)
        self.answered = self.unparsable = self.gated = 0
        self.model: Any = None
        self.encoder: Any = None
        self._processor: Any = None
        self.auxiliary: KeyframeHead | None = None
        self.chat = ChatBackend(config) if config.backend == "chat" else None
        if self.chat is not None:
            return
        built = build_language_model(config, assets_dir)
        self.model, self.encoder, self._processor = built.model, built.encoder, built.processor
        if config.model is not None:
            self.name_or_path = config.model  # an adapter stores it as its base model
        elif config.auxiliary_weight:
            self.auxiliary = KeyframeHead(config.text_width)
        self.target = make_target(config)
        self._trie = self.target.trie(self.encoder)
        if config.constrain and config.target == "instruction":
            check_answer_lengths(config, self.encoder)

    def get_optim_params(self) -> list[dict[str, Any]]:
        """Trained parameters in groups: hidden matrices (for Muon), other weights, and those without weight decay."""
        self._require_weights()
        self._require_adapters()
        hidden: list[Tensor] = []
        weights: list[Tensor] = []
        rest: list[Tensor] = []
        for name, value in self.named_parameters():
            if not value.requires_grad:
                continue
            if value.ndim < 2 or "embed" in name:
                rest.append(value)
            elif value.ndim == 2 and ".layers." in name:
                hidden.append(value)
            else:
                weights.append(value)
        return [{"params": hidden, "muon": True}, {"params": weights}, {"params": rest, "weight_decay": 0.0}]

    def reset(self) -> None:
        """Do nothing: the policy has no memory, and the batch contains the previous instruction."""

    @seeded_by_step
    def forward(self, batch: dict[str, Any], reduction: str = "mean") -> tuple[Tensor, dict[str, float]]:
        """Cross-entropy of the answers' tokens, stop token included, with the batch's sample weights if it has any.

        Args:
            batch: images (B, 3, H, W) in 0..1 of every camera, ``task`` and ``instruction`` as lists of str,
                ``previous_instruction`` if the history is on, and ``observation.state`` if proprioception is;
                ``action`` (B, 9) instead of the instructions if it is the target. A batch without instructions gets
                those of the training dataset by ``index``.
            reduction: "mean" for one loss over all tokens; "none" for the losses of the samples (B,), with the same
                mean: samples with more tokens count more.

        Returns:
            The loss and metrics, see :func:`answer_metrics`.

        Raises:
            LlakeyError: if something in the batch is missing or wrong, or the loss is not finite.
        """
        self._require_weights()
        batch = self._texts.fill(batch)
        hands: Tensor | None = None
        if self.auxiliary is not None and self.training and schema.STATE in batch and schema.ACTION in batch:
            hands = read_hands(batch, self.config.hand_columns)
            read_actions(batch, len(hands))
        answers = self.target.answers(batch)
        images = stack_cameras(batch, self.config.image_keys)
        if self.training:
            images = augment(images, self.config.shift_pixels, self.config.colour_jitter)
        rng = numpy_generator() if self.training else None
        prompts = read_prompts(batch, self.config, rng)
        inputs, labels = self.encoder.with_answers(images, prompts, [self._reworded(text, rng) for text in answers])
        length = labels.shape[1]
        with self._autocast(images.device):
            output = self.model.model(**inputs, use_cache=False, **read_last(self.model, length + 1))
            hidden = output.last_hidden_state[:, -length - 1 : -1]
            logits = self.model.lm_head(hidden).float()
        losses = functional.cross_entropy(logits.transpose(1, 2), labels, ignore_index=IGNORED, reduction="none")
        counted = labels != IGNORED
        has_previous = schema.PREVIOUS_INSTRUCTION in batch and self.config.target == "instruction"
        previous = text_column(batch, schema.PREVIOUS_INSTRUCTION, may_be_empty=True) if has_previous else None
        metrics = answer_metrics(logits.detach().argmax(-1) == labels, counted, answers, previous)
        loss = weighted(losses.sum(dim=1) * len(losses) / counted.sum(), batch)
        if hands is not None and self.auxiliary is not None:
            extra = self.auxiliary.loss(hidden[:, 0], hands, batch[schema.ACTION])
            metrics |= {
                "instruction_loss": float(loss.detach().mean()),
                "auxiliary_loss": float(extra.detach().mean()),
            }
            loss = loss + self.config.auxiliary_weight * extra
        loss = check_loss(loss)
        return (loss if reduction == "none" else loss.mean()), metrics

    def select_action(self, batch: dict[str, Any], **kwargs: Any) -> Tensor:
        """The next keyframe's action (B, 9) of each row, if it is the target.

        Raises:
            NotImplementedError: if the target is the instruction.
        """
        if not isinstance(self.target, ActionTarget):
            raise NotImplementedError(
                "Expected a policy that acts, got a command policy, which only names the next instruction; compose it "
                "with an action policy: --policy.type=llakey --policy.command_path=... --policy.action_path=..."
            )
        with torch.no_grad():
            rows = range(len(batch[self.config.image_keys[0]]))
            texts = [answer.text for answer in self._answers(batch, rows)]
        actions = np.stack([self.target.text.decode(text) for text in texts])
        return check_actions(torch.from_numpy(actions)).to(batch[self.config.image_keys[0]].device)

    def predict_action_chunk(self, batch: dict[str, Any], **kwargs: Any) -> Tensor:
        """One step as a chunk (B, 1, 9)."""
        return self.select_action(batch)[:, None]

    def _require_weights(self) -> None:
        """Refuse to train a hosted model."""
        if self.chat is not None:
            raise LlakeyError(
                "Expected a policy with weights to train, got backend=chat, which only asks a hosted model; use "
                "backend=local, or train_command=false where an action policy is trained beside it."
            )

    def _reworded(self, text: str, rng: np.random.Generator | None) -> str:
        """The instruction, in training replaced by a paraphrase with some probability."""
        if rng is None or self.config.target != "instruction":
            return text
        return reworded(text, self.config.paraphrase_probability, rng, self.config.rules)

    def _autocast(self, device: torch.device) -> torch.autocast:
        config = self.config
        # Weights in bfloat16 cannot be multiplied with numbers in float32.
        return autocast("bfloat16" if config.weights_dtype == "bfloat16" else config.dtype, device)
