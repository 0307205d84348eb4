"""`archsim trace`: its output, errors and exit codes."""

import json

import pytest
from typer.testing import CliRunner

from archsim.cli.app import app


@pytest.fixture(autouse=True)
def in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def archsim_(*arguments, exit_code=0):
    result = CliRunner().invoke(app, ["trace", *arguments])
    assert result.exit_code == exit_code, result.output
    return result


def test_info_counts_what_a_trace_holds(tmp_path):
    (tmp_path / "a.din").write_text("0 1000\n1 1040\n2 1080\n")

    assert (
        json.loads(archsim_("info", "a.din", "--format", "dinero", "--json").stdout)["footprint_bytes"] == 192
    )
    assert "0x1083" in archsim_("info", "a.din", "--format", "dinero").stdout


def test_a_malformed_line_is_one_line_on_stderr_and_exit_code_2(tmp_path):
    (tmp_path / "a.din").write_text("0 1000\n0 x\n")

    result = archsim_("info", "a.din", "--format", "dinero", exit_code=2)

    assert result.stderr.startswith("a.din:2:3: not a number in hexadecimal digits: '0 x'; ")
    assert result.stdout == ""
