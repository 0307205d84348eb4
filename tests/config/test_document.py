"""YAML text: values with their places, and an error with a place for everything that is not a tree of values."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from archsim.config.document import MAX_BYTES, MAX_DEPTH, dump, parse, read_document
from archsim.errors import ArchsimError, Location, Problem


def parsed(text: str):
    return parse(text, lambda mark: Location("f", mark.line + 1, mark.column + 1), Path())


def found_wrong(function: Callable[..., object], *arguments: object) -> list[Problem]:
    """The problems that a call ends with; any other exception fails the test."""
    try:
        function(*arguments)
    except ArchsimError as error:
        return error.problems
    return []


def test_every_key_and_value_knows_its_place():
    tree = parsed("a: 1\nb:\n  - {c: x}\n")
    item = tree.value["b"].value[0]
    assert (tree.value["a"].key, tree.value["a"].where) == (Location("f", 1, 1), Location("f", 1, 4))
    assert (item.key, item.where) == (None, Location("f", 3, 5))
    assert item.value["c"].where == Location("f", 3, 9)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("yes", "yes"),
        ("on", "on"),
        ("true", True),
        ("~", None),
        ("", None),
        ("010", 10),
        ("1e9", 1e9),
        ("-.5", -0.5),
        ("1_000", "1_000"),
        ("1:30", "1:30"),
        ("2004-01-01", "2004-01-01"),
        ("'5'", "5"),
        ("-.inf", float("-inf")),
        ("<<", "<<"),
    ],
)
def test_scalars_are_those_of_yaml_1_2(text, value):
    found = parsed(f"a: {text}").value["a"].value
    assert found == value
    assert type(found) is type(value)


def test_aliases_repeat_a_value():
    assert parsed("a: &x [1, 2]\nb: *x").plain() == {"a": [1, 2], "b": [1, 2]}


BOMB = "a: &a [1,1,1,1,1,1,1,1,1,1]\n" + "".join(
    f"{name}: &{name} [{','.join(['*' + before] * 10)}]\n"
    for before, name in zip("abcd", "bcde", strict=True)
)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: 1\na: 2", "f:2:1: the key 'a' is written twice; first at f:1:1"),
        ("5: x", "f:1:1: a key must be text, not '5'; write \"5\" in quotes"),
        ("[1]: x", "f:1:1: a key must be text, not a list or mapping"),
        ("a:\n\tb: 1", "f:2:1: a tab can't be used here; indent with spaces"),
        ("a: b: c", "f:1:5: a ':' is not allowed here; check the indentation, or quote the text"),
        ("a: 1\n---\nb: 2", "f:2:1: a second document starts here; write one file for each"),
        ("a: *b", "f:1:4: not valid YAML: found undefined alias 'b'"),
        ("a: &a [*a]", f"f:1:4: more than {MAX_DEPTH} levels deep"),
        ("[" * 10_000, f"f:1:{MAX_DEPTH + 2}: more than {MAX_DEPTH} levels deep"),
        ("- " * 3_000 + "x", f"f:1:{2 * MAX_DEPTH + 3}: more than {MAX_DEPTH} levels deep"),
        (
            "a: !!python/name:os.system",
            "f:1:4: the tag 'tag:yaml.org,2002:python/name:os.system' is not supported",
        ),
        ("a: !!int x", "f:1:4: the tag 'tag:yaml.org,2002:int' is not supported"),
        ("a: !new {}", "f:1:4: the tag '!new' is not supported"),
        ("a: \x00", "f:1:4: the character U+0000 is not allowed"),
        ('a: "\\ud800"', "f:1:4: text with half a surrogate pair"),
        ("a: " + "9" * 5000, "f:1:4: a number of 5000 characters is too long"),
    ],
)
def test_what_is_not_a_tree_of_values_is_an_error_with_a_place(text, message):
    with pytest.raises(ArchsimError) as error:
        parsed(text)
    assert str(error.value) == message


def test_an_alias_bomb_is_an_error():
    with pytest.raises(ArchsimError, match=r"f:\d+:\d+: more than 20000 values in one document"):
        parsed(BOMB)


def test_all_problems_of_a_text_come_at_once():
    with pytest.raises(ArchsimError) as error:
        parsed("a: 1\na: 2\n3: 4\nb: !x 5\n")
    assert [problem.where.line for problem in error.value.problems] == [2, 3, 4]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"a: \xff", "f.yaml:1:4: not UTF-8 text: byte 0xff"),
        (b"a: 1\nb: \xc3\xa9\xe9", "f.yaml:2:5: not UTF-8 text: byte 0xe9"),
        (b"", "f.yaml: the file is empty"),
        (b"# nothing\n", "f.yaml: the file is empty"),
        (b"a: " + b"x" * MAX_BYTES, "f.yaml: larger than 256 KiB, too large for a configuration"),
    ],
)
def test_files_that_are_not_configurations(write, problems, content, message):
    name = write("f.yaml", content)
    assert problems(read_document, Path(name), name) == [message]


def test_folders_devices_and_nothing(write, problems):
    write("folder/f.yaml", "a: 1")
    assert problems(read_document, Path("folder"), "x") == ["x: a folder or device, not a file"]
    assert problems(read_document, Path("/dev/zero"), "x") == ["x: a folder or device, not a file"]
    assert problems(read_document, Path("none.yaml"), "x") == ["x: no such file"]


def test_a_byte_order_mark_and_windows_lines_are_fine(write):
    name = write("f.yaml", b"\xef\xbb\xbfa: 1\r\nb: 2\r\n")
    assert read_document(Path(name), name).plain() == {"a": 1, "b": 2}


@given(st.binary(max_size=200))
def test_junk_is_a_tree_or_an_archsim_error(tmp_path_factory, content):
    path = tmp_path_factory.getbasetemp() / "junk.yaml"
    path.write_bytes(content)
    assert all(each.where.file == "junk" for each in found_wrong(read_document, path, "junk"))


@given(st.text(alphabet="ab:-[]{}&*!|>'\"%@`#?,\\ \n\tx0u", max_size=60))
def test_yaml_like_junk_is_a_tree_or_an_archsim_error(text):
    assert all(each.where.line > 0 for each in found_wrong(parsed, text))


_TEXT = st.text(st.characters(codec="utf-8", exclude_categories=("Cs", "Cc")), max_size=20)
_SCALARS = st.none() | st.booleans() | st.integers(-(10**30), 10**30) | st.floats(allow_nan=False) | _TEXT
_TREES = st.recursive(
    _SCALARS,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(_TEXT, inner, max_size=4),
    max_leaves=12,
)


@given(_TREES)
def test_what_is_dumped_is_parsed_back(data):
    assert parsed(dump({"data": data})).plain() == {"data": data}
