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


def replay(*arguments, exit_code=0):
    return archsim_(
        "replay", "a.din", "--format", "dinero", "--machine", "tiny", *arguments, exit_code=exit_code
    )


def test_replays_print_misses_of_every_level(tmp_path):
    (tmp_path / "a.din").write_text("0 0\n1 4\n2 80\n0 40\n0 0\n")

    for mode in ([], ["--functional"]):
        tree = json.loads(replay("--json", *mode).stdout)
        values = {statistic["name"]: statistic["value"] for statistic in tree["statistics"]}
        assert values["l1.accesses"] == values["builder_l1.accesses"] == 5
        assert values["l1.misses"] == 3
        assert values["l2.misses"] == 3
        assert values["dram.requests"] == 3 + (mode != [])  # Dinero IV writes dirty lines back at its end
        assert tree["summary"]["checks_passed"] is True
    assert "dram: row conflicts" in replay().stdout


def test_a_final_flush_is_an_option(tmp_path):
    (tmp_path / "a.din").write_text("1 0\n")

    assert json.loads(replay("--functional", "--json").stdout)["summary"]["l2.writebacks"] == 1
    assert json.loads(replay("--functional", "--no-flush", "--json").stdout)["summary"]["l2.writebacks"] == 0
    assert json.loads(replay("--flush", "--json").stdout)["summary"]["l2.writebacks"] == 1
    assert json.loads(replay("--json").stdout)["summary"]["l2.writebacks"] == 0
    assert "--flush: a DRAM has nothing" in replay("--flush", "--to", "dram", exit_code=2).stderr


def test_accesses_are_made_at_their_cycles_if_the_trace_has_some(tmp_path):
    (tmp_path / "a.csv").write_text("cycle,address,kind,bytes,requester\n0,0,read,4,0\n5000,4,read,4,0\n")
    replayed = ("replay", "a.csv", "--format", "csv", "--machine", "tiny", "--json")

    cycles = [
        json.loads(archsim_(*replayed, *mode).stdout)["summary"]["replay.cycles"]
        for mode in ([], ["--at-cycles"])
    ]

    assert cycles == [20 + 1, 5000 + 1]
    (tmp_path / "a.din").write_text("0 0\n")
    assert "--at-cycles: 'dinero' does not say when" in replay("--at-cycles", exit_code=2).stderr
    assert "not with --functional" in archsim_(*replayed, "--at-cycles", "--functional", exit_code=2).stderr


@pytest.mark.parametrize("mode", [[], ["--outstanding", "3"], ["--to", "dram"], ["--flush"]])
def test_the_dram_commands_of_a_replay_obey_the_data_sheet(tmp_path, mode):
    (tmp_path / "a.din").write_text("".join(f"{k % 2} {k * 5813 % 65536:x}\n" for k in range(400)))

    replay("--commands", "c.csv", *mode)

    judged = archsim_("check-dram", "c.csv", "--machine", "tiny").stdout
    assert "no violation" in judged
    assert " RD" in judged


def test_the_options_of_a_replay_are_listed_in_sections():
    helped = archsim_("replay", "--help").stdout

    heads = ["Arguments:", "Where the accesses go:", "When they are made:", "What comes out:"]
    places = [helped.index(head) for head in heads]
    assert places == sorted(places)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--to", "l4"], "the machine has no level 'l4'"),
        (["--cores", "bilder"], "the machine has no cores 'bilder'; did you mean 'builder'?"),
        (["--model", "fast"], "--model: no model is named 'fast'"),
        (["--set", "components.l2.siez=1KiB"], "did you mean 'size'"),
    ],
)
def test_bad_options_are_named(tmp_path, arguments, message):
    (tmp_path / "a.din").write_text("0 0\n")
    assert message in replay(*arguments, exit_code=2).stderr


def test_machines_and_files_that_are_not_there(tmp_path):
    assert "cannot be read: No such file" in replay(exit_code=2).stderr
    (tmp_path / "a.din").write_text("0 0\n")
    result = archsim_("replay", "a.din", "--format", "dinero", "--machine", "tinny", exit_code=2)
    assert "no packaged machine 'tinny'; did you mean 'tiny'?" in result.stderr


def test_a_trace_may_go_straight_to_the_dram(tmp_path):
    (tmp_path / "a.din").write_text("0 0\n1 40\n0 2000000\n")

    tree = json.loads(replay("--to", "dram", "--json").stdout)

    assert tree["summary"]["dram.requests"] == 3
    assert sum(bucket["reads"] for bucket in tree["latency"]) == 2
    assert "reads of 16 to 31 clocks" in replay("--to", "dram").stdout
    assert (
        "--functional: a DRAM is replayed with time only"
        in replay("--to", "dram", "--functional", exit_code=2).stderr
    )


def test_a_run_is_exported_and_replayed():
    small = ["--set", "scene.resolution=[8, 8]"]
    said = archsim_("export", "tiny", "--format", "dramsim3", "--at", "dram", "--out", "a.gz", *small).stdout
    count = int(said.split()[0].replace(",", ""))

    info = json.loads(archsim_("info", "a.gz", "--format", "dramsim3", "--json").stdout)
    again = archsim_("replay", "a.gz", "--format", "dramsim3", "--machine", "tiny", "--to", "dram", "--json")

    assert info["accesses"] == count > 0
    assert json.loads(again.stdout)["summary"]["dram.requests"] == count


def test_a_trace_that_fails_on_the_way_leaves_nothing(tmp_path):
    result = archsim_("export", "tiny", "--format", "csv", "--at", "l9", exit_code=2)

    assert "the machine has no level 'l9'" in result.stderr
    assert not list(tmp_path.iterdir())
