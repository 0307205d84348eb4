"""Command traces are read strictly, and what is wrong is said at its line."""

import contextlib
import gzip

import pytest
from hypothesis import given
from hypothesis import strategies as st

from archsim.errors import ArchsimError
from archsim.trace.referee.commands import HEADER, Issued, read_commands

TEXT = f"{HEADER}\n0,1,ACT,2,3,\n\n13,1,RD,2,3,8\n30,0,PREA,,,\n40,0,REF,,,\n"
COMMANDS = [
    Issued(2, 0, 1, "ACT", 2, 3, -1),
    Issued(4, 13, 1, "RD", 2, 3, 8),
    Issued(5, 30, 0, "PREA", -1, -1, -1),
    Issued(6, 40, 0, "REF", -1, -1, -1),
]


def test_a_file_is_read(tmp_path):
    (tmp_path / "c.csv").write_text(TEXT)
    (tmp_path / "c.csv.gz").write_bytes(gzip.compress(TEXT.encode()))

    assert list(read_commands(tmp_path / "c.csv")) == COMMANDS
    assert list(read_commands(tmp_path / "c.csv.gz")) == COMMANDS


@pytest.mark.parametrize(
    ("line", "what"),
    [
        ("1,0,ACT,2,3", "must be clock,channel,command,bank,row,column, not '1,0,ACT,2,3'"),
        ("1,0,act,2,3,", "no command is named 'act'; did you mean 'ACT'?"),
        ("1,0,NOP,,,", "no command is named 'NOP'; there are ACT, PRE, PREA, RD, WR, REF"),
        ("x,0,REF,,,", "clock must be a whole number, not 'x'"),
        ("1,-1,REF,,,", "channel must be a whole number, not '-1'"),
        ("1,0,RD,1,2,", "column of RD must be a whole number, not ''"),
        ("1,0,ACT,1,\u0663,", "row of ACT must be a whole number, not '\u0663'"),
        ("99999999999999999999,0,REF,,,", "clock must be a whole number, not '99999999999999999999'"),
    ],
)
def test_what_is_wrong_is_said_at_its_line(tmp_path, line, what):
    (tmp_path / "c.csv").write_text(f"{HEADER}\n0,0,REF,,,\n{line}\n", encoding="utf-8")
    with pytest.raises(ArchsimError) as error:
        list(read_commands(tmp_path / "c.csv"))

    assert str(error.value) == f"{tmp_path / 'c.csv'}:3: {what}"


@pytest.mark.parametrize("text", ["", "0,0,REF,,,\n", "clock,channel\n"])
def test_the_header_is_needed(tmp_path, text):
    (tmp_path / "c.csv").write_text(text)
    with pytest.raises(ArchsimError, match=r":1: must begin with the header"):
        list(read_commands(tmp_path / "c.csv"))


def test_a_missing_or_broken_file_is_an_error(tmp_path):
    (tmp_path / "cut.gz").write_bytes(gzip.compress(TEXT.encode())[:-6])
    for name in ("nothing.csv", "cut.gz"):
        with pytest.raises(ArchsimError, match="cannot be read"):
            list(read_commands(tmp_path / name))


@given(st.binary(max_size=300))
def test_any_bytes_are_read_or_refused(tmp_path_factory, noise):
    path = tmp_path_factory.getbasetemp() / "noise.csv"
    path.write_bytes(HEADER.encode() + b"\n" + noise)
    with contextlib.suppress(ArchsimError):
        assert all(isinstance(command, Issued) for command in read_commands(path))
