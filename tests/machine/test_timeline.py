"""A timeline by hand, and its agreement with the counters."""

from archsim.config import load_run
from archsim.machine import reference
from archsim.machine.build import phase_machine
from archsim.machine.timeline import COMPUTE, Recorder, Span, Window, record
from archsim.report.waterfall import waterfall
from archsim.run.izb_work import record as record_work
from archsim.run.izb_work import replay
from tests.machine.build import difference, lock, machine, unlock, work
from tests.model.unit.test_unit import fed


def test_two_cores_at_one_lock_by_hand():
    """Core 0 holds the lock from slot 0 to 4; core 1 asks in slot 0 and goes on in slot 5."""
    found = record(machine(num_cores=2), work([lock(0), 3, unlock(0)], [lock(0), 1, unlock(0)]))

    slots = [(slot.tick, slot.core, slot.op) for slot in found.slots]
    assert slots[:3] == [(0, 0, "LOCK"), (0, 1, "LOCK"), (1, 0, COMPUTE)]
    assert (4, 0, "UNLOCK") in slots
    assert (5, 1, COMPUTE) in slots
    assert found.waits == {(0, 0): [], (1, 0): [Span(1, 5, "lock")]}
    assert found.tasks == {(0, 0): [Span(0, 5, "task 0")], (1, 0): [Span(0, 7, "task 0")]}
    assert waterfall(found, Window(0, 8)).splitlines()[1:3] == [
        "core 0 thread  0 |KcccU   |",
        "core 1 thread  0 |KkkkkcU |",
    ]


def test_the_fifo_before_the_cores_is_noted_at_every_change():
    """A task a cycle; the only thread takes the first one in 0 and the second one in 5, when the fifo is full."""
    found = record(fed(1), work([5], [5], [5], [5]))

    assert found.held[:6] == [(0, 0, 1), (0, 0, 0), (1, 0, 1), (2, 0, 2), (5, 0, 1), (6, 0, 2)]
    assert found.held[-1] == (15, 0, 0)


def tiny(phase):
    config = load_run("runs/tiny.yaml", ["scene.resolution=[16, 12]"])
    (view,) = record_work(config)
    spec = phase_machine(config.machine, phase).spec
    return spec, lambda: replay(view, phase, spec)


def test_recording_changes_nothing_and_agrees_with_the_counters():
    for phase in ("izb_build", "izb_raster"):
        spec, fresh = tiny(phase)
        counters, recorder = reference.simulate(spec, fresh()), Recorder(spec)
        recorded = reference.simulate(spec, fresh(), observe=recorder.attach)
        found = recorder.timeline()

        assert not difference(recorded, counters)
        assert len(found.slots) == counters.useful.sum()
        assert sum(len(spans) for spans in found.tasks.values()) == counters.tasks.sum()
        assert len(found.accesses) == counters.cache_reads.sum() + counters.cache_writes.sum()
        assert sum(command.command == "ACT" for command in found.commands) == counters.dram_activates.sum()
        requests = sum(command.command in ("RD", "WR") for command in found.commands)
        assert requests == counters.dram_reads.sum() + counters.dram_writes.sum()


def test_a_window_is_cut_out_of_the_whole():
    spec, fresh = tiny("izb_build")
    window = Window(300, 900)
    whole, part = record(spec, fresh()), record(spec, fresh(), window)

    assert waterfall(part, window) == waterfall(whole, window)
    assert part.slots == [slot for slot in whole.slots if 300 <= slot.tick < 900]
    assert part.commands == [command for command in whole.commands if 300 <= command.tick < 900]
    assert 0 < len(part.accesses) < len(whole.accesses)
