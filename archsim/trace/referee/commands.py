"""A trace of DRAM commands, read line by line: `clock,channel,command,bank,row,column` below a header that says so."""

from __future__ import annotations

import gzip
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, NamedTuple

from archsim.errors import Location, did_you_mean, fail

HEADER = "clock,channel,command,bank,row,column"
NEEDED = {
    "ACT": 2,
    "PRE": 1,
    "PREA": 0,
    "RD": 3,
    "WR": 3,
    "REF": 0,
}  # how many of bank, row, column a command has
LARGEST = 2**62
_GZIP = b"\x1f\x8b"
_LONGEST_LINE = 200


class Issued(NamedTuple):
    """A command that a channel issued; -1 where it has no bank, row or column."""

    line: int  # of the file
    clock: int
    channel: int
    command: str
    bank: int
    row: int
    column: int  # in beats, of the burst's first


def read_commands(path: Path) -> Iterator[Issued]:
    """The commands of a file, plain or compressed by gzip. ArchsimError `file:line` for a line that is not one."""
    try:
        with path.open("rb") as raw:
            is_compressed = raw.read(2) == _GZIP
            raw.seek(0)
            yield from _parsed(gzip.GzipFile(fileobj=raw) if is_compressed else raw, str(path))
    except (OSError, EOFError, zlib.error) as error:
        what = getattr(error, "strerror", None) or error
        raise fail(f"cannot be read: {what}", Location(str(path))) from None


def _parsed(stream: BinaryIO | gzip.GzipFile, name: str) -> Iterator[Issued]:
    header = stream.readline(_LONGEST_LINE).decode("utf-8", "replace").strip()
    if header.replace(" ", "") != HEADER:
        raise fail(f"must begin with the header {HEADER}", Location(name, 1))
    number = 1
    while text := stream.readline(_LONGEST_LINE):
        number += 1
        line = text.decode("utf-8", "replace").strip()
        if line:
            yield _command(line, Location(name, number))


def _command(text: str, where: Location) -> Issued:
    """The command that a line holds."""
    parts = [part.strip() for part in text.split(",")]
    if len(parts) != HEADER.count(",") + 1:
        raise fail(f"must be {HEADER}, not {text[:60]!r}", where)
    command = parts[2]
    if command not in NEEDED:
        names = list(NEEDED)
        hint = did_you_mean(command.upper(), names) or f"there are {', '.join(names)}"
        raise fail(f"no command is named {command[:20]!r}", where, hint)
    clock, channel = (_number(parts[i], HEADER.split(",")[i], where) for i in (0, 1))
    place = [-1, -1, -1]
    for i in range(NEEDED[command]):
        place[i] = _number(parts[3 + i], f"{HEADER.split(',')[3 + i]} of {command}", where)
    return Issued(where.line, clock, channel, command, *place)


def _number(text: str, name: str, where: Location) -> int:
    if not (text.isascii() and text.isdigit() and len(text) < 20 and int(text) <= LARGEST):
        raise fail(f"{name} must be a whole number, not {text[:20]!r}", where)
    return int(text)
