"""Any text model of the Hub as a frozen text encoder whose features are kept."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import torch
from torch import Tensor, nn

from lerobot_llakey.errors import LlakeyError

_KEPT_TEXTS = 4096
_MOST_TOKENS = 512
"""Of a text, for models that set no limit themselves."""
_NOT_CONNECTED = ("couldn't connect", "offline", "locate the file on the hub", "max retries", "connection error")


class HubTextEncoder(nn.Module):
    """Token features of a pretrained text model, for example ``openai/clip-vit-base-patch32`` (RVT's is a CLIP).

    The model is not a part of this module's parameters or state: it is never trained, moved to another precision or
    saved; a checkpoint holds its name alone. Each text is encoded once, by itself, and kept on the processor.

    Args:
        name: a model on the Hub or a folder, with its tokenizer: CLIP, or whatever ``AutoModel`` of transformers loads
            that has token features (``last_hidden_state``); the encoder alone is used of those that also decode.

    Attributes:
        width: of the token features.

    Raises:
        LlakeyError: if no text model is found under the name.
    """

    here: Tensor

    def __init__(self, name: str) -> None:
        super().__init__()
        self.register_buffer("here", torch.empty(0), persistent=False)
        model, self._tokenizer, self._longest = _load(name)
        self._frozen = (model,)  # in a tuple, which hides it from torch.nn
        self.width = int(model.config.hidden_size)
        self._kept: OrderedDict[str, Tensor] = OrderedDict()

    def forward(self, texts: Sequence[str]) -> tuple[Tensor, Tensor]:
        """Encode B texts.

        Returns:
            Token features (B, T, width) in float32, and (B, T) bool that is true at padding.
        """
        features = [self._features(text) for text in texts]
        words = nn.utils.rnn.pad_sequence(features, batch_first=True).to(self.here.device)
        lengths = torch.tensor([len(feature) for feature in features], device=self.here.device)
        padding = torch.arange(words.shape[1], device=self.here.device) >= lengths[:, None]
        return words, padding

    def _features(self, text: str) -> Tensor:
        if text not in self._kept:
            self._kept[text] = self._encode(text)
            if len(self._kept) > _KEPT_TEXTS:
                self._kept.popitem(last=False)
        self._kept.move_to_end(text)
        return self._kept[text]

    def _encode(self, text: str) -> Tensor:
        device = self.here.device
        model = self._frozen[0].to(device)
        most = self._longest + 1  # one more than fits shows that the text is too long
        tokens = self._tokenizer(text, return_tensors="pt", truncation=True, max_length=most).to(device)
        if tokens["input_ids"].shape[1] > self._longest:
            raise LlakeyError(
                f"Expected a text of at most {self._longest} tokens for policy.text_model, got more "
                f"({text[:60]!r}...); shorten it."
            )
        inputs = {key: tokens[key] for key in ("input_ids", "attention_mask")}
        # Kept features may later be trained with, even if they were made while deciding.
        with torch.inference_mode(False), torch.no_grad(), torch.autocast(device.type, enabled=False):
            inputs = {key: value.clone() for key, value in inputs.items()}
            return model(**inputs).last_hidden_state[0].float().cpu()


def _load(name: str) -> tuple[Any, Any, int]:
    from transformers import AutoConfig, AutoModel, AutoTokenizer, CLIPTextModel

    try:
        # Left out, code beside the weights would be asked about on the terminal; it is never run.
        settings = AutoConfig.from_pretrained(name, trust_remote_code=False)
        tokenizer = AutoTokenizer.from_pretrained(name, trust_remote_code=False)
        if settings.model_type.startswith("clip"):
            model = CLIPTextModel.from_pretrained(name)
        else:
            model = AutoModel.from_pretrained(name, trust_remote_code=False)
            if settings.is_encoder_decoder:
                model = model.get_encoder()
            model = getattr(model, "text_model", model)
    except (OSError, ValueError, KeyError) as error:
        if any(words in str(error).lower() for words in _NOT_CONNECTED) and not Path(name).exists():
            raise LlakeyError(
                f"Expected policy.text_model on this disk or the Hub within reach, got neither for {name!r}; "
                f"download it where there is a network (hf download {name}), or name a folder in policy.text_model."
            ) from error
        raise LlakeyError(
            f"Expected policy.text_model to name a text model with tokenizer on the Hub or in a folder, got {name!r} "
            f"({str(error).splitlines()[0]}); correct it, or set it to null for the encoder that is trained along."
        ) from error
    longest = min(getattr(model.config, "max_position_embeddings", _MOST_TOKENS), tokenizer.model_max_length)
    return model.float().eval().requires_grad_(False), tokenizer, int(min(longest, _MOST_TOKENS))
