"""`archsim statistics`."""

from __future__ import annotations

from archsim.errors import did_you_mean, fail
from archsim.run.catalogue import entries, reference


def print_statistics(word: str) -> None:
    """Print the whole reference, or name, unit and definition of the statistics that a word is in."""
    if not word:
        print(reference(), end="")
        return

    found = [(name, measure) for name, measure in entries() if word in f"{name} {measure.definition}"]
    if not found:
        last = word.rsplit(".", 1)[-1]
        names = [name.rsplit(".", 1)[-1] for name, _ in entries()]
        raise fail(f"no statistic has '{word}' in it", hint=did_you_mean(last, names))
    for name, measure in found:
        print(f"{name} [{measure.unit}]: {measure.definition}")
