"""From blocks to points, with hand-counted examples, and values that survive the way through YAML."""

from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from archsim.config import load_sweep
from archsim.config.document import parse
from archsim.errors import ArchsimError, Location
from archsim.sweep.expand import command, expand, flow, overrides, paths
from tests.config.conftest import problems, write  # noqa: F401
from tests.sweep.small import sweep


def points(*blocks, **changes):
    return expand(sweep(parameters=list(blocks), **changes))


def test_a_grid_has_all_combinations_and_the_last_key_runs_fastest():
    assert points({"grid": {"a": [1, 2], "b": [3, 4]}}) == [
        {"a": 1, "b": 3},
        {"a": 1, "b": 4},
        {"a": 2, "b": 3},
        {"a": 2, "b": 4},
    ]


def test_a_zip_goes_through_its_lists_together_and_a_list_one_by_one():
    assert points({"zip": {"a": [1, 2], "b": [3, 4]}}) == [{"a": 1, "b": 3}, {"a": 2, "b": 4}]
    assert points({"list": [{"a": 1}, {"b": 2}]}) == [{"a": 1}, {"b": 2}]


def test_blocks_are_multiplied_and_a_later_one_overrides():
    assert points({"grid": {"a": [1, 2]}}, {"list": [{"b": 3}, {"a": 9}]}) == [
        {"a": 1, "b": 3},
        {"a": 9},
        {"a": 2, "b": 3},
    ]


def test_a_condition_extends_only_the_points_that_fulfil_it():
    found = points({"grid": {"a": [1, 2, 3]}}, {"when": {"a": [1, 3]}, "grid": {"b": [7, 8]}})

    assert found == [{"a": 1, "b": 7}, {"a": 1, "b": 8}, {"a": 2}, {"a": 3, "b": 7}, {"a": 3, "b": 8}]
    with pytest.raises(ArchsimError, match="asks for 'c', which no block before it sets"):
        points({"grid": {"a": [1]}}, {"when": {"c": 1}, "grid": {"b": [7]}})


def test_seeds_repeat_every_point():
    assert points({"grid": {"a": [1, 2]}}, seeds=2) == [
        {"a": 1, "seed": 0},
        {"a": 1, "seed": 1},
        {"a": 2, "seed": 0},
        {"a": 2, "seed": 1},
    ]


def random_block(seed):
    values = {
        "n": {"low": 3, "high": 9},
        "x": {"low": 0.5, "high": 1},
        "p": {"low": 2, "high": 16, "scale": "powers_of_two"},
        "c": ["1 KiB", "2 KiB"],
    }
    return {"random": {"count": 40, "seed": seed, "values": values}}


@given(st.integers(0, 2**32 - 1))
def test_random_points_keep_to_their_ranges_and_seeds(seed):
    drawn = points(random_block(seed))

    assert drawn == points(random_block(seed))
    for point in drawn:
        assert 3 <= point["n"] <= 9
        assert isinstance(point["n"], int)
        assert 0.5 <= point["x"] <= 1
        assert point["p"] in (2, 4, 8, 16)
        assert point["c"] in ("1 KiB", "2 KiB")


def test_other_seeds_draw_other_points_and_all_powers_come():
    assert points(random_block(1)) != points(random_block(2))
    assert {point["p"] for point in points(random_block(1))} == {2, 4, 8, 16}


def test_braces_stand_for_several_keys():
    assert paths("a.{b,c}.d") == ["a.b.d", "a.c.d"]
    assert paths("{a, b}.{c,d}") == ["a.c", "a.d", "b.c", "b.d"]
    assert overrides({"a.{b,c}.d": "1 KiB", "e": [1, 2]}) == ["a.b.d=1 KiB", "a.c.d=1 KiB", "e=[1, 2]"]


texts = st.text(st.characters(exclude_categories=["C", "Zl", "Zp"]), max_size=12)
scalars = st.none() | st.booleans() | st.integers(-(10**12), 10**12) | st.floats(-1e9, 1e9) | texts
values = st.recursive(
    scalars,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(texts, inner, max_size=3),
    max_leaves=6,
)


@given(values)
@example("1e9")
@example("true")
@example("a: b")
@example("row:bank:line")
def test_values_come_back_from_a_line_as_they_were(value):
    assert parse(flow(value), lambda mark: Location(""), Path()).plain() == value


def test_the_command_is_quoted_for_a_shell():
    assert command("runs/my run.yaml", {"a": "1 KiB"}) == "archsim run 'runs/my run.yaml' --set 'a=1 KiB'"


def test_too_many_points_are_refused():
    block = {"grid": {"a": list(range(1000)), "b": list(range(1000))}}
    with pytest.raises(ArchsimError, match="more than 100,000 points"):
        points(block)


MISTAKES = {
    "parameters: [{}]": "must have one of grid, zip, list, random, not 0 of them",
    "parameters: [{grid: {a: [1]}, zip: {a: [1]}}]": "not 2 of them",
    "parameters: [{grid: {a: []}}]": "parameters.0.grid.a: must have at least 1",
    "parameters: [{grid: {a: 3}}]": "parameters.0.grid.a: must be a list, not 3",
    "parameters: [{zip: {a: [1], b: [1, 2]}}]": "all lists must be equally long; they have 1, 2 values",
    "parameters: [{gird: {a: [1]}}]": "did you mean 'grid'",
    "parameters: []": "parameters: must have at least 1",
    "parameters: [{grid: {'a b': [1]}}]": "parameters.0.grid.a b",
    "parameters: [{random: {count: 3, seed: 1, values: {a: {low: 3, high: 2}}}}]": "must be at least low, 3",
}


@pytest.mark.parametrize(("line", "message"), MISTAKES.items(), ids=list(MISTAKES.values()))
def test_mistakes_are_named_with_their_place(write, problems, line, message):  # noqa: F811
    file = write("sweep.yaml", f"name: x\nrun: runs/tiny.yaml\n{line}\n")

    found = problems(load_sweep, file)

    assert any(message in problem for problem in found), found
    assert all(problem.startswith("sweep.yaml:3:") for problem in found), found
