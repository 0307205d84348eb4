"""Both models refuse the same work, in the same words, before they play any of it."""

import numpy as np
import pytest

from archsim.errors import ArchsimError
from archsim.machine import compiled, reference
from archsim.trace.records import RECORD, Op, Tasks
from archsim.trace.stream import whole
from tests.machine.build import machine


def one_task(*records):
    return whole(Tasks(np.array([0, len(records)]), np.array(list(records), RECORD)))


END = (0, 0, 0, Op.END)


@pytest.mark.parametrize("simulate", [reference.simulate, compiled.simulate])
@pytest.mark.parametrize(
    ("work", "message"),
    [
        ([(-16, 0, 4, Op.LOAD), END], "LOAD at address -16: addresses begin at 0"),
        ([(30, 0, 4, Op.STORE), END], r"STORE of addresses 30 to 33 crosses a line"),
        ([(99, 0, 0, Op.LOCK), END], "LOCK of lock 99: there are"),
        ([(-1, 0, 0, Op.UNLOCK), END], "UNLOCK of lock -1: there are"),
        ([(0, 3, 4, Op.LOAD)], "a task does not close with END"),
    ],
)
def test_what_cannot_be_played_is_refused(simulate, work, message):
    with pytest.raises(ArchsimError, match=message):
        simulate(machine(), one_task(*work))
