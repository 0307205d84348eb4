"""Where a request was and what it waited for there, to be believed: cause by cause, from tick to tick."""

from __future__ import annotations


class Wait:
    """What one request waits for. From the tick of a mark on, but not yet in it, a cause holds or another's wait."""

    def __init__(self) -> None:
        self.marks: list[tuple[int, int | Wait]] = []

    def mark(self, tick: int, what: int | Wait) -> None:
        """After `tick` it waits for this, or for what another waits for."""
        self.marks.append((tick, what))

    def accept(self, tick: int, what: int | Wait) -> None:
        """The same, where it was in a line; if it came in this tick, it never was."""
        if len(self.marks) == 1 and self.marks[0][0] == tick:
            self.marks = []
        self.mark(tick, what)

    def since_the_first(self, cause: int) -> None:
        """All the time so far it waited for this."""
        self.marks = [(self.marks[0][0], cause)]

    def cause_at(self, tick: int) -> int:
        """The cause of a cycle that is stalled at `tick`; if that is the first of all, what it waits for at first."""
        past = [what for since, what in self.marks if since < tick]
        what = past[-1] if past else self.marks[0][1]
        return what.cause_at(tick) if isinstance(what, Wait) else what
