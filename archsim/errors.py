"""What goes wrong at the edge, said once: `file:line:column: what; did you mean`, all problems together."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple


class Location(NamedTuple):
    """A place in a text that a person wrote; line and column count from 1, 0 means unknown."""

    file: str
    line: int = 0
    column: int = 0

    def __str__(self) -> str:
        known = [self.file, *(str(part) for part in (self.line, self.column) if part)]
        return ":".join(known)


class Problem(NamedTuple):
    """One thing that is wrong, where it stands, and what may have been meant."""

    where: Location | None
    what: str
    hint: str | None = None
    key: str | None = None  # dotted path of the configuration's value that it is about, if it is about one

    def __str__(self) -> str:
        place = f"{self.where or self.key}: " if self.where or self.key else ""
        hint = f"; {self.hint}" if self.hint else ""
        return f"{place}{self.what}{hint}"


class ArchsimError(Exception):
    """Input that cannot be used. Carries every problem found; the command line prints them and exits with 2."""

    def __init__(self, problems: Problem | Sequence[Problem]):
        self.problems: list[Problem] = [problems] if isinstance(problems, Problem) else list(problems)
        super().__init__(self.problems)  # what copies and other processes make the error from again

    def __str__(self) -> str:
        return "\n".join(str(problem) for problem in self.problems)

    def say_more(self, more: Callable[[Problem], Problem]) -> None:
        """Put what is known further out into every problem."""
        self.problems = [more(problem) for problem in self.problems]
        self.args = (self.problems,)


class DeadlockError(ArchsimError):
    """The simulated machine cannot go on; the message says what every unit waits for."""


def fail(
    what: str, where: Location | None = None, hint: str | None = None, key: str | None = None
) -> ArchsimError:
    """An error with a single problem, ready to be raised."""
    return ArchsimError(Problem(where, what, hint, key))


@contextmanager
def about(key: str) -> Iterator[None]:
    """What goes wrong inside is about the configuration's value under this dotted path, or about one within it."""
    try:
        yield
    except ArchsimError as error:
        error.say_more(lambda problem: _about(key, problem))
        raise


def _about(key: str, problem: Problem) -> Problem:
    if problem.where is not None:
        return problem
    return problem._replace(key=key if problem.key is None else f"{key}.{problem.key}")


def did_you_mean(word: str, choices: Iterable[str]) -> str | None:
    """The hint for a misspelt word, or None when nothing is near."""
    near = difflib.get_close_matches(word, list(choices), n=1, cutoff=0.6)
    return f"did you mean '{near[0]}'?" if near else None
