"""What a person may mean while typing an instruction: texts already said, things already named, the grammar's forms."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from lerobot_llakey.grammar import Grammar
from lerobot_llakey.grammar_data import Instruction
from lerobot_llakey.hints import forms, nearest_forms
from lerobot_llakey.labelling.session import LONGEST_TEXT, LabelSession

_SAID, _FORMS = 8, 3


@dataclass(frozen=True)
class Suggestions:
    """What to offer.

    Attributes:
        valid: whether the text is an instruction of the grammar as it stands.
        texts: whole instructions, likeliest first.
        forms: of basic actions, as "grasp <thing>": the nearest ones, or all while nothing is typed.
    """

    valid: bool
    texts: list[str]
    forms: list[str]


def suggest(session: LabelSession, episode: int, segment: int, text: str) -> Suggestions:
    """What to offer for a segment.

    Said at the same segment of the same task comes first, then what was said most often; a typed text leaves those that
    hold all of its words' beginnings.

    Raises:
        LlakeyError: if there is no such episode.
    """
    session.keyframes(episode)
    task, grammar = session.found[episode].task, session.grammar
    ranks: Counter[str] = Counter()
    for (of, at, said), count in session.texts().items():
        ranks[said] += count * (1000 if (of, at) == (task, segment) else 1)
    typed = " ".join(text[:LONGEST_TEXT].split())
    known = [said for said, _ in ranks.most_common() if grammar.is_parsable(said) and _fits(typed, said)]
    texts = list(dict.fromkeys([*known[:_SAID], *_completed(grammar, typed, list(ranks))]))
    valid = grammar.is_parsable(typed)
    shown = nearest_forms(typed, _FORMS, grammar) if typed else forms(grammar)
    return Suggestions(valid, [one for one in texts if one != typed][:_SAID], shown)


def _fits(typed: str, said: str) -> bool:
    words = said.lower().split()
    return all(any(word.startswith(part) for word in words) for part in typed.lower().split())


def _completed(grammar: Grammar, typed: str, said: list[str]) -> list[str]:
    """A typed instruction whose last argument is the beginning of a thing that was named elsewhere."""
    read = grammar.parsed_or_none(typed)
    if read is None or grammar.is_free or not read.arguments:
        return []
    readings = filter(None, map(grammar.parsed_or_none, said))
    poses = set(grammar.poses)
    things = dict.fromkeys(thing for one in readings for thing in one.arguments if thing not in poses)
    *first, last = read.arguments
    likely = [thing for thing in things if thing != last and _fits(last, thing)]
    return [grammar.render(Instruction(read.template, (*first, thing), read.variant)) for thing in likely]
