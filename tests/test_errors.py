"""Errors say everything at once, and survive the way between processes."""

import copy
import pickle

import pytest

from archsim.errors import ArchsimError, DeadlockError, Location, Problem, about, did_you_mean, fail

PROBLEMS = [
    Problem(Location("run.yaml", 3, 7), "unknown key 'wayz'", "did you mean 'ways'?"),
    Problem(Location("run.yaml"), "too big"),
    Problem(None, "nowhere in particular"),
]


def test_every_problem_has_its_line():
    assert str(ArchsimError(PROBLEMS)).splitlines() == [
        "run.yaml:3:7: unknown key 'wayz'; did you mean 'ways'?",
        "run.yaml: too big",
        "nowhere in particular",
    ]


def test_errors_survive_pickling_and_copying():
    for error in (ArchsimError(PROBLEMS), DeadlockError(PROBLEMS[0])):
        for again in (pickle.loads(pickle.dumps(error)), copy.copy(error), type(error)(*error.args)):
            assert type(again) is type(error)
            assert again.problems == error.problems
            assert str(again) == str(error)


def test_fail_makes_one_problem():
    assert fail("what", Location("f", 1)).problems == [Problem(Location("f", 1), "what")]


def test_what_a_problem_is_about_grows_from_the_inside_out_and_survives_pickling():
    with pytest.raises(ArchsimError) as caught, about("scene.mesh"), about("parameters"):
        raise ArchsimError([Problem(None, "too big", key="size"), *PROBLEMS])

    again = pickle.loads(pickle.dumps(caught.value))

    assert [problem.key for problem in again.problems] == [
        *("scene.mesh.parameters.size", None, None, "scene.mesh.parameters")
    ]
    assert str(again).splitlines()[0] == "scene.mesh.parameters.size: too big"


def test_only_near_words_are_suggested():
    assert did_you_mean("wayz", ["ways", "size"]) == "did you mean 'ways'?"
    assert did_you_mean("qqq", ["ways", "size"]) is None
