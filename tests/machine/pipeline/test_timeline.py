"""A pipeline's timeline agrees with its counters, and recording it changes nothing."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from archsim.machine.pipeline import reference
from archsim.machine.pipeline.timeline import DOES, PipelineRecorder, TaskRecorder
from archsim.machine.timeline import Window
from archsim.model.unit.spec import Slot
from archsim.report.waterfall import waterfall
from tests.machine.pipeline.build import UNIT, chain, difference, emit, take, work
from tests.machine.pipeline.strategies import cases
from tests.machine.pipeline.test_differential import played

quick = settings(max_examples=30, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))


@quick
@given(cases())
def test_every_cycle_of_every_unit_is_recorded(case):
    recorder = PipelineRecorder(case.spec)

    def recorded(spec, work):
        return reference.simulate(spec, work, observe=recorder.attach)

    counters, found = played(recorded, case), recorder.timeline()

    assert not difference(counters, played(reference.simulate, case))
    assert [len(spans) for spans in found.tasks.values()] == counters.unit_tasks.tolist()
    for unit in range(len(case.spec.units)):
        for slot in Slot:
            if slot is not Slot.NO_WORK:  # goes on while the memory drains
                spans = [span for span in found.waits[unit, 0] if span.name == DOES[slot]]
                cycles = sum(span.end - span.start for span in spans) // case.spec.period_ticks
                assert cycles == counters.unit_slots[unit, slot]
    for channel in range(case.spec.num_channels):
        held = [items for _, number, items in found.held if number == channel]
        assert (not held and not counters.channel_put[channel]) or held[-1] == 0


@quick
@given(cases())
def test_a_window_shows_what_the_whole_shows_there(case):
    window = Window(3, 20)
    shown = []
    for part in (Window(0, 1 << 40), window):
        recorder = PipelineRecorder(case.spec, part)

        def recorded(spec, work, attach=recorder.attach):
            return reference.simulate(spec, work, observe=attach)

        played(recorded, case)
        shown.append(waterfall(recorder.timeline(), window, tuple("abcdefgh")))

    assert shown[0] == shown[1]


ITEMS = 10
CHAIN = chain(UNIT._replace(interval_cycles=3, latency_cycles=2), UNIT._replace(interval_cycles=5))


@pytest.mark.parametrize(
    ("units", "window"),
    [
        ((0,), Window(2 * 3, 4 * 3 + 1)),  # its tasks begin every 3 cycles
        ((1,), Window(3 + 2 * 5, 3 + 4 * 5 + 1)),  # the first item is taken in 3, then one every 5 cycles
        ((0, 1), Window(2 * 3, 3 + 4 * 5 + 1)),
    ],
)
def test_tasks_are_shown_from_the_first_ones_beginning_to_the_last_ones_end(units, window):
    recorder = TaskRecorder(CHAIN, Window(2, 4), units)
    reference.simulate(CHAIN, work([[emit()]] * ITEMS, [[take()]] * ITEMS), observe=recorder.attach)
    found = recorder.timeline()

    assert recorder.window() == window
    for unit in units:
        assert {"task 2", "task 3"} <= {span.name for span in found.tasks[unit, 0]}
    shown = waterfall(found, window, ("a", "b")).splitlines()[1:3]
    assert all(" " not in line.partition("|")[2] for line in shown)


def test_there_may_be_no_such_tasks():
    recorder = TaskRecorder(CHAIN, Window(ITEMS, ITEMS + 1), (0, 1))
    reference.simulate(CHAIN, work([[emit()]] * ITEMS, [[take()]] * ITEMS), observe=recorder.attach)

    assert recorder.window() is None


@quick
@given(cases(), st.integers(0, 3), st.integers(1, 3), st.sampled_from([(0,), (1,), (0, 1)]))
def test_what_is_shown_of_tasks_is_what_their_cycles_show(case, first, number, units):
    recorder = TaskRecorder(case.spec, Window(first, first + number), units)
    counters = played(reference.simulate, case)
    played(lambda spec, work: reference.simulate(spec, work, observe=recorder.attach), case)
    window = recorder.window()

    assert (window is None) == (counters.unit_tasks[list(units)].max() <= first)
    if window is not None:
        whole = PipelineRecorder(case.spec, window)
        played(lambda spec, work: reference.simulate(spec, work, observe=whole.attach), case)
        assert recorder.timeline() == whole.timeline()
