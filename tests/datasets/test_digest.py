"""The digest of a dataset: blind to how it is cut into files, and to nothing else."""

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from fakes import fake_keysteps
from lerobot_llakey.datasets.collect import collect
from lerobot_llakey.datasets.digest import digest
from lerobot_llakey.datasets.merge import merge
from lerobot_llakey.datasets.plan import CollectSettings, Targets


def test_files_do_not_count_but_content_and_order_do(tmp_path: Path) -> None:
    fake_keysteps(tmp_path / "a", episodes=2, image_size=32)
    fake_keysteps(tmp_path / "b", episodes=1, image_size=32)
    for name, roots in (("ab", "ab"), ("ba", "ba")):
        merge([tmp_path / root for root in roots], tmp_path / name, "local/merged")
    before = digest(tmp_path / "ab")
    assert before != digest(tmp_path / "ba")
    first, second = sorted((tmp_path / "ab" / "data").rglob("*.parquet"))
    whole = pa.concat_tables([pq.read_table(first), pq.read_table(second)])
    pq.write_table(whole, first)
    pq.write_table(whole.slice(0, 0), second)
    assert digest(tmp_path / "ab") == before
    table = pq.read_table(first)
    values = table["frame_index"].to_numpy().copy()
    values[-1] += 1
    index = table.column_names.index("frame_index")
    pq.write_table(table.set_column(index, "frame_index", pa.array(values)), first)
    assert digest(tmp_path / "ab") != before


def test_pictures_in_videos_count(collected: Targets, settings: CollectSettings, tmp_path: Path) -> None:
    assert collected.demonstrations is not None
    before, target = digest(collected.demonstrations), tmp_path / "again"
    collect(settings, Targets(target, None), 1, lambda *_: None)
    assert digest(target) == before
    videos = sorted((target / "videos").rglob("*.mp4"))
    videos[0].write_bytes(videos[1].read_bytes())
    assert digest(target) != before
