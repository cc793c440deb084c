"""Where a measuring verb leaves its figures."""

import json
from pathlib import Path
from typing import Any


def write_results(output_dir: Path | None, results: Any) -> None:
    """Write ``results.json`` into a folder, made where it is missing, and say where; nothing without a folder."""
    if output_dir is None:
        return
    output_dir.mkdir(parents=True, exist_ok=True)
    path = output_dir / "results.json"
    path.write_text(json.dumps(results, indent=2))
    print(f"results: {path}")
