"""The referee finds no fault in what the controllers do, and every fault put there."""

from collections import Counter

import pytest

from archsim.machine.command_trace import written_commands
from archsim.machine.dram_alone import compiled, reference
from archsim.trace.referee.commands import read_commands
from archsim.trace.referee.rules import violations
from tests.machine.dram_alone.machines import COMMANDED, LINE_BYTES, preset, random_stream, spec_of

WRITE_QUEUE = "write_queue={entries: 24, high: 16, low: 4}"
CONTROLLERS = {
    "open page": [],
    "in order": ["scheduler=fcfs"],
    "impatient": ["max_wait_clocks=50", "bank_hash=xor"],
    "closed page": ["page_policy=closed", WRITE_QUEUE],
    "time-out": ["page_policy=timeout", "page_timeout_clocks=60", "bank_hash=xor", WRITE_QUEUE],
}


def refereed(tmp_path, dram, spec, stream, model=compiled):
    """What the referee finds, and how many commands of each kind it saw."""
    path = tmp_path / "commands.csv"
    with written_commands(spec, path) as sink:
        model.simulate(spec, LINE_BYTES, [stream], sink)
    seen = Counter()
    commands = []
    for command in read_commands(path):
        seen[command.command] += 1
        commands.append(command)
    return list(violations(dram, commands)), seen


@pytest.mark.parametrize("controller", CONTROLLERS)
@pytest.mark.parametrize("name", COMMANDED)
def test_no_rule_is_broken(tmp_path, name, controller):
    dram = preset(name, *CONTROLLERS[controller])
    spec, count = spec_of(dram), 2000
    stream = random_stream(dram, count, seed=7, gap=4)
    found, seen = refereed(tmp_path, dram, spec, stream)

    assert found == []
    bursts = LINE_BYTES // dram.burst_bytes
    forwarded = compiled.simulate(spec, LINE_BYTES, [stream]).counters["forwarded"].sum()
    assert seen["RD"] + seen["WR"] == (count - forwarded) * bursts
    assert seen["REF"] > 0


def test_no_rule_is_broken_in_a_long_run(tmp_path):
    dram = preset("ddr4_3200", WRITE_QUEUE)
    found, seen = refereed(tmp_path, dram, spec_of(dram), random_stream(dram, 40_000, seed=1))

    assert found == []
    assert seen["REF"] > 20


def test_the_reference_breaks_no_rule(tmp_path):
    dram = preset("ddr4_3200", WRITE_QUEUE)
    stream = random_stream(dram, 1000, seed=3)

    assert refereed(tmp_path, dram, spec_of(dram), stream, reference)[0] == []


RULES = [
    "n_rcd_read",
    "n_rcd_write",
    "n_rp",
    "n_ras",
    "n_rc",
    "n_rrd",
    "n_rrd_l",
    "n_faw",
    "n_ccd",
    "n_ccd_l",
]
RULES += ["n_rtp", "n_wr", "n_wtr", "n_wtr_l", "n_rtw", "n_rfc"]


@pytest.mark.parametrize("rule", RULES)
def test_a_controller_that_keeps_a_rule_badly_is_caught(tmp_path, rule):
    """The controller believes in one clock less than the referee; n_rc and n_rrd bind when they are raised."""
    binding = {"n_rc": 90, "n_rrd": 8, "n_rrd_l": 16, "n_faw": 60, "n_ccd": 6, "n_ras": 60, "n_rtp": 30}.get(
        rule
    )
    raised = [f"timing.{rule}={binding}"] if binding else []
    raised += ["timing.n_rc=90"] if rule == "n_ras" else []
    raised += ["timing.n_rrd_l=8"] if rule == "n_rrd" else []
    dram = preset("ddr4_3200", "page_policy=closed", *raised)
    spec = spec_of(dram)
    timing = spec.timing._replace(**{rule: getattr(spec.timing, rule) - 1})
    stream = random_stream(dram, 3000, seed=11, writes=0.5)
    found, _ = refereed(tmp_path, dram, spec._replace(timing=timing), stream)

    assert {violation.rule for violation in found} == {rule}


def test_a_controller_that_never_refreshes_is_caught(tmp_path):
    dram = preset("ddr4_3200")
    spec = spec_of(dram)
    lazy = spec._replace(timing=spec.timing._replace(n_refi=0))
    found, _ = refereed(tmp_path, dram, lazy, random_stream(dram, 3000, seed=11, gap=80))

    assert {violation.rule for violation in found} == {"n_refi"}
