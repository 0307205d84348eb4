"""A pipeline's timeline agrees with its counters, and recording it changes nothing."""

from hypothesis import HealthCheck, given, settings

from archsim.machine.pipeline import reference
from archsim.machine.pipeline.timeline import DOES, PipelineRecorder
from archsim.machine.timeline import Window
from archsim.model.unit.spec import Slot
from archsim.report.waterfall import waterfall
from tests.machine.pipeline.build import difference
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
