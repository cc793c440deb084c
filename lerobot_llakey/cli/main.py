"""The ``llakey`` command: one verb, one module.

``llakey collect --task=open_drawer --num_episodes=10 ...`` runs ``lerobot_llakey.cli.collect.main`` with the remaining
arguments, which it parses as LeRobot's own scripts do. A verb's module is imported only when it is asked for.
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Mapping, Sequence
from difflib import get_close_matches

VERBS: dict[str, tuple[str, str]] = {
    "annotate": ("lerobot_llakey.cli.annotate", "give your own recordings keyframes and instructions"),
    "convert": ("lerobot_llakey.cli.convert", "make demonstrations of recordings in RLBench's format"),
    "label": ("lerobot_llakey.cli.label", "correct keyframes and say instructions in a browser page"),
    "check": ("lerobot_llakey.cli.check", "what is wrong with a dataset, before anything is trained on it"),
    "collect": ("lerobot_llakey.cli.collect", "let the experts demonstrate; write demonstrations, keysteps or both"),
    "expert": ("lerobot_llakey.cli.expert", "how often the experts succeed, and whether their keyframes are found"),
    "keyframe-rules": ("lerobot_llakey.cli.keyframe_rules", "how well each rule finds keyframes in noisy recordings"),
    "contact-sheet": ("lerobot_llakey.cli.contact_sheet", "one page with a moment of every task, from every camera"),
    "stress": ("lerobot_llakey.cli.stress", "random legal actions in every task: whether the simulator stands them"),
    "determinism": ("lerobot_llakey.cli.determinism", "whether a seed gives the same pixels and states everywhere"),
    "keysteps": ("lerobot_llakey.cli.keysteps", "draw the training samples from a dataset of demonstrations"),
    "dagger": (
        "lerobot_llakey.cli.dagger",
        "let a policy act, and write what the expert would have done",
    ),
    "merge": ("lerobot_llakey.cli.merge", "join finished datasets into one"),
    "push": ("lerobot_llakey.cli.push", "put a dataset or a policy on the Hub, with its card"),
    "upgrade": ("lerobot_llakey.cli.upgrade", "bring a dataset of the first data contract to the present one"),
    "compose": ("lerobot_llakey.cli.compose", "make one checkpoint of a command and an action policy, and back"),
    "bench": ("lerobot_llakey.cli.bench", "how fast collecting, loading, training and deciding are here"),
    "abilities": ("lerobot_llakey.cli.abilities", "how well a command policy names the next instruction"),
    "keyframe-accuracy": ("lerobot_llakey.cli.keyframe_accuracy", "how often an action policy finds the next keyframe"),
    "view": ("lerobot_llakey.cli.view", "look at one episode: over time in rerun, or its keyframes on a page"),
    "show": ("lerobot_llakey.cli.show", "what an action policy sees and decides for one recorded frame"),
    "table": ("lerobot_llakey.cli.table", "the paper's table I: policies against tasks, with plots and videos"),
    "rollback": ("lerobot_llakey.cli.rollback", "the paper's figure 6: how often policies recover from events"),
    "ambiguity": ("lerobot_llakey.cli.ambiguity", "the paper's figure 1: whether success follows the verbs"),
    "reproduce": ("lerobot_llakey.cli.reproduce", "the whole paper: collect, train, every table, plot and video"),
    "drive": ("lerobot_llakey.cli.drive", "watch a policy step by step, correct it in words, change its goal"),
    "demo": ("lerobot_llakey.cli.demo", "watch a trained policy do the tasks: a table of successes, and videos"),
}
"""What can be asked for: verb -> (module with a ``main()``, summary in one line)."""
RESUMED = ("collect", "convert", "push", "table", "rollback", "ambiguity", "reproduce")
"""Verbs that go on where they were when they are started again with the same options."""


def usage(verbs: Mapping[str, tuple[str, str]] = VERBS) -> str:
    """The help text: every verb with its summary."""
    width = max((len(verb) for verb in verbs), default=0)
    lines = [f"  {verb:<{width}}  {summary}" for verb, (_, summary) in verbs.items()]
    return "\n".join(
        ["usage: llakey VERB [--option=value ...]", "", *lines, "", "Options of a verb: llakey VERB --help"]
    )


def unknown_verb(verb: str, verbs: Mapping[str, tuple[str, str]] = VERBS) -> str:
    """The one sentence for a verb that does not exist, with the nearest one that does."""
    nearest = get_close_matches(verb, verbs, n=1, cutoff=0.5)
    hint = f"did you mean {nearest[0]!r}?" if nearest else "llakey --help lists what each does."
    return f"Expected a verb out of {', '.join(verbs)}, got {verb!r}; {hint}"


def main(argv: Sequence[str] | None = None) -> None:
    """Run the verb named by the first argument.

    Args:
        argv: verb and options, by default those of the process. The verb's ``main()`` finds its own in ``sys.argv``.

    Raises:
        SystemExit: after ``--help`` (status 0), without a verb or with an unknown one (status 2), after Ctrl-C (130).
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    if not arguments:
        print(usage(), file=sys.stderr)
        raise SystemExit(2)
    verb, *options = arguments
    if verb in ("-h", "--help", "help"):
        print(usage())
        raise SystemExit(0)
    if verb not in VERBS:
        print(unknown_verb(verb), file=sys.stderr)
        raise SystemExit(2)
    module, _ = VERBS[verb]
    sys.argv = [f"llakey {verb}", *options]
    try:
        importlib.import_module(module).main()
    except KeyboardInterrupt:
        then = "the same command goes on where it was" if verb in RESUMED else "started again, it begins anew"
        print(f"\nllakey {verb}: interrupted; {then}.", file=sys.stderr)
        raise SystemExit(130) from None


if __name__ == "__main__":
    main()
