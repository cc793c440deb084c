"""Publishing the hierarchical policy: what goes to the Hub beside its weights."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from huggingface_hub import ModelCard
from lerobot.policies.pretrained import PreTrainedPolicy

from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig
from lerobot_llakey.policies.hierarchy.model_card import fill_card, known_results
from lerobot_llakey.policies.hierarchy.processor_llakey import make_llakey_pre_post_processors


class PublishedPolicy(PreTrainedPolicy):
    """A policy that is pushed with its processors and a card with its results.

    Attributes:
        evaluated_in: folder in which a ``results.json`` of just these weights may lie: where they were loaded from.
    """

    config_class = LlakeyConfig
    name = "llakey"
    config: LlakeyConfig
    evaluated_in: Path | None = None

    def generate_model_card(self, *args: Any, **kwargs: Any) -> ModelCard:
        """LeRobot's card, with what the policy is and, where an evaluation is known, its table of results.

        Args:
            *args: as LeRobot's.
            **kwargs: likewise.

        Raises:
            MissingFileError: if ``results_path`` leads nowhere.
            LlakeyError: if what is there is no evaluation.
        """
        return fill_card(
            super().generate_model_card(*args, **kwargs), known_results(self.config.results_path, self.evaluated_in)
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
