"""Every text format: what each line means, what is refused and where, and that what is written reads back."""

import gzip
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from archsim.errors import ArchsimError
from archsim.trace.accesses import ACCESS, Kind
from archsim.trace.files import read_accesses, write_accesses
from archsim.trace.formats.languages import FORMATS, format_named

NAMES = [form.name for form in FORMATS]
R, W, F = Kind.READ, Kind.WRITE, Kind.FETCH


def read(path, name, **options):
    """The whole trace as (cycle, address, bytes, requester, kind) tuples."""
    return [
        access for chunk in read_accesses(path, format_named(name), **options) for access in chunk.tolist()
    ]


@pytest.fixture
def reads(tmp_path):
    def parsed(name, text):
        path = tmp_path / "a.trace"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read(path, name)

    return parsed


@pytest.mark.parametrize(
    ("name", "line", "access"),
    [
        ("dinero", "0 1000", (0, 0x1000, 4, 0, R)),
        ("dinero", "1 70f60888", (0, 0x70F60888, 4, 0, W)),
        ("dinero", "2 2cb5", (0, 0x2CB4, 4, 0, F)),  # words only
        ("dinero", "3 0x10", (0, 0x10, 4, 0, R)),
        ("dinero", " \t1   0XaB  2 3 a comment, and more\r", (0, 0xA8, 4, 0, W)),
        ("xdin", "r 1001 3", (0, 0x1001, 3, 0, R)),
        ("dinero", "W 0x1001 0x10 comment", (0, 0x1001, 16, 0, W)),
        ("xdin", "i ff ffff", (0, 0xFF, 0xFFFF, 0, F)),
        ("xdin", "M 0 1", (0, 0, 1, 0, R)),
        ("ramulator", "0x12345680 R", (0, 0x12345680, 1, 0, R)),
        ("ramulator", "4cbd56c0 W", (0, 0x4CBD56C0, 1, 0, W)),
        ("ramulator", "LD 0x10", (0, 16, 1, 0, R)),
        ("ramulator2", "ST 10 ", (0, 10, 1, 0, W)),
        ("ramulator2", "LD 0X1f\r", (0, 31, 1, 0, R)),
        ("dramsim3", "0xff READ 7", (7, 255, 1, 0, R)),
        ("dramsim3", "ff write 7", (7, 255, 1, 0, W)),
        ("dramsim3", "0xff P_MEM_WR 0", (0, 255, 1, 0, W)),
        ("dramsim3", "0xff P_FETCH 12345678901", (12345678901, 255, 1, 0, F)),
        ("dramsim3", "3fffffffffffffff\tBOFF\t1", (1, 2**62 - 1, 1, 0, W)),
    ],
)
def test_what_a_line_means(reads, name, line, access):
    assert reads(name, line) == [access]
    assert reads(name, f"\n{line}\n \n\r\n{line}\n") == [access, access]  # empty lines say nothing


@pytest.mark.parametrize(
    ("text", "access"),
    [
        ("cycle,address,kind,bytes,requester\n5,0x10,write,8,3", (5, 16, 8, 3, W)),
        ("kind, address\nfetch , 32", (0, 32, 1, 0, F)),
        ("requester,kind,cycle,address\r\n32767,read,1,0xff\r\n", (1, 255, 1, 32767, R)),
    ],
)
def test_a_table_means_what_its_header_says(reads, text, access):
    assert reads("csv", text) == [access]


@pytest.mark.parametrize(
    ("name", "line", "place", "what"),
    [
        ("dinero", "4 1000", 1, "not a kind of access: '4 1000'"),
        ("dinero", "c 1000 10", 1, "not a kind of access"),
        ("dinero", "00 1000", 1, "not a kind of access"),
        ("dinero", "-1 1000", 1, "not a kind of access"),
        ("dinero", "0", 2, "the line ends too early"),
        ("dinero", "0 ", 3, "the line ends too early"),
        ("dinero", "0 10x0", 3, "not a number in hexadecimal digits"),
        ("dinero", "0 0x", 3, "not a number in hexadecimal digits"),
        ("dinero", "0 -10", 3, "not a number in hexadecimal digits"),
        ("dinero", "0 4000000000000000", 3, "the number is too large"),
        ("dinero", "r 10", 5, "the line ends too early"),
        ("dinero", "r 10 0", 6, "an access has at least 1 byte"),
        ("dinero", "r 10 10000", 6, "the number is too large"),
        ("dinero", "r 10 zz", 6, "not a number in hexadecimal digits"),
        ("dinero", "read 10 4", 1, "not a kind of access"),
        ("ramulator", "R 0,0,1,2", 1, "not a number in hexadecimal digits"),  # Ramulator 2's address vectors
        ("ramulator", "0x10", 5, "the line ends too early"),
        ("ramulator", "0x10 RW", 6, "not a kind of access"),
        ("ramulator", "0x10 r", 6, "not a kind of access"),
        ("ramulator", "0x10 R 3", 8, "something follows"),
        ("ramulator", "10 20 W", 4, "not a kind of access"),
        ("ramulator", "LD", 3, "the line ends too early"),
        ("ramulator", "LD 1f", 4, "not a number"),
        ("ramulator", "LD 9999999999999999999999", 4, "the number is too large"),
        ("ramulator", "ld 0x10", 1, "not a number in hexadecimal digits"),
        ("dramsim3", "0x10 READ", 10, "the line ends too early"),
        ("dramsim3", "0x10 READS 1", 6, "not a kind of access"),
        ("dramsim3", "0x10 P_MEM_WRITE 1", 6, "not a kind of access"),
        ("dramsim3", "0x10 READ 1.5", 11, "not a number"),
        ("dramsim3", "0x10 READ 0x1", 11, "not a number"),
        ("dramsim3", "0x10 READ 1 2", 13, "something follows"),
        ("dramsim3", "\x00\x01\x02", 1, "not a number in hexadecimal digits"),
    ],
)
def test_a_malformed_line_is_named(reads, tmp_path, name, line, place, what):
    good = {"dinero": "0 10", "ramulator": "0x10 R", "dramsim3": "0x10 READ 0"}[name]

    with pytest.raises(ArchsimError) as caught:
        reads(name, f"{good}\n\n{line}\n{good}\n")

    message = str(caught.value)
    assert message.startswith(f"{tmp_path}/a.trace:3:{place}: {what}")
    assert f"a line of the format '{name}' is " in message


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("", ""),
        ("cycle,adress,kind\n", "1: no column is named 'adress'; did you mean 'address'?"),
        ("5,0x10,write,8,3\n", "1: no column is named '5'"),
        ("cycle,address\n", "1: column 'kind' is missing"),
        ("kind,address,kind\n", "1: column 'kind' stands there twice"),
        ("address,kind\n1,read\n2\n", "3:2: the line ends too early"),
        ("address,kind\n1 read\n", "2:3: something follows"),
        ("address,kind\n1,read,\n", "2:7: something follows"),
        ("address,kind\n,read\n", "2:1: the line ends too early"),
        ("address,kind\n1,READ\n", "2:3: not a kind of access"),
        ("address,kind,bytes\n1,read,0\n", "2:8: an access has at least 1 byte"),
        ("address,kind,bytes\n1,read,2147483648\n", "2:8: the number is too large"),
        ("address,kind,requester\n1,read,32768\n", "2:8: the number is too large"),
        ("address,kind,cycle\n1,read,5\n1,read,4\n", "3:1: the cycle lies before"),
    ],
)
def test_a_malformed_table_is_named(reads, tmp_path, text, what):
    if not text:
        assert reads("csv", text) == []
        return
    with pytest.raises(ArchsimError) as caught:
        reads("csv", text)
    assert str(caught.value).startswith(f"{tmp_path}/a.trace:{what}")


def test_cycles_go_forward_across_blocks(tmp_path):
    path = tmp_path / "a.trace"
    path.write_text("0x10 READ 5\n0x10 READ 4\n")
    with pytest.raises(ArchsimError, match=r"a\.trace:2:1: the cycle lies before that of the line before"):
        read(path, "dramsim3", block_bytes=12)


def test_an_unprintable_line_is_shown_safely(reads):
    with pytest.raises(ArchsimError) as caught:
        reads("dinero", b"\xff\x1b[31m" * 200 + b"\n")
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 400


def test_files_that_are_no_traces(tmp_path):
    with pytest.raises(ArchsimError, match=r"none\.din: cannot be read: No such file"):
        read(tmp_path / "none.din", "dinero")
    with pytest.raises(ArchsimError, match="cannot be read: Is a directory"):
        read(tmp_path, "dinero")
    path = tmp_path / "a.gz"
    path.write_bytes(gzip.compress(b"0 10\n" * 1000)[:-20])
    with pytest.raises(ArchsimError, match=r"a\.gz: cannot be read: "):
        read(path, "dinero")
    path.write_bytes(b"0" * (9 << 20))
    with pytest.raises(ArchsimError, match="a line of megabytes"):
        read(path, "dinero")


def test_an_unknown_format_is_named():
    with pytest.raises(ArchsimError, match="no format is named 'dramsim'; did you mean 'dramsim3'"):
        format_named("dramsim")


@pytest.mark.parametrize("block_bytes", [1, 2, 7, 16, 1000])
@pytest.mark.parametrize("last", ["", "\n", "\r\n"])
def test_blocks_may_end_anywhere(tmp_path, block_bytes, last):
    path = tmp_path / "a.din"
    path.write_text("\n".join(f"{i % 3} {i * 4:x}" for i in range(50)) + last)

    assert [access[1] for access in read(path, "dinero", block_bytes=block_bytes)] == [
        i * 4 for i in range(50)
    ]


def accesses_of(form):
    """Accesses that the format can say."""
    kinds = st.sampled_from([R, W] if form.name in ("ramulator", "ramulator2", "dramsim3") else [R, W, F])
    sizes = {"dinero": st.just(4), "xdin": st.integers(1, 0xFFFF), "csv": st.integers(1, 2**31 - 1)}
    addresses = st.integers(0, 2**62 - 1)
    return st.tuples(
        st.integers(0, 2**40) if form.has_cycles else st.just(0),
        addresses.map(lambda a: a & ~3) if form.name == "dinero" else addresses,
        sizes.get(form.name, st.just(1)),
        st.integers(0, 2**15 - 1) if form.name == "csv" else st.just(0),
        kinds,
    )


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("suffix", ["", ".gz"])
@settings(max_examples=40, deadline=None)
@given(data=st.data(), block_bytes=st.sampled_from([1, 50, 1 << 20]))
def test_what_is_written_reads_back(name, suffix, data, block_bytes, tmp_path_factory):
    form = format_named(name)
    listed = sorted(data.draw(st.lists(accesses_of(form), max_size=30)), key=lambda access: access[0])
    path = Path(tmp_path_factory.getbasetemp()) / f"round{suffix}"
    half = len(listed) // 2
    chunks = [np.array(part, ACCESS) for part in (listed[:half], listed[half:])]

    assert write_accesses(path, form, chunks) == len(listed)
    assert read(path, name, block_bytes=block_bytes) == listed
    if suffix:
        assert gzip.decompress(path.read_bytes()) is not None
        written = path.read_bytes()
        write_accesses(path, form, chunks)
        assert path.read_bytes() == written


def test_a_trace_that_cannot_be_written(tmp_path):
    with pytest.raises(ArchsimError, match="cannot be written: No such file"):
        write_accesses(tmp_path / "no" / "a.din", format_named("dinero"), [])
