"""Where a measuring verb leaves its figures and pictures."""

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from lerobot_llakey.files import write_whole


def write_results(output_dir: Path | None, results: Any) -> None:
    """Write ``results.json`` into a folder, made where it is missing, and say where; nothing without a folder.

    Raises:
        LlakeyError: if it cannot be written; no half file is left then.
    """
    if output_dir is None:
        return
    path = output_dir / "results.json"
    write_whole(path, json.dumps(results, indent=2))
    print(f"results: {path}")


def write_png(path: Path, picture: np.ndarray) -> None:
    """Write a picture (H, W, 3) uint8 RGB as a PNG file, made as small as PNG can.

    Raises:
        LlakeyError: if it cannot be written; no half file is left then.
    """
    whole, content = cv2.imencode(".png", picture[..., ::-1], (cv2.IMWRITE_PNG_COMPRESSION, 9))
    assert whole  # a picture in memory can always be encoded
    write_whole(path, content.tobytes())
