"""The papers whose tables can be regenerated: a module each, with ID, PAPER and reproduce(progress)."""

from __future__ import annotations

from types import ModuleType

from archsim.errors import did_you_mean, fail
from archsim.reproduce import aila2004, johnson2004, lloyd2007

PAPERS: dict[str, ModuleType] = {paper.ID: paper for paper in (johnson2004, aila2004, lloyd2007)}


def paper_named(name: str) -> ModuleType:
    """The paper of that name. ArchsimError if there is none."""
    if name not in PAPERS:
        raise fail(f"no paper '{name}'", hint=did_you_mean(name, PAPERS) or f"papers: {', '.join(PAPERS)}")
    return PAPERS[name]
