"""A place in the tokens of a program, with the few moves a parser needs."""

from __future__ import annotations

from typing import NamedTuple, NoReturn

from archsim.errors import Location, did_you_mean, fail
from archsim.isa.lexer import Token


class Number(NamedTuple):
    """A number and where it was written."""

    value: int
    where: Location


class Cursor:
    """Reads tokens in order; never moves past the last one."""

    def __init__(self, tokens: list[Token]):
        self._tokens = tokens
        self._at = 0

    @property
    def token(self) -> Token:
        """The token to be read next."""
        return self._tokens[self._at]

    @property
    def following(self) -> Token:
        """The token behind it."""
        return self._tokens[min(self._at + 1, len(self._tokens) - 1)]

    def take(self) -> Token:
        """Read one token."""
        token = self.token
        self._at = min(self._at + 1, len(self._tokens) - 1)
        return token

    def accept(self, text: str) -> bool:
        """Read the token if it is this text."""
        if self.token.kind == "end" or self.token.text != text:
            return False
        self.take()
        return True

    def expect(self, text: str, after: str) -> None:
        """Read the token that must be this text."""
        if not self.accept(text):
            self.wrong(f"expected '{text}' {after}, found {self.token}")

    def word(self, what: str) -> Token:
        """Read a word; `what` names it in the message if there is none."""
        if self.token.kind != "word":
            self.wrong(f"expected {what}, found {self.token}")
        return self.take()

    def number(self, what: str) -> Number:
        """Read a number; `what` names it in the message if there is none."""
        if self.token.kind != "number":
            self.wrong(f"expected {what}, found {self.token}")
        token = self.take()
        return Number(int(token.text[:9]), token.where)  # nine digits are out of every range

    def skip_statement(self, first: Token) -> None:
        """Go behind the next ';' or the end of the line, at least behind the statement's first token."""
        if self.token is first:
            self.take()
        line = self._tokens[self._at - 1].where.line
        while self.token.kind != "end" and self.token.where.line == line:
            if self.take().text == ";":
                return

    def wrong(self, what: str, token: Token | None = None, choices: tuple[str, ...] = ()) -> NoReturn:
        """Give up on the statement: `what` at the token (default: the next one), near misses as a hint."""
        token = token or self.token
        raise fail(what, token.where, did_you_mean(token.text, choices) if choices else None)
