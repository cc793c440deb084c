"""A person's corrections to keyframes and instructions: each is in the file at once, and can be undone."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from lerobot_llakey.datasets.found import FoundKeyframes
from lerobot_llakey.datasets.keyframe_file import Keyframe, Keyframes, discovered, read_keyframes, write_keyframes
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.grammar import Grammar

MOST_UNDONE = 1000
LONGEST_TEXT = 400
"""Characters of an instruction."""


class LabelSession:
    """The keyframes of a dataset while a person corrects them; one at a time, from any thread.

    Args:
        found: the episodes with the keyframes to begin with.
        path: the CSV file of keyframes; its own are taken where it exists, and it is written at every correction.
        grammar: of what an instruction should be; any other text is kept, too, but is not complete.

    Raises:
        LlakeyError: if the file exists and does not fit the dataset.
    """

    def __init__(self, found: Sequence[FoundKeyframes], path: Path, grammar: Grammar) -> None:
        self.found = {episode.episode: episode for episode in found}
        self.path, self.grammar = path, grammar
        self._keyframes = read_keyframes(path, found) if path.exists() else {e.episode: discovered(e) for e in found}
        self._lock = threading.RLock()
        self._before: list[tuple[int, Keyframes]] = []
        self._after: list[tuple[int, Keyframes]] = []

    def keyframes(self, episode: int) -> Keyframes:
        """An episode's keyframes.

        Raises:
            LlakeyError: if there is no such episode.
        """
        if episode not in self._keyframes:
            raise LlakeyError(f"Expected an episode of {len(self._keyframes)}, got {episode}; choose another.")
        return self._keyframes[episode]

    def complete(self, episode: int) -> bool:
        """Whether every segment of an episode has an instruction of the grammar."""
        return all(self.grammar.is_parsable(keyframe.instruction) for keyframe in self.keyframes(episode))

    def texts(self) -> Counter[tuple[str, int, str]]:
        """How often each (task, segment, instruction) was said."""
        with self._lock:
            return Counter(
                (self.found[episode].task, segment, keyframe.instruction)
                for episode, keyframes in self._keyframes.items()
                for segment, keyframe in enumerate(keyframes)
                if keyframe.instruction
            )

    def move(self, episode: int, frame: int, to: int) -> None:
        """Let a keyframe be another frame, between the ones before and after it.

        Raises:
            LlakeyError: if it is no keyframe or the last one, or ``to`` is not between its neighbours.
        """
        with self._lock:
            keyframes, place = self._inner(episode, frame)
            low = keyframes[place - 1].frame + 1 if place else 1
            high = keyframes[place + 1].frame - 1
            if not low <= to <= high:
                raise LlakeyError(
                    f"Expected a frame from {low} to {high}, between its neighbours, got {to}; move less."
                )
            self._put(episode, _with(keyframes, place, Keyframe(to, keyframes[place].instruction)))

    def add(self, episode: int, frame: int) -> None:
        """Make a frame a keyframe, without an instruction.

        Raises:
            LlakeyError: if it is one already, or not within the episode.
        """
        with self._lock:
            keyframes, last = self.keyframes(episode), len(self.found[episode].states) - 1
            if not 0 < frame <= last or frame in (keyframe.frame for keyframe in keyframes):
                raise LlakeyError(
                    f"Expected a frame from 1 to {last} that is no keyframe yet, got {frame}; choose another."
                )
            self._put(episode, tuple(sorted((*keyframes, Keyframe(frame)))))

    def remove(self, episode: int, frame: int) -> None:
        """Let a keyframe be none; where the next one has no instruction, it takes this one's.

        Raises:
            LlakeyError: if it is no keyframe or the last one.
        """
        with self._lock:
            keyframes, place = self._inner(episode, frame)
            gone, following = keyframes[place], keyframes[place + 1]
            heir = Keyframe(following.frame, following.instruction or gone.instruction)
            self._put(episode, (*keyframes[:place], heir, *keyframes[place + 2 :]))

    def say(self, episode: int, frame: int, text: str) -> None:
        """Give the segment that ends at a keyframe its instruction; any text, an empty one for none.

        Raises:
            LlakeyError: if it is no keyframe, or the text is too long.
        """
        plain = " ".join(text.split())
        if len(plain) > LONGEST_TEXT:
            raise LlakeyError(f"Expected at most {LONGEST_TEXT} characters, got {len(plain)}; say it in fewer words.")
        with self._lock:
            keyframes, place = self._at(episode, frame)
            self._put(episode, _with(keyframes, place, Keyframe(frame, plain)))

    def fill(self, episode: int, source: int) -> None:
        """Give the segments that have no instruction those of another episode with as many segments.

        Raises:
            LlakeyError: if the numbers of segments differ.
        """
        with self._lock:
            keyframes, others = self.keyframes(episode), self.keyframes(source)
            if len(keyframes) != len(others):
                raise LlakeyError(
                    f"Expected an episode of {len(keyframes)} segments to copy from, got episode {source} with "
                    f"{len(others)}; add or delete keyframes, or choose another."
                )
            pairs = zip(keyframes, others, strict=True)
            self._put(episode, tuple(Keyframe(one.frame, one.instruction or other.instruction) for one, other in pairs))

    def alike(self, episode: int) -> int | None:
        """The nearest other episode of the same task with as many segments whose instructions are complete."""
        task, count = self.found[episode].task, len(self.keyframes(episode))
        others = [
            other
            for other, found in self.found.items()
            if other != episode and found.task == task and len(self.keyframes(other)) == count and self.complete(other)
        ]
        return min(others, key=lambda other: abs(other - episode), default=None)

    def undo(self) -> int:
        """Take the latest correction back.

        Returns:
            The episode that it was made in.

        Raises:
            LlakeyError: if there is none.
        """
        return self._exchange(self._before, self._after, "take back")

    def redo(self) -> int:
        """Make the correction again that was taken back last; see :meth:`undo`."""
        return self._exchange(self._after, self._before, "make again")

    def _exchange(self, here: list[tuple[int, Keyframes]], there: list[tuple[int, Keyframes]], what: str) -> int:
        with self._lock:
            if not here:
                raise LlakeyError(f"Expected a correction to {what}, got none; make one first.")
            episode, keyframes = here[-1]
            there.append((episode, self._write(episode, keyframes)))
            here.pop()
            return episode

    def _put(self, episode: int, keyframes: Keyframes) -> None:
        if keyframes == self._keyframes[episode]:
            return
        before = self._write(episode, keyframes)
        self._before[:] = [*self._before[1 - MOST_UNDONE :], (episode, before)]
        self._after.clear()

    def _write(self, episode: int, keyframes: Keyframes) -> Keyframes:
        """Keep keyframes once they are in the file; gives those before."""
        write_keyframes(self.path, self.found.values(), self._keyframes | {episode: keyframes})
        before, self._keyframes[episode] = self._keyframes[episode], keyframes
        return before

    def _at(self, episode: int, frame: int) -> tuple[Keyframes, int]:
        keyframes = self.keyframes(episode)
        frames = [keyframe.frame for keyframe in keyframes]
        if frame not in frames:
            raise LlakeyError(f"Expected a keyframe out of {frames}, got frame {frame}; load the page anew.")
        return keyframes, frames.index(frame)

    def _inner(self, episode: int, frame: int) -> tuple[Keyframes, int]:
        """A keyframe that may move or go."""
        keyframes, place = self._at(episode, frame)
        if place == len(keyframes) - 1:
            raise LlakeyError(
                f"Expected the last frame {frame} to stay a keyframe, as in every episode; choose another."
            )
        return keyframes, place


def _with(keyframes: Keyframes, place: int, keyframe: Keyframe) -> Keyframes:
    return (*keyframes[:place], keyframe, *keyframes[place + 1 :])
