"""Where the present snapshot hangs, for every thread to see."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from lerobot_llakey.drive.snapshot import Snapshot


class Board:
    """Holds the present snapshot.

    Attributes:
        now: the present snapshot.
        changed: held while the snapshot changes, and notified then. Whoever must act on a snapshot before it changes
            holds it too; it may be taken again by the thread that has it.
    """

    def __init__(self) -> None:
        self.now = Snapshot()
        self.changed = threading.Condition(threading.RLock())

    def publish(self, **changes: Any) -> None:
        """Replace some fields of the snapshot."""
        with self.changed:
            self.now = replace(self.now, version=self.now.version + 1, **changes)
            self.changed.notify_all()

    def wait_for(self, condition: Callable[[Snapshot], bool], timeout: float | None = None) -> Snapshot:
        """The first snapshot that fulfils a condition, or the last one when the time (seconds) is over."""
        with self.changed:
            self.changed.wait_for(lambda: condition(self.now), timeout)
            return self.now
