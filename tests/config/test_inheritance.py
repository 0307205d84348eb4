"""Bases and overrides: what the merged tree holds, and where everything that goes wrong is said to be."""

from __future__ import annotations

import pytest

from archsim.config.inheritance import MAX_BASES, load_tree
from archsim.errors import ArchsimError


def plain(path: str, *overrides: str, sections: tuple[str, ...] = ()) -> object:
    return load_tree(path, overrides, sections).plain()


def test_mappings_merge_and_all_else_replaces(write):
    write("base.yaml", "a: {x: 1, y: {p: 1, q: 2}}\nlist: [1, 2, 3]\nb: 5\n")
    write("top.yaml", "base: base.yaml\na: {y: {q: 9}}\nlist: [4]\nb: {c: 1}\n")
    assert plain("top.yaml") == {"a": {"x": 1, "y": {"p": 1, "q": 9}}, "list": [4], "b": {"c": 1}}


def test_a_base_is_relative_to_the_file_that_names_it(write):
    write("one/base.yaml", "a: 1")
    write("one/middle.yaml", "base: base.yaml\nb: 2")
    write("top.yaml", "base: one/middle.yaml\nc: 3")
    assert plain("top.yaml") == {"a": 1, "b": 2, "c": 3}


def test_packaged_files_are_bases_from_anywhere(write):
    write("top.yaml", "base: machines/tiny.yaml\nname: mine")
    assert plain("top.yaml")["clocks"] == {"core": "1 GHz", "memory": "1 GHz"}


def test_a_file_nearby_comes_before_a_packaged_one(write):
    write("machines/tiny.yaml", "a: 1")
    write("top.yaml", "base: machines/tiny.yaml")
    assert plain("top.yaml") == {"a": 1}


def test_any_mapping_may_have_a_base_even_in_a_list(write):
    write("light.yaml", "position: [1, 2, 3]\nview: {x: 1}")
    write("top.yaml", "lights:\n- base: light.yaml\n- {base: light.yaml, position: [4]}")
    assert plain("top.yaml")["lights"] == [
        {"position": [1, 2, 3], "view": {"x": 1}},
        {"position": [4], "view": {"x": 1}},
    ]


def test_a_text_is_a_base_only_in_a_section(write):
    write("machine.yaml", "a: 1")
    write("top.yaml", "machine: machine.yaml\nname: machine.yaml")
    assert plain("top.yaml", sections=("machine",)) == {"machine": {"a": 1}, "name": "machine.yaml"}
    assert plain("top.yaml") == {"machine": "machine.yaml", "name": "machine.yaml"}


def test_a_section_of_a_base_merges_and_one_with_its_own_base_starts_afresh(write):
    write("m1.yaml", "a: 1\nb: 1")
    write("m2.yaml", "c: 2")
    write("base.yaml", "machine: m1.yaml")
    write("merged.yaml", "base: base.yaml\nmachine: {b: 9}")
    write("afresh.yaml", "base: base.yaml\nmachine: m2.yaml")
    write("mixed.yaml", "base: base.yaml\nmachine: {base: m2.yaml, d: 3}")
    assert plain("merged.yaml", sections=("machine",)) == {"machine": {"a": 1, "b": 9}}
    assert plain("afresh.yaml", sections=("machine",)) == {"machine": {"c": 2}}
    assert plain("mixed.yaml", sections=("machine",)) == {"machine": {"c": 2, "d": 3}}


def test_merged_values_keep_the_place_where_they_are_written(write):
    write("base.yaml", "a: {x: 1,\n    y: 2}")
    write("top.yaml", "base: base.yaml\na:\n  x: 3")
    children = load_tree("top.yaml", ()).value["a"].value
    assert str(children["x"].where) == "top.yaml:3:6"
    assert str(children["y"].where) == "base.yaml:2:8"


def test_all_missing_bases_come_at_once_with_what_may_have_been_meant(write, problems):
    write("scene.yaml", "a: 1")
    write("folder/f.yaml", "a: 1")
    write(
        "top.yaml", "a: {base: scen.yaml}\nb: {base: machines/johnson.yaml}\nc: {base: folder}\nd: {base: 5}"
    )
    assert problems(load_tree, "top.yaml", ()) == [
        "top.yaml:1:11: no such file: 'scen.yaml'; did you mean 'scene.yaml'?",
        "top.yaml:2:11: no such file: 'machines/johnson.yaml'; did you mean 'machines/johnson2004.yaml'?",
        "top.yaml:3:11: a folder, not a file: 'folder'",
        "top.yaml:4:11: base must be the path of a file",
    ]


def test_a_missing_file_at_the_top(write, problems):
    write("scene.yaml", "a: 1")
    assert problems(load_tree, "scene.yml", ()) == ["no such file: 'scene.yml'; did you mean 'scene.yaml'?"]
    assert problems(load_tree, "a\0b", ()) == ["no such file: 'a\0b'"]


def test_circles_are_errors(write, problems):
    write("a.yaml", "base: b.yaml")
    write("b.yaml", "x: {base: a.yaml}")
    write("self.yaml", "base: ./self.yaml")
    assert problems(load_tree, "a.yaml", ()) == ["b.yaml:1:11: bases in a circle: a.yaml -> b.yaml -> a.yaml"]
    assert problems(load_tree, "self.yaml", ()) == [
        "self.yaml:1:7: bases in a circle: self.yaml -> self.yaml"
    ]


def test_one_file_may_be_a_base_twice(write):
    write("leaf.yaml", "a: 1")
    write("top.yaml", "x: {base: leaf.yaml}\ny: {base: leaf.yaml}")
    assert plain("top.yaml") == {"x": {"a": 1}, "y": {"a": 1}}


def test_rows_of_bases_have_a_limit(write, problems):
    for index in range(MAX_BASES + 2):
        write(f"{index}.yaml", f"base: {index + 1}.yaml")
    [problem] = problems(load_tree, "0.yaml", ())
    assert problem == f"{MAX_BASES}.yaml:1:7: more than {MAX_BASES} bases in a row"


def test_a_flood_of_bases_ends(write, problems):
    for index in range(7):
        children = ", ".join(f"k{child}: {{base: {index + 1}.yaml}}" for child in range(20))
        write(f"{index}.yaml", f"{{{children}}}")
    write("7.yaml", "a: 1")
    assert "more than 20000 values, bases included" in problems(load_tree, "0.yaml", ())[0]


def test_problems_inside_bases_are_said_there(write, problems):
    write("base.yaml", "a: 1\na: 2")
    write("list.yaml", "[1]")
    write("top.yaml", "x: {base: base.yaml}\ny: {base: list.yaml}")
    assert problems(load_tree, "top.yaml", ()) == [
        "base.yaml:2:1: the key 'a' is written twice; first at base.yaml:1:1",
        "top.yaml:2:11: 'list.yaml' holds no keys, so it can't be a base",
    ]


@pytest.mark.parametrize(
    ("override", "value"),
    [
        ("a.b=5", {"a": {"b": 5, "c": [1, {"d": 2}]}}),
        ("a.c.1.d=x", {"a": {"b": 1, "c": [1, {"d": "x"}]}}),
        ("a.c=[]", {"a": {"b": 1, "c": []}}),
        ("a={e: 1}", {"a": {"e": 1}}),
        ("a.b.f=1", {"a": {"b": {"f": 1}, "c": [1, {"d": 2}]}}),
        ("z= a=b", {"a": {"b": 1, "c": [1, {"d": 2}]}, "z": "a=b"}),
        ("a.b=null", {"a": {"b": None, "c": [1, {"d": 2}]}}),
        ("a={base: leaf.yaml}", {"a": {"leaf": 1}}),
    ],
)
def test_an_override_puts_a_value_in_its_place(write, override, value):
    write("leaf.yaml", "leaf: 1")
    write("top.yaml", "a: {b: 1, c: [1, {d: 2}]}")
    assert plain("top.yaml", override) == value


def test_overrides_apply_in_order_to_the_merged_tree(write):
    write("one.yaml", "a: 1")
    write("two.yaml", "b: [1, 2]")
    write("top.yaml", "machine: one.yaml")
    merged = plain("top.yaml", "machine=two.yaml", "machine.b.0=9", sections=("machine",))
    assert merged == {"machine": {"b": [9, 2]}}


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("a", "an override is written dotted.path=value"),
        ("=1", "an override is written dotted.path=value"),
        ("a..b=1", "an override is written dotted.path=value"),
        ("a=", "no value after '='; write null for nothing"),
        ("list.2=1", "'2' is not an index of a list of 2; they count from 0"),
        ("list.-1=1", "'-1' is not an index of a list of 2; they count from 0"),
        ("list.x=1", "'x' is not an index of a list of 2; they count from 0"),
        (
            "list.99999999999999999999=1",
            "'99999999999999999999' is not an index of a list of 2; they count from 0",
        ),
        ("a={b: 1, b: 2}", "the key 'b' is written twice; first at --set a={b: 1, b: 2}"),
        ("a={base: none.yaml}", "no such file: 'none.yaml'"),
    ],
)
def test_wrong_overrides_name_themselves(write, override, message):
    write("top.yaml", "list: [1, 2]")
    with pytest.raises(ArchsimError) as error:
        load_tree("top.yaml", [override])
    assert str(error.value) == f"--set {override}: {message}"
