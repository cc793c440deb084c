"""The texts of a training dataset's frames by index: LeRobot's processors pass the index on, but not the texts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pyarrow as pa
from torch import Tensor

from lerobot_llakey import schema
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.policies.dataset_columns import tables_of, texts_of

_KEPT = "_llakey_texts"


class TrainingTexts:
    """Each frame's instruction and previous instruction, as far as a dataset has them.

    A frame takes four bytes a text; each distinct text is kept once.

    Args:
        dataset_meta: a ``LeRobotDatasetMetadata``; None knows no frame.
    """

    def __init__(self, dataset_meta: Any | None) -> None:
        self._texts: list[str] = []
        self._places: dict[str, np.ndarray] = {}
        if dataset_meta is None:
            return
        numbers: dict[str, int] = {}
        for key in filter(dataset_meta.features.__contains__, schema.TEXTS):
            indices, places = [np.zeros(0, np.int64)], [np.zeros(0, np.int32)]
            for table in tables_of(dataset_meta, [schema.INDEX, key]):
                encoded = texts_of(table.column(key))
                known = [numbers.setdefault(text or "", len(numbers)) for text in encoded.dictionary.to_pylist()]
                # A missing text is an empty one, which whoever reads it refuses by name.
                known.append(numbers.setdefault("", len(numbers)))
                local = encoded.indices.fill_null(pa.scalar(len(known) - 1, encoded.indices.type)).to_numpy()
                places.append(np.array(known, dtype=np.int32)[local])
                indices.append(table.column(schema.INDEX).to_numpy())
            index, place = np.concatenate(indices), np.concatenate(places)
            if len(index):
                self._places[key] = np.full(int(index.max()) + 1, -1, dtype=np.int32)
                self._places[key][index] = place
        self._texts = list(numbers)

    def fill(self, batch: Mapping[str, Any]) -> dict[str, Any]:
        """A batch with the texts that it lacks, looked up by its ``index``; those that it has stay.

        Raises:
            LlakeyError: if an index is none of the dataset's.
        """
        filled = dict(batch)
        indices = batch.get(schema.INDEX)
        if not isinstance(indices, Tensor):
            return filled
        rows = indices.reshape(-1).cpu().numpy()
        for key, places in self._places.items():
            if key in batch:
                continue
            known = (rows >= 0) & (rows < len(places))
            found = places[np.where(known, rows, 0)]
            if not known.all() or (found < 0).any():
                wrong = int(rows[~known | (found < 0)][0])
                raise LlakeyError(
                    f"Expected an {schema.INDEX} of the training dataset's {len(places)} frames, got {wrong}; train on "
                    "the dataset that the policy was made with."
                )
            filled[key] = [self._texts[place] for place in found]
        return filled


def training_texts(dataset_meta: Any | None) -> TrainingTexts:
    """The texts of a dataset; a metadata object's are read once."""
    if dataset_meta is None:
        return TrainingTexts(None)
    kept: TrainingTexts = dataset_meta.__dict__.setdefault(_KEPT, None) or TrainingTexts(dataset_meta)
    dataset_meta.__dict__[_KEPT] = kept
    return kept
