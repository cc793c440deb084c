"""Which level a failure is put down to: the words or the actions (per-level attribution)."""

from __future__ import annotations

from collections.abc import Callable

from lerobot_llakey.evaluation.protocol.records import ACTION, COMMAND
from lerobot_llakey.instructions import BASIC_GRAMMAR
from lerobot_llakey.rollout.actors import Actor
from lerobot_llakey.rollout.episode import Episode, run_episode
from lerobot_llakey.rollout.replay import Replay
from lerobot_llakey.sim.env import LlakeySimEnv


def first_difference(episode: Episode) -> int | None:
    """The first step whose instruction is not the expert's, wordings of one template counting as one.

    Steps at which the expert has nothing to say are passed over. None where all are the same.
    """
    for step, (said, wanted) in enumerate(zip(episode.instructions, episode.oracle, strict=True)):
        if wanted and _canonical(said) != _canonical(wanted):
            return step
    return None


def attribute_failure(env: LlakeySimEnv, episode: Episode, guided: Callable[[], Actor]) -> tuple[str, int | None]:
    """Run a failed episode again, with the oracle's instructions from the first wrong one on.

    Up to there it is the same episode: the same scene and the same actions. Where that is solved, the words were wrong;
    where it fails again, or no instruction differed, the actions were. The policy's counter of repeated instructions
    starts anew where the oracle takes over.

    Args:
        env: gives the oracle's instructions, as it did in the first run.
        episode: the failure.
        guided: makes the policy that follows the oracle's instructions; asked for only where it is needed.

    Returns:
        COMMAND or ACTION, and the step at which the oracle took over, None where it never did.
    """
    step = first_difference(episode)
    if step is None:
        return ACTION, None
    replay = Replay(episode.actions[:step], episode.instructions[:step], guided())
    again = run_episode(env, replay, episode.seed)
    return (COMMAND if again.success else ACTION), step


def _canonical(text: str) -> str:
    return BASIC_GRAMMAR.canonical(text) if BASIC_GRAMMAR.is_parsable(text) else text
