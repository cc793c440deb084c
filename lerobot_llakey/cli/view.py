"""``llakey view``: look at one episode, over time in the rerun viewer or on a page of its keyframes.

llakey view --repo_id=me/demonstrations --root=outputs/demonstrations --episode=3            # opens the viewer
llakey view --repo_id=me/demonstrations --root=outputs/demonstrations --rerun=outputs/episode.rrd
llakey view --repo_id=me/demonstrations --root=outputs/demonstrations --html=outputs/episode.html
"""

from dataclasses import dataclass
from pathlib import Path

from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.datasets.collect import quieten
from lerobot_llakey.datasets.opening import open_dataset
from lerobot_llakey.files import write_whole
from lerobot_llakey.inspection.episode_look import EpisodeLook
from lerobot_llakey.inspection.episode_page import episode_page
from lerobot_llakey.inspection.episode_rerun import write_episode
from lerobot_llakey.inspection.rerun_file import require_rerun


@dataclass
class ViewConfig:
    """Options of ``llakey view``.

    Attributes:
        repo_id: demonstrations on the Hub or in the folder ``root``.
        root: their folder; by default LeRobot's home folder or the Hub.
        episode: index of the episode.
        rerun: save cloud, hand, keyframe poses, cameras and instructions as this .rrd file; needs the ``viz`` extra.
        html: write a page of the keyframes to this .html file, with all pictures in it. Without either, the rerun
            viewer opens.
    """

    repo_id: str
    root: Path | None = None
    episode: int = 0
    rerun: Path | None = None
    html: Path | None = None


@with_options
def run(config: ViewConfig) -> None:
    """Show the episode, or write what was asked for and say where."""
    shows = config.rerun is not None or config.html is None
    if shows:
        require_rerun()  # before a dataset is fetched for it
    quieten()
    look = EpisodeLook(open_dataset(config.repo_id, config.root), config.episode)
    if config.html is not None:
        write_whole(config.html, episode_page(look))
        print(f"page: {config.html}")
    if shows:
        write_episode(look, config.rerun)
        if config.rerun is not None:
            print(f"recording: {config.rerun}")


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
