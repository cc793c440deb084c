"""The model card of a policy of this package, made of its settings, its training run and an evaluation's figures."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from huggingface_hub import ModelCard, ModelCardData
from lerobot.policies.pretrained import PreTrainedPolicy

from lerobot_llakey.files import packaged
from lerobot_llakey.policies.action.configuration_llakey_action import LlakeyActionConfig
from lerobot_llakey.policies.command.configuration_llakey_command import LlakeyCommandConfig
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
from lerobot_llakey.policies.hierarchy.processor_llakey import make_llakey_pre_post_processors
from lerobot_llakey.policies.hierarchy.results import known_results

AnyConfig = LlakeyConfig | LlakeyCommandConfig | LlakeyActionConfig

TAGS = ("LeRobot", "llakey", "robotics")
LICENSE = "apache-2.0"
_COMMAND = "a command policy, a vision-language model, looks at the scene and says the next basic action in words"
_ACTION = "an action policy, a multi-view transformer on the point cloud, turns such words into the next keyframe pose"
_METHOD = "LLaKey (*Follow My Basic Action Instructions to Your Next Key State*)"
_ABOUT = {
    "llakey": f"This is a LLaKey policy. In {_METHOD}, {_COMMAND}; {_ACTION}. Both are in this checkpoint.",
    "llakey_command": f"This is the command policy of {_METHOD}, in which {_COMMAND}. It moves nothing by itself.",
    "llakey_action": f"This is the action policy of {_METHOD}, in which {_ACTION}. It has to be given instructions.",
}
_EVALUATE = "lerobot-eval {policy} --env.type=llakey_sim --env.task=all --eval.n_episodes=25 --policy.device=cpu"
_USE = {
    "llakey": _EVALUATE.format(policy="--policy.path={name}"),
    "llakey_command": _EVALUATE.format(
        policy="--policy.type=llakey --policy.command_path={name} \\\n    --policy.action_path=ACTION_POLICY"
    ),
    "llakey_action": _EVALUATE.format(
        policy="--policy.type=llakey --policy.command_path=COMMAND_POLICY \\\n    --policy.action_path={name}"
    ),
}


@dataclass(frozen=True)
class TrainingRun:
    """What a card says of a policy's training.

    Attributes:
        dataset: its name on the Hub.
        steps, batch_size, seed: of the run.
    """

    dataset: str | None = None
    steps: int | None = None
    batch_size: int | None = None
    seed: int | None = None


def make_model_card(
    config: AnyConfig,
    name: str,
    run: TrainingRun | None = None,
    *,
    parameters: int | None = None,
    results: str | None = None,
    license: str | None = None,
) -> ModelCard:
    """The card of a policy.

    Args:
        config: its settings.
        name: of its repository.
        run: how it was trained, where that is known.
        parameters: how many there are.
        results: a table in Markdown.
        license: by the Hub's name for it; by default the settings' own, else this package's.
    """
    run = run or TrainingRun()
    data = ModelCardData(
        license=license or config.license or LICENSE,
        library_name="lerobot",
        pipeline_tag="robotics",
        tags=list(dict.fromkeys([*TAGS, config.type, *(config.tags or [])])),
        datasets=run.dataset if _is_public_name(run.dataset) else None,
        model_name=config.type,
    )
    features = {**(config.input_features or {}), **(config.output_features or {})}
    return ModelCard.from_template(
        data,
        template_str=packaged("model_cards/llakey_policy.md"),
        name=name,
        about=_ABOUT[config.type],
        facts=list(_facts(config, run, parameters).items()),
        use=_USE[config.type].format(name=name),
        feeds=f"Without the simulator, `llakey show` and LeRobot's own robots take the checkpoint as `{name}`, too.",
        results=results,
        features=[(key, " x ".join(map(str, feature.shape))) for key, feature in features.items()],
    )


def _facts(config: AnyConfig, run: TrainingRun, parameters: int | None) -> dict[str, str]:
    """What is known, in words."""
    command = config.command if isinstance(config, LlakeyConfig) and config.has_command else config
    action = config.action if isinstance(config, LlakeyConfig) else config
    found: dict[str, Any] = {"type": f"`{config.type}`", "parameters": parameters and f"{parameters:,}"}
    if isinstance(command, LlakeyCommandConfig):
        found["vision-language model"] = command.model or "small, the LLaVA classes of `transformers`"
        found["cameras of the command policy"] = _listed(command.cameras)
    if isinstance(action, LlakeyActionConfig):
        found["design of the action policy"] = action.design
        found["cameras of the action policy"] = _listed(action.cameras)
        found["workspace, metres"] = _box(action.workspace)
    if isinstance(config, LlakeyConfig):
        found["commander"] = config.commander
    found["instructions"] = "any sentence" if config.rules.is_free else config.rules.name
    found["trained on"] = run.dataset
    found["steps and batch size"] = run.steps and f"{run.steps:,} of {run.batch_size}, seed {run.seed}"
    return {key: str(value) for key, value in found.items() if value}


def _listed(cameras: Any) -> str:
    return ", ".join(f"`{camera}`" for camera in cameras) if isinstance(cameras, list | tuple) else str(cameras)


def _box(bounds: Any) -> str:
    if not isinstance(bounds, list | tuple):
        return str(bounds or "")
    return ", ".join(f"{axis} {low:.2f} to {high:.2f}" for axis, (low, high) in zip("xyz", bounds, strict=True))


def _is_public_name(name: str | None) -> bool:
    """Whether a data set's name can be one of the Hub: ``local/...`` never is."""
    return name is not None and name.count("/") == 1 and not name.startswith("local/")


class PublishedPolicy(PreTrainedPolicy):
    """A policy that LeRobot pushes with its processors and this package's card with its results.

    Attributes:
        evaluated_in: folder in which a ``results.json`` of just these weights may lie: where they were loaded from.
    """

    config_class = LlakeyConfig
    name = "llakey"
    config: LlakeyConfig
    evaluated_in: Path | None = None

    def generate_model_card(
        self,
        dataset_repo_id: str | None,
        model_type: str,
        license: str | None,
        tags: list[str] | None,
        cfg: Any = None,
        dataset_meta: Any = None,
    ) -> ModelCard:
        """The card for ``lerobot-train``'s own push, with the table of results where an evaluation is known.

        Args:
            dataset_repo_id: of the training data.
            model_type: as LeRobot's.
            license: by the Hub's name for it.
            tags: as LeRobot's; the settings hold them.
            cfg: of the training run.
            dataset_meta: as LeRobot's.

        Raises:
            MissingFileError: if ``results_path`` leads nowhere.
            LlakeyError: if what is there is no evaluation.
        """
        run = TrainingRun(dataset_repo_id, *((cfg and (cfg.steps, cfg.batch_size, cfg.seed)) or ()))
        return make_model_card(
            self.config,
            self.config.repo_id or model_type,
            run,
            parameters=sum(weight.numel() for weight in self.parameters()),
            results=known_results(self.config.results_path, self.evaluated_in),
            license=license,
        )

    def push_to_hub(self, repo_id: str, **kwargs: Any) -> str:
        """Upload the checkpoint with its processors and its model card; see LeRobot's ``push_to_hub``."""
        kwargs["card_kwargs"] = kwargs.get("card_kwargs") or {}
        return str(super().push_to_hub(repo_id, **kwargs))

    def save_pretrained(
        self, save_directory: str | Path, *, card_kwargs: dict[str, Any] | None = None, **kwargs: Any
    ) -> str | None:
        """Write the checkpoint; with ``card_kwargs``, which pushing gives, its card and processors as well."""
        if card_kwargs is not None:
            config = self.config
            card = self.generate_model_card(None, config.type, config.license, config.tags)
            Path(save_directory).mkdir(parents=True, exist_ok=True)
            card.save(Path(save_directory) / "README.md")
            for pipeline in make_llakey_pre_post_processors(config):
                pipeline.save_pretrained(save_directory)
        pushed: str | None = super().save_pretrained(save_directory, card_kwargs=card_kwargs, **kwargs)
        return pushed
