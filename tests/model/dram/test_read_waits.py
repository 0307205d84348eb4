"""What the clocks of a read go into: by hand, and that they add up to its latency."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

from archsim.machine.dram_alone import compiled, reference
from archsim.machine.dram_alone.stream import Requests
from tests.machine.build import DRAM, TIMING, address
from tests.machine.dram_alone.test_equal import REQUEST_BYTES, streams
from tests.machine.strategies import drams

PARTS = ("queue", "refresh", "activation", "turnaround", "bus")
BUS = TIMING.n_cl + 1


def waits(run):
    return {part: int(run.counters[f"read_{part}_clocks"].sum()) for part in PARTS}


def served(model, spec, *requests):
    """Requests of (address, is_write, arrival) of 8 bytes."""
    columns = zip(*requests, strict=True)
    kinds = (np.int64, np.bool_, np.int64)
    stream = Requests(*(np.array(column, kind) for column, kind in zip(columns, kinds, strict=True)))
    return waits(model.simulate(spec, 8, [stream]))


@pytest.fixture(params=[reference, compiled], ids=["reference", "compiled"])
def model(request):
    return request.param


def test_a_closed_bank_costs_an_activation(model):
    wanted = {"queue": 0, "refresh": 0, "activation": TIMING.n_rcd_read, "turnaround": 0, "bus": BUS}
    assert served(model, DRAM, (address(), False, 0)) == wanted


def test_an_open_row_costs_the_bus_alone(model):
    both = served(model, DRAM, (address(), False, 0), (address(column=1), False, 100))
    assert both == {**served(model, DRAM, (address(), False, 0)), "bus": 2 * BUS}


def test_another_row_has_to_be_closed(model):
    """The bank may be closed at once: n_rp and n_rcd_read are the second read's."""
    found = served(model, DRAM, (address(), False, 0), (address(row=1), False, 100))
    assert found["activation"] == TIMING.n_rcd_read + TIMING.n_rp + TIMING.n_rcd_read
    assert found["queue"] == 0


def test_a_row_that_must_stay_open_is_waited_for_in_the_queue(model):
    """ACT 0, so PRE at n_ras at the earliest, or n_rtp after the RD; the second read came at 1."""
    found = served(model, DRAM, (address(), False, 0), (address(row=1), False, 1))
    closed = max(TIMING.n_ras, TIMING.n_rcd_read + TIMING.n_rtp)
    assert found["queue"] == closed - 1


def test_a_read_waits_for_the_bus_to_turn(model):
    """The write's data ends n_wl + 1 after its WR; the read came while it was under way."""
    found = served(model, DRAM, (address(), True, 0), (address(column=1), False, 10))
    write = TIMING.n_rcd_write
    ended = write + TIMING.n_wl + 1
    ready = TIMING.n_rcd_read  # of the row, for reads
    assert found["turnaround"] == ended + TIMING.n_wtr - max(ended, ready)
    assert found["activation"] == ready - 10
    assert found["queue"] == max(0, ended - ready)


def test_a_read_waits_for_a_refresh(model):
    """REF at 211: the read that came in 214 waits for it to end, then for its row."""
    spec = DRAM._replace(timing=TIMING._replace(n_refi=211))
    found = served(model, spec, (address(), False, 214))
    assert (found["refresh"], found["activation"], found["queue"]) == (TIMING.n_rfc - 3, TIMING.n_rcd_read, 0)


@settings(max_examples=200, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(drams(1, REQUEST_BYTES), streams())
def test_the_parts_add_up_to_the_latency(spec, stream):
    run = compiled.simulate(spec, REQUEST_BYTES, [stream])
    parts = waits(run)

    assert min(parts.values()) >= 0
    assert sum(parts.values()) + int(run.counters["forwarded"].sum()) == run.latency_sum
