"""What the tests of configurations share: files in a folder, and the problems of a call as text."""

from __future__ import annotations

import textwrap
from collections.abc import Callable
from pathlib import Path

import pytest

from archsim.errors import ArchsimError


@pytest.fixture
def write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., str]:
    """Writes a file into an empty current folder, so that errors show its bare name; returns that name."""
    monkeypatch.chdir(tmp_path)

    def write_file(name: str, text: str | bytes) -> str:
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(text if isinstance(text, bytes) else textwrap.dedent(text).encode())
        return name

    return write_file


@pytest.fixture
def problems() -> Callable[..., list[str]]:
    """Calls a function that must raise ArchsimError and returns its lines."""

    def problems_of(function: Callable[..., object], *arguments: object) -> list[str]:
        with pytest.raises(ArchsimError) as error:
            function(*arguments)
        return [str(problem) for problem in error.value.problems]

    return problems_of
