"""The fifo between the source and the cores holds its producer back when it is full."""

import pytest

from archsim.model.core.spec import TaskOrder
from archsim.model.fifo.reference import Fifo
from archsim.model.fifo.spec import FifoSpec
from archsim.model.unit.spec import UnitSpec
from tests.machine.build import both_models, machine, work


def run(simulate, num_entries):
    """One long task, then six tasks of one cycle, made every 2 cycles if there is room."""
    spec = machine(source=UnitSpec(2), fifo=FifoSpec(num_entries))
    spec = spec._replace(core=spec.core._replace(task_order=TaskOrder.FIRST_FREE))
    return simulate(spec, work([20], *[[1]] * 6))


@both_models
@pytest.mark.parametrize(
    ("num_entries", "cycles"),
    [
        (0, 33),  # only an idle thread gets a task: the long one in slot 1, the short ones in 22, 24 ... 32
        (1, 30),  # one waits: the short ones in 20, 21, 23 ... 29
        (6, 26),  # all wait
    ],
)
def test_the_fifo_bounds_how_far_the_source_runs_ahead(simulate, num_entries, cycles):
    assert run(simulate, num_entries).cycles == cycles


def test_first_in_first_out():
    fifo = Fifo(FifoSpec(2))
    fifo.push("a")
    assert not fifo.is_full()
    fifo.push("b")

    assert fifo.is_full()
    assert [fifo.pop(), fifo.pop()] == ["a", "b"]
    assert fifo.is_empty()
