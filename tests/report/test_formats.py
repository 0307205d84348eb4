"""How numbers look."""

import pytest

from archsim.report.formats import number, percent, setting, words


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (26107800, "26,107,800"),
        (26107800.4, "26,107,800"),
        (19.923, "19.92"),
        (0.00012345, "0.0001234"),
        (1024.0, "1,024"),
        (3610.4, "3,610"),
        (5.0, "5"),
        ([75, 118], "75 - 118"),
        (True, "yes"),
        (None, "-"),
        (float("nan"), "-"),
        ("text", "text"),
    ],
)
def test_numbers_are_readable(value, text):
    assert number(value) == text


@pytest.mark.parametrize(
    ("error", "text"), [(3.14, "+3.1 %"), (-0.04, "-0.0 %"), (0.0, "0 %"), (1234.5, "+1234 %"), (None, "-")]
)
def test_errors_are_signed(error, text):
    assert percent(error) == text


def test_names_become_words():
    assert words("izb_build.cycles_per_point") == "izb build: cycles per point"


@pytest.mark.parametrize(
    ("value", "text"),
    [("2 KiB", "2 KiB"), ((64, 48), "[64, 48]"), (None, "null"), (True, "true"), (1000, "1000")],
)
def test_settings_look_as_they_are_written(value, text):
    assert setting(value) == text
