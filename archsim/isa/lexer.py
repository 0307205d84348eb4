"""Assembly text into tokens that know where they stand."""

from __future__ import annotations

import re
from typing import NamedTuple

from archsim.errors import Location, Problem

HEADER = "!!VP2.0"

_PATTERN = re.compile(
    r"(?P<blank>[ \t\r\f\v]+|\#[^\n]*)|(?P<newline>\n)|(?P<header>!!VP2\.0)|(?P<word>[A-Za-z_][A-Za-z_0-9]*)"
    r"|(?P<number>[0-9]+)|(?P<sign>[][(){},;:|+.-])|(?P<other>.)"
)


class Token(NamedTuple):
    """A piece of text; kind is "header", "word", "number", "sign" (one character) or "end" (of the text)."""

    kind: str
    text: str
    where: Location

    def __str__(self) -> str:
        return "the end of the text" if self.kind == "end" else f"'{self.text}'"


def tokenize(text: str, file: str) -> tuple[list[Token], list[Problem]]:
    """All tokens, the last one of kind "end", and a problem for every character that is in no token."""
    tokens: list[Token] = []
    problems: list[Problem] = []
    line, line_start = 1, 0
    for match in _PATTERN.finditer(text):
        where = Location(file, line, match.start() - line_start + 1)
        if match.lastgroup == "newline":
            line, line_start = line + 1, match.end()
        elif match.lastgroup == "other":
            problems.append(Problem(where, f"{match.group()!r} means nothing here"))
        elif match.lastgroup != "blank":
            tokens.append(Token(str(match.lastgroup), match.group(), where))
    tokens.append(Token("end", "", Location(file, line, len(text) - line_start + 1)))
    return tokens, problems
