"""`archsim trace check-dram`: its output, errors and exit codes."""

import json

import pytest
from typer.testing import CliRunner

from archsim.cli.app import app
from archsim.trace.referee.commands import HEADER


@pytest.fixture(autouse=True)
def in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def check_dram(text, *arguments, machine="tiny", exit_code=0):
    with open("commands.csv", "w") as file:
        file.write(f"{HEADER}\n{text}")
    result = CliRunner().invoke(
        app, ["trace", "check-dram", "commands.csv", "--machine", machine, *arguments]
    )
    assert result.exit_code == exit_code, result.output
    return result


def test_commands_in_time_are_counted():
    assert check_dram("0,0,ACT,1,7,\n4,0,RD,1,7,0\n").stdout == "2 commands (1 ACT, 1 RD): no violation\n"


def test_a_violation_is_a_line_and_exit_code_1():
    result = check_dram("0,0,ACT,1,7,\n3,0,RD,1,7,0\n", exit_code=1)

    assert result.stdout.splitlines() == [
        "commands.csv:3: n_rcd_read: RD of bank 1: 3 clocks after its ACT in clock 0, at least 4 needed",
        "2 commands (1 ACT, 1 RD): 1 violation (1 of n_rcd_read)",
    ]


def test_json_counts_by_rule():
    result = json.loads(check_dram("0,0,RD,1,7,0\n", "--json", exit_code=1).stdout)

    assert result["violations"] == {"bank closed": 1}
    assert result["commands"] == {"RD": 1}
    assert result["first"] == [{"line": 2, "rule": "bank closed", "what": "RD of bank 1: no row is open"}]


def test_only_the_first_violations_are_shown():
    result = check_dram("0,0,REF,,,\n" * 150, exit_code=1)

    assert len(result.stdout.splitlines()) == 102
    assert "more" in result.stdout


def test_the_machine_can_be_changed():
    check_dram("0,0,ACT,1,7,\n3,0,RD,1,7,0\n", "--set", "components.dram.timing.n_rcd_read=3")


@pytest.mark.parametrize(
    ("text", "arguments", "said"),
    [
        ("0,0,RD\n", [], "commands.csv:2: must be clock,channel"),
        ("", ["--dram", "drm"], "no DRAM with commands is named 'drm'; did you mean 'dram'?"),
        ("", ["--set", "components.dram.timing.n_cl=x"], "n_cl"),
    ],
)
def test_bad_input_ends_with_2(text, arguments, said):
    result = check_dram(text, *arguments, exit_code=2)

    assert said in result.stderr
    assert result.stdout == ""


def test_a_machine_without_commands_is_said():
    ideal = "components.dram={base: dram/ideal.yaml}"
    assert "0 DRAMs with commands" in check_dram("", "--set", ideal, exit_code=2).stderr


@pytest.mark.parametrize("phase", ["izb_build", "izb_raster"])
def test_what_a_run_records_breaks_no_rule(phase):
    recorded = CliRunner().invoke(
        app, ["trace", "record-dram", "tiny", "--phase", phase, "--out", "commands.csv"]
    )
    assert recorded.exit_code == 0, recorded.output
    judged = CliRunner().invoke(app, ["trace", "check-dram", "commands.csv", "--machine", "tiny"])

    assert judged.exit_code == 0, judged.output
    assert judged.stdout.endswith("no violation\n")


def test_a_phase_that_is_not_there_is_said():
    result = CliRunner().invoke(
        app, ["trace", "record-dram", "tiny", "--phase", "izb_bild", "--out", "commands.csv"]
    )
    assert result.exit_code == 2
    assert "did you mean 'izb_build'?" in result.stderr
