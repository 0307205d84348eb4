"""Errors of cells."""

import pytest

from archsim.reproduce.cells import KINDS, NOT_COMPARABLE, Place, error_percent, make_cell


@pytest.mark.parametrize(
    ("printed", "ours", "error"),
    [
        (20.0, 21.0, 5.0),
        (20.0, 19.0, -5.0),
        (20, 20, 0.0),
        ([75, 118], 75, 0.0),
        ([75, 118], 100.5, 0.0),
        ([75, 118], 129.8, 10.0),
        ([75, 118], 60.0, -20.0),
        (0, 1, None),
    ],
)
def test_the_error_is_signed_and_counts_from_the_nearer_end_of_a_range(printed, ours, error):
    assert error_percent(printed, ours) == error


def test_a_cell_has_the_fields_that_are_promised():
    cell = make_cell(
        Place("johnson2004", 3, "doom_light0", "cycles"), "predicted", 26107800, 26107800, "cycles"
    )

    fields = "paper table row column kind printed ours unit error_percent"
    assert " ".join(cell._asdict()) == fields
    assert cell.kind in KINDS


def test_what_can_t_be_compared_has_no_error():
    assert make_cell(Place("p", 2, "L1", "miss"), NOT_COMPARABLE, 6, 30, "cycles").error_percent is None
