"""Every snippet of the documentation is executed, in order and page by page; the site builds without a warning.

A `yaml` block whose first line is `# file: NAME` is written to that file. A `console` block holds commands and their
output, in which a line `...` stands for any lines. A `python` block is run as it is.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import archsim

DOCS = Path(archsim.__file__).parent / "docs"
PAGES = sorted(path for path in DOCS.rglob("*.md") if "```{include}" not in path.read_text())
NAMES = [path.relative_to(DOCS).as_posix() for path in PAGES]
RUNNABLE = ("console", "python", "yaml")


def blocks(page: Path) -> list[tuple[str, str]]:
    """(language, text) of the blocks that are executed."""
    found = re.findall(r"^```(\w+)\n(.*?)^```$", page.read_text(), re.DOTALL | re.MULTILINE)
    return [(language, text) for language, text in found if language in RUNNABLE]


def commands(text: str) -> list[tuple[str, list[str]]]:
    """(command, lines of its output) of a console block."""
    parts = re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]
    return [(part.split("\n", 1)[0], part.split("\n", 1)[1].splitlines()) for part in parts]


def fits(shown: list[str], real: list[str]) -> bool:
    """Whether the output is what the page shows, `...` standing for any lines; blank lines and widths do not count."""
    pattern = "".join(
        r"(?:.*\n)*" if line.strip() == "..." else r"\s*".join(map(re.escape, line.split())) + r"\s*\n"
        for line in shown
        if line.strip()
    )
    text = "".join(line.strip() + "\n" for line in real if line.strip())
    return re.fullmatch(pattern, text) is not None


def do_console(text: str, environment: dict[str, str]) -> None:
    for command, shown in commands(text):
        real = subprocess.run(
            command.replace("archsim", f"{sys.executable} -m archsim", 1)
            if command.startswith("archsim")
            else command,
            shell=True,
            env=environment,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            check=False,
        )
        assert "Traceback" not in real.stdout, real.stdout
        assert fits(shown, real.stdout.splitlines()), f"{command}\n{real.stdout}"


@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page)], ids=lambda page: page.stem)
def test_the_snippets_of_a_page_run(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    environment = {**os.environ, "PYTHONPATH": str(DOCS.parents[1]), "COLUMNS": "100"}
    for language, text in blocks(page):
        if language == "console":
            do_console(text, environment)
        elif language == "python":
            exec(compile(text, str(page), "exec"), {"__name__": "__main__"})
        elif text.startswith("# file: "):
            name, content = text.removeprefix("# file: ").split("\n", 1)
            Path(name).write_text(content)


def test_dots_stand_for_any_lines_and_nothing_else_does():
    assert fits(["a", "...", "c"], ["a", "b", "b", "c"])
    assert fits(["a  b", "..."], ["a b"])
    assert not fits(["a", "c"], ["a", "b", "c"])


def test_the_site_builds_without_a_warning(tmp_path):
    pytest.importorskip("myst_parser")
    words = [
        "-q",
        "-W",
        "-C",
        "-D",
        "extensions=myst_parser",
        "-D",
        "suppress_warnings=myst.xref_missing,myst.header",
    ]

    built = subprocess.run(
        [sys.executable, "-m", "sphinx", *words, "-D", "project=archsim", str(DOCS), str(tmp_path)],
        capture_output=True,
        text=True,
        check=False,
    )

    assert built.returncode == 0, built.stderr
    assert "izb_raster" in (tmp_path / "reference" / "statistics.html").read_text()


def test_every_page_is_in_the_site():
    listed = set()
    for page in PAGES:
        for tree in re.findall(r"```\{toctree\}\n(.*?)```", page.read_text(), re.DOTALL):
            entries = [line for line in tree.splitlines() if line and not line.startswith(":")]
            listed |= {(page.parent / f"{entry}.md").resolve() for entry in entries}

    assert listed | {(DOCS / "index.md").resolve()} == {path.resolve() for path in DOCS.rglob("*.md")}
