"""Quantities: exact values, exact errors, and there and back again."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel

from archsim.errors import ArchsimError, Location
from archsim.units import (
    Bytes,
    Cycles,
    Duration,
    Frequency,
    clock_periods,
    format_bytes,
    format_duration,
    format_frequency,
    parse_bytes,
    parse_cycles,
    parse_duration,
    parse_frequency,
)


@pytest.mark.parametrize(
    ("parse", "text", "value"),
    [
        (parse_bytes, "16 KiB", 16384),
        (parse_bytes, "64B", 64),
        (parse_bytes, " 1.5 MiB ", 3 * 2**19),
        (parse_bytes, "2 kB", 2000),
        (parse_bytes, 128, 128),
        (parse_bytes, "128", 128),
        (parse_bytes, 128.0, 128),
        (parse_frequency, "1.2 GHz", 1_200_000_000),
        (parse_frequency, "700 MHz", 700_000_000),
        (parse_frequency, 1.2e9, 1_200_000_000),
        (parse_duration, "7.8 us", Fraction(78, 10_000_000)),
        (parse_duration, "7.8 µs", Fraction(78, 10_000_000)),
        (parse_duration, "35 ns", Fraction(35, 10**9)),
        (parse_duration, "5/6 ns", Fraction(5, 6 * 10**9)),
        (parse_duration, 0.1, Fraction(1, 10)),
        (parse_cycles, "8 cycles", 8),
        (parse_cycles, "1 cycle", 1),
        (parse_cycles, 6, 6),
    ],
)
def test_quantities_are_exact(parse, text, value):
    assert parse(text) == value


@pytest.mark.parametrize(
    ("parse", "text", "message"),
    [
        (parse_bytes, "16 KB", "'16 KB' is not a size; write KiB (1024 bytes) or kB (1000 bytes)"),
        (parse_bytes, "16 kib", "'16 kib' is not a size; did you mean 'KiB'?"),
        (parse_bytes, "5 ns", "'5 ns' is not a size; 'ns' is the unit of a duration; write it like '16 KiB'"),
        (parse_bytes, "0.3 KiB", "'0.3 KiB' is not a whole number of B"),
        (parse_bytes, "-1 B", "a size can't be negative: '-1 B'"),
        (parse_bytes, True, "true is not a size; write it like '16 KiB'"),
        (parse_bytes, None, "null is not a size; write it like '16 KiB'"),
        (parse_bytes, [1], "'[1]' is not a size; write it like '16 KiB'"),
        (parse_bytes, float("nan"), "'nan' is not a size; write it like '16 KiB'"),
        (parse_frequency, "1.2 ghz", "'1.2 ghz' is not a frequency; did you mean 'GHz'?"),
        (parse_frequency, "0 Hz", "a frequency must be above 0 Hz"),
        (parse_frequency, "0.5 Hz", "'0.5 Hz' is not a whole number of Hz"),
        (parse_duration, "1/0 s", "'1/0 s' divides by zero"),
        (parse_duration, "x" * 50, f"'{'x' * 37}...' is not a duration; write it like '7.8 us'"),
        (parse_duration, "1e999999999 s", "'1e999999999 s' is not a duration; write it like '7.8 us'"),
        (parse_cycles, "2.5 cycles", "'2.5 cycles' is not a whole number of cycles"),
    ],
)
def test_errors_say_what_and_what_instead(parse, text, message):
    with pytest.raises(ArchsimError) as error:
        parse(text)
    assert str(error.value) == message


def test_errors_carry_the_location():
    with pytest.raises(ArchsimError, match=r"^m\.yaml:3:7: 'x' is not a size"):
        parse_bytes("x", Location("m.yaml", 3, 7))


@pytest.mark.parametrize(
    ("text", "formatted"),
    [
        (format_bytes(0), "0 B"),
        (format_bytes(1000), "1000 B"),
        (format_bytes(16384), "16 KiB"),
        (format_bytes(3 * 2**40), "3 TiB"),
        (format_frequency(1_200_000_000), "1.2 GHz"),
        (format_frequency(999), "999 Hz"),
        (format_duration(Fraction(78, 10_000_000)), "7.8 us"),
        (format_duration(Fraction(1, 1_200_000_000)), "2500/3 ps"),
        (format_duration(Fraction(0)), "0 s"),
    ],
)
def test_formats_are_what_people_write(text, formatted):
    assert text == formatted


@given(st.integers(0, 2**80))
def test_bytes_there_and_back(size):
    assert parse_bytes(format_bytes(size)) == size


@given(st.integers(1, 10**30))
def test_frequency_there_and_back(hertz):
    assert parse_frequency(format_frequency(hertz)) == hertz


@given(st.fractions(min_value=0, max_value=10**9))
def test_duration_there_and_back(seconds):
    assert parse_duration(format_duration(seconds)) == seconds


@given(st.text(max_size=40) | st.floats() | st.integers() | st.none() | st.booleans())
def test_anything_else_is_an_archsim_error(value):
    for parse in (parse_bytes, parse_frequency, parse_duration, parse_cycles):
        try:
            parsed = parse(value)
        except ArchsimError:
            continue
        assert parsed >= 0


def test_a_duration_with_many_digits_there_and_back():
    seconds = parse_duration("1" * 100 + "." + "1" * 100 + "e-99 ps")
    assert parse_duration(format_duration(seconds)) == seconds


class Quantities(BaseModel):
    size: Bytes
    clock: Frequency
    time: Duration
    hit: Cycles


def test_schema_types_read_and_write_the_human_form():
    written = {"size": "16 KiB", "clock": "1.2 GHz", "time": "7.8 us", "hit": 8}
    model = Quantities.model_validate(written)
    assert (model.size, model.clock, model.time, model.hit) == (
        16384,
        1_200_000_000,
        Fraction(39, 5_000_000),
        8,
    )
    assert model.model_dump() == written


def test_periods_are_whole_ticks_of_the_common_divisor():
    assert clock_periods({"core": 1_200_000_000, "memory": 700_000_000}) == {"core": 7, "memory": 12}
    assert clock_periods({"core": 10**9, "memory": 10**9}) == {"core": 1, "memory": 1}
    with pytest.raises(ArchsimError, match="clock 'core' must be above 0 Hz, not 0"):
        clock_periods({"core": 0})


@given(st.lists(st.integers(1, 10**7), min_size=1, max_size=4))
def test_periods_are_in_proportion_and_as_small_as_possible(frequencies):
    periods = clock_periods({str(index): hertz for index, hertz in enumerate(frequencies)})
    seconds = {Fraction(period * hertz) for period, hertz in zip(periods.values(), frequencies, strict=True)}
    assert len(seconds) == 1
    assert not any(all(period % factor == 0 for period in periods.values()) for factor in (2, 3, 5, 7, 11))
