"""Parsers of operands: registers, swizzles, masks, conditions, memory elements."""

from __future__ import annotations

import re

from archsim.isa.cursor import Cursor
from archsim.isa.lexer import Token
from archsim.isa.opcodes import COMPONENTS
from archsim.isa.program import (
    ALWAYS,
    ATTRIBUTE_NAMES,
    NUM_ADDRESSES,
    NUM_ATTRIBUTES,
    NUM_BASES,
    NUM_CONSTANTS,
    NUM_TEMPORARIES,
    RESULTS,
    RULES,
    Condition,
    Destination,
    Source,
)

_NUMBERED = re.compile(r"([RAB])([0-9]+)", re.ASCII)
_LIMITS = {"R": NUM_TEMPORARIES, "A": NUM_ADDRESSES, "B": NUM_BASES}
_MASK = re.compile("x?y?z?w?")


def numbered(cursor: Cursor, file: str, what: str) -> int:
    """Read a register of one file, such as R7; returns its number."""
    token = cursor.word(what)
    match = _NUMBERED.fullmatch(token.text)
    if not match or match[1] != file:
        cursor.wrong(f"expected {what}, found {token}", token)
    number = int(match[2][:9])
    if number >= _LIMITS[file]:
        cursor.wrong(f"register {token.text} does not exist: {file}0 ... {file}{_LIMITS[file] - 1}", token)
    return number


def swizzle(cursor: Cursor) -> str:
    """Read an optional swizzle; returns four letters."""
    if not cursor.accept("."):
        return COMPONENTS
    token = cursor.word("a swizzle")
    if len(token.text) not in (1, 4) or set(token.text) - set(COMPONENTS):
        cursor.wrong(f"swizzle '.{token.text}' is not one or four of x, y, z, w", token)
    return token.text * 4 if len(token.text) == 1 else token.text


def mask(cursor: Cursor) -> str:
    """Read an optional write mask."""
    if not cursor.accept("."):
        return COMPONENTS
    token = cursor.word("a write mask")
    if not _MASK.fullmatch(token.text):
        cursor.wrong(f"write mask '.{token.text}' is not some of x, y, z, w in that order", token)
    return token.text


def condition(cursor: Cursor) -> Condition:
    """Read an optional (RULE.swizzle). TR looks at nothing, so its swizzle is dropped."""
    if not cursor.accept("("):
        return ALWAYS
    token = cursor.word("a condition")
    if token.text not in RULES:
        cursor.wrong(f"condition '{token.text}' is none of {', '.join(RULES)}", token, tuple(RULES))
    looked_at = swizzle(cursor)
    cursor.expect(")", "after the condition")
    return ALWAYS if token.text == "TR" else Condition(token.text, looked_at)


def destination(cursor: Cursor) -> Destination:
    """Read Rn, o[NAME] or CC, with its mask."""
    token = cursor.token
    if cursor.accept("CC"):
        return Destination("CC", 0, mask(cursor))
    if cursor.accept("o"):
        cursor.expect("[", "after 'o'")
        name = cursor.word("the name of a result register")
        if name.text not in RESULTS:
            cursor.wrong(f"result register o[{name.text}] does not exist", name, tuple(RESULTS))
        cursor.expect("]", "after the name of the result register")
        return Destination("o", RESULTS.index(name.text), mask(cursor))
    if token.text in ("v", "c"):
        cursor.wrong(f"{token.text}[] registers cannot be written")
    return Destination("R", numbered(cursor, "R", "a destination (R0 ... R15, o[NAME] or CC)"), mask(cursor))


def vector(cursor: Cursor) -> Source:
    """Read a source with its signs, absolute value and swizzle. A sign inside |...| changes nothing."""
    negate = _sign(cursor)
    absolute = cursor.accept("|")
    if absolute:
        _sign(cursor)
    file, index, address = _register(cursor)
    source = Source(file, index, swizzle(cursor), negate, absolute, address)
    if absolute:
        cursor.expect("|", "to close the absolute value")
    return source


def scalar(cursor: Cursor) -> Source:
    """Read a source that must name one component."""
    token = cursor.token
    negate = _sign(cursor)
    absolute = cursor.accept("|")
    if absolute:
        _sign(cursor)
    file, index, address = _register(cursor)
    one_letter = len(cursor.following.text) == 1
    letters = swizzle(cursor) if cursor.token.text == "." else ""
    if not letters or not one_letter:
        cursor.wrong("a scalar operand needs one component, such as .x", token)
    if absolute:
        cursor.expect("|", "to close the absolute value")
    return Source(file, index, letters, negate, absolute, address)


def element(cursor: Cursor) -> tuple[int, Source]:
    """Read [B0 | src.c]; returns the base register's number and the index operand."""
    cursor.expect("[", "before a memory element")
    base = numbered(cursor, "B", "a base register (B0 or B1)")
    cursor.expect("|", "after the base register")
    index = scalar(cursor)
    cursor.expect("]", "after the memory element")
    return base, index


def _sign(cursor: Cursor) -> bool:
    """Read an optional sign; true for minus."""
    return cursor.accept("-") or (cursor.accept("+") and False)


def _register(cursor: Cursor) -> tuple[str, int, tuple[int, str] | None]:
    """Read Rn, v[n] or c[...]; returns file, number and the address register component of a relative c[]."""
    token = cursor.token
    if cursor.accept("v"):
        return "v", _attribute(cursor), None
    if cursor.accept("c"):
        return "c", *_constant(cursor)
    if token.text == "o":
        cursor.wrong("o[] registers cannot be read")
    return "R", numbered(cursor, "R", "a source (R0 ... R15, v[] or c[])"), None


def _attribute(cursor: Cursor) -> int:
    cursor.expect("[", "after 'v'")
    token = cursor.token
    if token.kind == "word":
        number = ATTRIBUTE_NAMES.get(cursor.take().text, NUM_ATTRIBUTES)
    else:
        number = cursor.number("an attribute register (0 ... 15 or its name)").value
    if number >= NUM_ATTRIBUTES:
        cursor.wrong(f"attribute register v[{token.text}] does not exist", token, tuple(ATTRIBUTE_NAMES))
    cursor.expect("]", "after the attribute register")
    return number


def _constant(cursor: Cursor) -> tuple[int, tuple[int, str] | None]:
    cursor.expect("[", "after 'c'")
    token: Token = cursor.token
    address = None
    number, lowest, highest = 0, 0, NUM_CONSTANTS - 1
    if token.kind == "word":
        address = (numbered(cursor, "A", "an address register (A0 or A1)"), _address_component(cursor))
        token, lowest = cursor.token, -NUM_CONSTANTS
        if token.text in ("+", "-"):
            minus = _sign(cursor)
            number = cursor.number("an offset").value * (-1 if minus else 1)
    else:
        number = cursor.number("a parameter register (0 ... 255, or A0.x + an offset)").value
    if not lowest <= number <= highest:
        cursor.wrong(f"parameter register number {number} is not in {lowest} ... {highest}", token)
    cursor.expect("]", "after the parameter register")
    return number, address


def _address_component(cursor: Cursor) -> str:
    cursor.expect(".", "after the address register")
    token = cursor.word("a component of the address register")
    if token.text not in tuple(COMPONENTS):
        cursor.wrong(f"component '.{token.text}' is none of x, y, z, w", token)
    return token.text
