"""What the counter of host instructions reads."""

from __future__ import annotations

import importlib
import sys

import pytest

from archsim import resources

FOLDER = resources.experiment("benchmarks")
COUNTS = """events: Ir Bc
fn=(1) ???
0x1000 0 5 1
+4 0 7
* 0 2
calls=1 0x2000 0
* 0 900
-4 0 1 1
"""


@pytest.fixture(scope="module")
def tool():
    sys.path.insert(0, str(FOLDER))
    try:
        yield importlib.import_module("host_instructions")
    finally:
        sys.path.remove(str(FOLDER))


def test_costs_are_added_by_address_and_calls_left_out(tool, tmp_path):
    counts = tmp_path / "callgrind.out"
    counts.write_text(COUNTS)
    assert tool.costs_of(counts) == {0x1000: {"Ir": 6, "Bc": 2}, 0x1004: {"Ir": 9}}


def test_names_of_symbols(tool):
    assert tool.name_of("_ZN7archsim7machine4loop4playB2v1B5xE") == "loop.play"
    assert tool.name_of("??") == ""
