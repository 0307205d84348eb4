"""All formats by name, and the two loops that they share: over the lines of a text, over accesses."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from archsim.errors import did_you_mean, fail
from archsim.jit import compiled
from archsim.trace.formats import dinero, dramsim3, ramulator, table
from archsim.trace.formats.scan import NEWLINE, Problem, next_line, skip_blanks


class Language(IntEnum):
    """How a line is written; reading, the two of Dinero and the two of Ramulator are told apart line by line."""

    DINERO = 0
    XDIN = 1
    RAMULATOR = 2
    LOAD_STORE = 3
    DRAMSIM3 = 4
    CSV = 5


class Format(NamedTuple):
    """A format as the command line knows it."""

    name: str
    language: Language
    line: str  # what a line looks like
    has_cycles: bool  # whether it says when accesses are made
    has_sizes: bool  # whether it says how many bytes they touch


FORMATS = (
    Format("dinero", Language.DINERO, dinero.LINE, False, True),
    Format("xdin", Language.XDIN, dinero.LINE, False, True),
    Format("ramulator", Language.RAMULATOR, ramulator.LINE, False, False),
    Format("ramulator2", Language.LOAD_STORE, ramulator.LINE, False, False),
    Format("dramsim3", Language.DRAMSIM3, dramsim3.LINE, True, False),
    Format("csv", Language.CSV, table.LINE, True, True),
)
LONGEST_LINE = 100  # bytes that an access takes in any format


class Scanned(NamedTuple):
    """What became of a text."""

    num_accesses: int
    problem: int | np.integer  # Problem
    line: int  # of the problem, from 0
    place: int  # of the problem in the text


def format_named(name: str) -> Format:
    """The format of that name. ArchsimError if there is none."""
    for known in FORMATS:
        if known.name == name:
            return known
    names = [known.name for known in FORMATS]
    raise fail(
        f"no format is named '{name}'", hint=did_you_mean(name, names) or f"there are: {', '.join(names)}"
    )


@compiled
def parse(language, columns, text, accesses, earliest):
    """Fill the accesses from a text whose cycles begin at `earliest`; `columns` are those of a table."""
    count = line = at = 0
    while at < len(text):
        at = skip_blanks(text, at)
        if text[at] != NEWLINE:
            access = accesses[count]
            begin = at
            if language <= Language.XDIN:
                problem, at = dinero.scan_line(text, at, access)
            elif language <= Language.LOAD_STORE:
                problem, at = ramulator.scan_line(text, at, access)
            elif language == Language.DRAMSIM3:
                problem, at = dramsim3.scan_line(text, at, access)
            else:
                problem, at = table.scan_line(text, at, access, columns)
            if problem == Problem.NONE and access["cycle"] < earliest:
                problem, at = np.int64(Problem.BACKWARDS), begin
            if problem != Problem.NONE:
                return Scanned(count, problem, line, at)
            earliest = access["cycle"]
            count += 1
        at = next_line(text, at)
        line += 1
    return Scanned(count, np.int64(Problem.NONE), line, at)


@compiled
def put(language, accesses, text):
    """Write the accesses, a line each; returns the length of the text."""
    at = 0
    for i in range(len(accesses)):
        access = accesses[i]
        if language == Language.DINERO:
            at = dinero.put_din(text, at, access)
        elif language == Language.XDIN:
            at = dinero.put_xdin(text, at, access)
        elif language == Language.RAMULATOR:
            at = ramulator.put_line(text, at, access)
        elif language == Language.LOAD_STORE:
            at = ramulator.put_load_store(text, at, access)
        elif language == Language.DRAMSIM3:
            at = dramsim3.put_line(text, at, access)
        else:
            at = table.put_line(text, at, access)
    return at
