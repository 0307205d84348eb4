"""What both models record of the DRAM's commands is the same, is what was counted, and breaks no rule."""

import io

import numpy as np
from hypothesis import HealthCheck, given, settings

from archsim.machine import compiled, reference
from archsim.machine.command_trace import HEADER, CommandWriter
from archsim.model.dram.commands import COMMAND, Command
from archsim.model.dram.compiled_state import LOG_CAPACITY
from archsim.trace.stream import whole
from tests.machine.build import CACHE, DRAM, cached, load, work
from tests.machine.strategies import many_tasks, plays


def recorded(model, spec, played):
    taken = [np.zeros(0, COMMAND)]
    counters = model.simulate(spec, played, sink=taken.append)
    commands = np.concatenate(taken)
    assert np.all(np.diff(commands["clock"]) >= 0)
    return counters, np.sort(commands, order=["clock", "channel"]), len(taken) - 1


@settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(plays(many_tasks()))
def test_both_models_record_the_same(played):
    spec, tasks = played
    counters, wanted, _ = recorded(reference, spec, whole(tasks))
    _, found, _ = recorded(compiled, spec, whole(tasks))

    assert found.tolist() == wanted.tolist()
    kinds = np.bincount(wanted["command"], minlength=len(Command))
    assert kinds[Command.ACT] == counters.dram_activates.sum()
    assert kinds[Command.PRE] + kinds[Command.PREA] == counters.dram_precharges.sum()
    assert kinds[Command.REF] == counters.dram_refreshes.sum()


def test_a_long_record_is_taken_in_parts():
    """Every load misses: 16 lines a row, so a PRE, an ACT and 16 RD for 16 loads."""
    spec = cached(CACHE._replace(num_sets=1, num_ways=1))
    loads = [load(line * CACHE.line_bytes % (1 << 17)) for line in range(LOG_CAPACITY)]
    counters, commands, num_parts = recorded(compiled, spec, work(loads))

    assert num_parts > 2
    assert np.all(np.diff(commands["clock"]) > 0)
    assert np.count_nonzero(commands["command"] == Command.RD) == counters.dram_reads[0] == LOG_CAPACITY


def test_bursts_are_written_in_order_of_clock():
    """Two requests of three bursts 5 apart; columns in beats."""
    spec = DRAM._replace(burst_beats=4, timing=DRAM.timing._replace(n_ccd_l=5))
    text = io.StringIO()
    writer = CommandWriter(spec, text)
    rows = [(0, 0, Command.ACT, 1, 7, 0, 0), (4, 0, Command.RD, 1, 7, 6, 3), (6, 0, Command.ACT, 2, 9, 0, 0)]
    writer(np.array(rows[:2], COMMAND))
    writer(np.array([*rows[2:], (20, 0, Command.PREA, 0, 0, 0, 0)], COMMAND))
    writer.finish()

    lines = [
        "0,0,ACT,1,7,",
        "4,0,RD,1,7,24",
        "6,0,ACT,2,9,",
        "9,0,RD,1,7,28",
        "14,0,RD,1,7,32",
        "20,0,PREA,,,",
    ]
    assert text.getvalue().splitlines() == [HEADER, *lines]
