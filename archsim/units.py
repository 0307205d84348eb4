"""Quantities as people write them ("16 KiB", "1.2 GHz", "7.8 us", "8 cycles"), as exact numbers, and back."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from fractions import Fraction
from typing import Annotated, NamedTuple

from pydantic import BeforeValidator, PlainSerializer, PlainValidator, WithJsonSchema
from pydantic_core import PydanticCustomError

from archsim.errors import ArchsimError, Location, did_you_mean, fail

# A sign, a decimal number or a ratio, a unit. Lengths are bounded: 1e999999999 would fill the memory.
_QUANTITY = re.compile(
    r"([+-]?)((?:\d{1,100}(?:\.\d{0,100})?|\.\d{1,100})(?:[eE][+-]?\d{1,2})?|\d{1,400}/\d{1,400})\s*([A-Za-zµμ]*)",
    re.ASCII,
)


class _Dimension(NamedTuple):
    """What a quantity measures: its name, an example, and the size of every unit, ascending."""

    name: str
    example: str
    plain: str  # unit of a plain number
    units: dict[str, Fraction]


def _table(**units: str | int) -> dict[str, Fraction]:
    return {name: Fraction(size) for name, size in units.items()}


_SIZE = _Dimension(
    "size",
    "16 KiB",
    "B",
    _table(B=1, kB=10**3, KiB=2**10, MB=10**6, MiB=2**20, GB=10**9, GiB=2**30, TB=10**12, TiB=2**40),
)
_FREQUENCY = _Dimension("frequency", "1.2 GHz", "Hz", _table(Hz=1, kHz=10**3, MHz=10**6, GHz=10**9))
_DURATION = _Dimension(
    "duration",
    "7.8 us",
    "s",
    _table(ps="1e-12", ns="1e-9", us="1e-6", ms="1e-3", s=1) | {"µs": Fraction("1e-6")},
)
_CYCLES = _Dimension("number of cycles", "8 cycles", "cycles", _table(cycle=1, cycles=1))
_DIMENSIONS = (_SIZE, _FREQUENCY, _DURATION, _CYCLES)


def parse_bytes(text: str | int | float, where: Location | None = None) -> int:
    """Bytes in "16 KiB", "64 B" or a plain number of bytes. Raises ArchsimError, also below 0."""
    return _whole(text, _SIZE, where)


def parse_frequency(text: str | int | float, where: Location | None = None) -> int:
    """Hertz in "1.2 GHz" or a plain number of hertz. Raises ArchsimError, also for 0."""
    hertz = _whole(text, _FREQUENCY, where)
    if hertz == 0:
        raise fail("a frequency must be above 0 Hz", where)
    return hertz


def parse_duration(text: str | int | float | Fraction, where: Location | None = None) -> Fraction:
    """Seconds in "7.8 us", "5/6 ns" or a plain number of seconds. Raises ArchsimError, also below 0."""
    return _parse(text, _DURATION, where)


def parse_cycles(text: str | int | float, where: Location | None = None) -> int:
    """Cycles in "8 cycles" or a plain number. Raises ArchsimError, also below 0."""
    return _whole(text, _CYCLES, where)


def format_bytes(size: int) -> str:
    """The largest binary unit that divides the size: 16384 -> "16 KiB", 1000 -> "1000 B"."""
    units = [(name, int(_SIZE.units[name])) for name in ("TiB", "GiB", "MiB", "KiB", "B")]
    name, scale = next((name, scale) for name, scale in units if size % scale == 0 and (size or scale == 1))
    return f"{size // scale} {name}"


def format_frequency(hertz: int) -> str:
    """The largest unit that leaves at least 1: 1200000000 -> "1.2 GHz"."""
    return _format(Fraction(hertz), _FREQUENCY)


def format_duration(seconds: Fraction) -> str:
    """The largest unit that leaves at least 1, exact: 39/5000000 -> "7.8 us", 1/1200000000 -> "2500/3 ps"."""
    return _format(seconds, _DURATION)


def clock_periods(clocks: Mapping[str, int]) -> dict[str, int]:
    """Period of every clock [Hz] in ticks, the tick being their exact common divisor.

    1.2 GHz and 700 MHz have periods of 7 and 12 ticks. Raises ArchsimError for a clock not above 0 Hz.
    """
    for name, hertz in clocks.items():
        if hertz <= 0:
            raise fail(f"clock '{name}' must be above 0 Hz, not {hertz}")

    ticks_per_second = math.lcm(*clocks.values())
    return {name: ticks_per_second // hertz for name, hertz in clocks.items()}


def _whole(text: object, dimension: _Dimension, where: Location | None) -> int:
    quantity = _parse(text, dimension, where)
    if quantity.denominator != 1:
        raise fail(f"{_shown(text)} is not a whole number of {dimension.plain}", where)
    return int(quantity)


def _parse(text: object, dimension: _Dimension, where: Location | None) -> Fraction:
    """The quantity in the dimension's plain unit, not negative."""
    quantity = _plain_number(text)
    if quantity is None:
        quantity = _parse_text(text, dimension, where)
    if quantity < 0:
        raise fail(f"a {dimension.name} can't be negative: {_shown(text)}", where)
    return quantity


def _plain_number(value: object) -> Fraction | None:
    """A number without a unit; a float counts as the decimal number that it prints as."""
    if isinstance(value, bool):
        return None
    if isinstance(value, int | Fraction):
        return Fraction(value)
    if isinstance(value, float) and math.isfinite(value):
        return Fraction(repr(value))
    return None


def _parse_text(text: object, dimension: _Dimension, where: Location | None) -> Fraction:
    match = _QUANTITY.fullmatch(text.strip()) if isinstance(text, str) else None
    if match is None:
        raise fail(f"{_shown(text)} is not a {dimension.name}", where, f"write it like '{dimension.example}'")
    sign, number, unit = match.groups()
    unit = (unit or dimension.plain).replace("μ", "µ")
    if unit not in dimension.units:
        raise fail(f"{_shown(text)} is not a {dimension.name}", where, _unit_hint(unit, dimension))

    if re.search(r"/0+$", number):
        raise fail(f"{_shown(text)} divides by zero", where)
    return Fraction(sign + number) * dimension.units[unit]


def _unit_hint(unit: str, dimension: _Dimension) -> str:
    """What may have been meant by a unit that the dimension does not have."""
    if dimension is _SIZE and unit == "KB":
        return "write KiB (1024 bytes) or kB (1000 bytes)"
    other = next((each.name for each in _DIMENSIONS if unit in each.units), None)
    if other:
        return f"'{unit}' is the unit of a {other}; write it like '{dimension.example}'"

    same_letters = [name for name in dimension.units if name.lower() == unit.lower()]
    if same_letters:
        return f"did you mean '{same_letters[-1]}'?"
    return did_you_mean(unit, dimension.units) or f"units are {', '.join(dimension.units)}"


def _format(quantity: Fraction, dimension: _Dimension) -> str:
    """The quantity in the largest unit that leaves at least 1, else in the smallest."""
    units = [(name, scale) for name, scale in dimension.units.items() if name.isascii()]
    name, scale = next(((n, s) for n, s in reversed(units) if quantity >= s), units[0])
    if quantity == 0:
        name, scale = dimension.plain, Fraction(1)
    return f"{_decimal(quantity / scale)} {name}"


def _decimal(number: Fraction) -> str:
    """All digits of a number, or `a/b` where they do not end or are too many to be read back."""
    digits = next((n for n in range(30) if (number * 10**n).denominator == 1), None)
    if digits is None:
        return str(number)
    text = f"{int(number * 10**digits):0{digits + 1}d}"
    return f"{text[:-digits]}.{text[-digits:]}" if digits else text


def _shown(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if value is None:
        return "null"
    text = value if isinstance(value, str) else str(value)
    return repr(text if len(text) <= 40 else text[:37] + "...")


def _for_schema(parse):
    """The parser as a pydantic validator: its problem becomes an error of the type `archsim`."""

    def validate(value):
        try:
            return parse(value)
        except ArchsimError as error:
            problem = error.problems[0]
            raise PydanticCustomError(
                "archsim", "{what}", {"what": problem.what, "hint": problem.hint}
            ) from None

    return validate


def _json(dimension: _Dimension) -> WithJsonSchema:
    schema = {"type": ["string", "number"], "examples": [dimension.example], "unit": dimension.plain}
    return WithJsonSchema(schema)


# Field types of the configuration: read what people write, serialise to what people read.
Bytes = Annotated[int, BeforeValidator(_for_schema(parse_bytes)), PlainSerializer(format_bytes), _json(_SIZE)]
Frequency = Annotated[
    int,
    BeforeValidator(_for_schema(parse_frequency)),
    PlainSerializer(format_frequency),
    _json(_FREQUENCY),
]
Duration = Annotated[
    Fraction,
    PlainValidator(_for_schema(parse_duration)),
    PlainSerializer(format_duration),
    _json(_DURATION),
]
Cycles = Annotated[int, BeforeValidator(_for_schema(parse_cycles)), _json(_CYCLES)]
