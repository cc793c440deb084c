"""Who says the next basic action: the interface that all commanders share."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch

from lerobot_llakey import schema
from lerobot_llakey.policies.hierarchy.record import Step


@dataclass(frozen=True)
class Said:
    """One instruction as its commander gave it.

    Attributes:
        text: the words, before the supervisor looks at them.
        source: who said it: "policy", "oracle", "task", "list" or "person".
        likelihood: how likely the words were to who said them, in 0..1; None where that has no meaning.
    """

    text: str
    source: str
    likelihood: float | None = None


class Commander(ABC):
    """Says the next instruction of each row.

    The hierarchical policy calls :meth:`reset` before an episode, and at each step :meth:`observe`, :meth:`ask` and
    then :meth:`sent`. Asking changes nothing: the same question has the same answer until the step was sent, so that a
    page may show what is proposed before it is acted on.
    """

    def reset(self) -> None:
        """Forget all episodes."""

    def observe(self, hands: np.ndarray) -> None:
        """Look at the hands (B, 8) before a step: position in metres, quaternion xyzw, gripper opening."""

    @abstractmethod
    def ask(self, batch: Mapping[str, Any], rows: Sequence[int], previous: Sequence[str]) -> list[Said]:
        """The next instruction of some rows.

        Args:
            batch: the observation of all B rows.
            rows: indices of the rows that are asked for.
            previous: the instruction last carried out in each of ``rows``, "" before the first.

        Returns:
            One answer for each of ``rows``.

        Raises:
            LlakeyError: if the batch lacks what the commander needs.
        """

    def with_tasks(self, batch: Mapping[str, Any]) -> Mapping[str, Any]:
        """The batch with the goals that hold for its rows, where they are not those of the environment."""
        return batch

    def sent(self, steps: Sequence[Step]) -> None:
        """Take note of what was carried out, one step for each row of the batch."""


def take_rows(batch: Mapping[str, Any], rows: Sequence[int]) -> dict[str, Any]:
    """Some rows of a batch.

    Args:
        batch: tensors (B, ...) and lists of B; what has another length belongs to all rows and is kept.
        rows: indices below B.
    """
    count = len(batch[schema.STATE])
    chosen = torch.as_tensor(list(rows))

    def of(value: Any) -> Any:
        if isinstance(value, torch.Tensor) and value.ndim and len(value) == count:
            return value[chosen.to(value.device)]
        if isinstance(value, list | tuple) and len(value) == count:
            return [value[row] for row in rows]
        return value

    return {key: of(value) for key, value in batch.items()}
