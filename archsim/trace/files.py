"""Address traces in files, plain or compressed by gzip: read and written in bounded memory."""

from __future__ import annotations

import gzip
import zlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

import numpy as np

from archsim.errors import ArchsimError, Location, fail
from archsim.trace.accesses import ACCESS, Accesses
from archsim.trace.formats import table
from archsim.trace.formats.languages import LONGEST_LINE, Format, Language, parse, put
from archsim.trace.formats.scan import MESSAGES, NEWLINE, Problem

BLOCK_BYTES = 1 << 22  # read at once
_GZIP = b"\x1f\x8b"
_SHOWN = 60  # characters of a bad line that a message shows
_PUT_AT_ONCE = 1 << 16  # accesses


def read_accesses(path: Path, form: Format, block_bytes: int = BLOCK_BYTES) -> Accesses:
    """The accesses of a trace, in chunks. ArchsimError `file:line:column` for a line that is not one."""
    columns = np.zeros(0, np.int64)
    earliest, first_line = 0, 1
    for text in _texts(path, block_bytes):
        if form.language == Language.CSV and not len(columns):
            columns, text = _header(path, text)
            first_line += 1
        num_lines = int(np.count_nonzero(text == NEWLINE))
        accesses = np.empty(num_lines, ACCESS)
        scanned = parse(int(form.language), columns, text, accesses, earliest)
        if scanned.problem != Problem.NONE:
            raise _bad_line(
                Location(str(path), first_line + scanned.line), form, text, scanned.problem, scanned.place
            )
        first_line += num_lines
        if scanned.num_accesses:
            accesses = accesses[: scanned.num_accesses]
            earliest = int(accesses[-1]["cycle"])
            yield accesses


class TraceWriter:
    """Writes accesses to an open trace."""

    def __init__(self, stream: BinaryIO | gzip.GzipFile, form: Format):
        self.stream, self.form, self.count = stream, form, 0
        self._text = np.empty(_PUT_AT_ONCE * LONGEST_LINE, np.uint8)
        if form.language == Language.CSV:
            stream.write(f"{table.HEADER}\n".encode("ascii"))

    def write(self, accesses: np.ndarray) -> None:
        """Add lines for ACCESS records, whose cycles must not fall."""
        for begin in range(0, len(accesses), _PUT_AT_ONCE):
            part = np.ascontiguousarray(accesses[begin : begin + _PUT_AT_ONCE])
            self.stream.write(self._text[: put(int(self.form.language), part, self._text)].tobytes())
        self.count += len(accesses)


@contextmanager
def trace_writer(path: Path, form: Format) -> Iterator[TraceWriter]:
    """A trace to be written, compressed if its name ends in .gz; a file that fails on the way is removed."""
    unfinished = path.with_name(f".{path.name}-unfinished")
    try:
        with unfinished.open("wb") as raw:
            if path.suffix != ".gz":
                yield TraceWriter(raw, form)
            else:  # without a time and a name, so that the same accesses give the same bytes
                with gzip.GzipFile("", "wb", 6, raw, 0) as stream:
                    yield TraceWriter(stream, form)
        unfinished.replace(path)
    except OSError as error:
        raise fail(f"cannot be written: {error.strerror or error}", Location(str(path))) from None
    finally:
        unfinished.unlink(missing_ok=True)


def write_accesses(path: Path, form: Format, chunks: Iterable[np.ndarray]) -> int:
    """Write a whole trace; returns the number of accesses."""
    with trace_writer(path, form) as writer:
        for chunk in chunks:
            writer.write(chunk)
    return writer.count


def _texts(path: Path, block_bytes: int) -> Iterator[np.ndarray]:
    """The bytes of a file in blocks of whole lines, the last line ended too."""
    rest = b""
    try:
        with path.open("rb") as raw:
            is_compressed = raw.read(2) == _GZIP
            raw.seek(0)
            stream: BinaryIO | gzip.GzipFile = gzip.GzipFile(fileobj=raw) if is_compressed else raw
            while block := stream.read(block_bytes):
                end = block.rfind(b"\n") + 1
                if end:
                    yield np.frombuffer(rest + block[:end], np.uint8)
                    rest = b""
                rest += block[end:]
                if len(rest) > max(block_bytes, BLOCK_BYTES):
                    raise fail("is not an address trace: it holds a line of megabytes", Location(str(path)))
    except (OSError, EOFError, zlib.error) as error:
        what = getattr(error, "strerror", None) or error
        raise fail(f"cannot be read: {what}", Location(str(path))) from None
    if rest:
        yield np.frombuffer(rest + b"\n", np.uint8)


def _header(path: Path, text: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Columns of a table, and the text below its header."""
    end = int(np.argmax(text == NEWLINE)) + 1
    header = bytes(text[:end]).decode("utf-8", "replace").strip()
    return table.columns_of(header, Location(str(path), 1)), text[end:]


def _bad_line(where: Location, form: Format, text: np.ndarray, problem: int, place: int) -> ArchsimError:
    """The problem with the line of this place, and what a line should look like."""
    before = bytes(text[:place])
    begin = before.rfind(b"\n") + 1
    end = place + bytes(text[place : place + _SHOWN]).find(b"\n")
    line = bytes(text[begin : end if end >= place else place + _SHOWN]).decode("utf-8", "replace").rstrip()
    shown = "".join(letter if letter.isprintable() else "?" for letter in line[:_SHOWN])
    what = f"{MESSAGES[Problem(problem)]}: '{shown}'"
    return fail(
        what, where._replace(column=place - begin + 1), f"a line of the format '{form.name}' is {form.line}"
    )
