"""Work that was rendered, kept and read back gives the same result on every machine that may share it."""

import json

import numpy as np
import pytest

from archsim.config import load_run
from archsim.errors import ArchsimError
from archsim.run.folder import result_json
from archsim.run.kinds import kind_of
from tests.run.small import KNIGHTS as SMALL_KNIGHTS

TINY = ("runs/tiny.yaml", "scene.resolution=[32, 24]")
LIGHT_INSIDE = "scene.lights=[{position: [0.1, -0.3, 0.2]}]"
NOTHING_SEEN = "scene.camera.target=[0, -100, 50]"
KNIGHTS = ("runs/hsv_knights_hierarchical.yaml", *SMALL_KNIGHTS)
KERNELS = ("runs/hsv_kernels_tiny.yaml", "scene.resolution=[48,40]", "scene.mesh.parameters.knights=2")
MAPS = ("runs/lograster_tiny.yaml", "workload.texels=[64, 64]")

C = "machine.components."
CORES = ((), (C + "l2.size=4KiB", C + "shader.threads=5"))
UNITS = ((), (C + "stage_1.lanes=4", C + "dram.scheduler=fcfs", C + "tiles.entries=8"))
PROGRAMMED = ((), (C + "processors.threads=2", C + "psv_cache.ways=2"))
TILES = ((), (C + "evaluator.exponentials=4", C + "fine.interval_cycles=3", C + "dram.channels=2"))

RUNS = {
    "izb": (TINY, CORES),
    "izb, several light views": ((*TINY, LIGHT_INSIDE), CORES),
    "izb, nothing to see": ((*TINY, NOTHING_SEEN), CORES),
    "izb, dealt to threads": ((*TINY, "workload.tile_order=block", "workload.node_layout=pool"), CORES),
    "hsv": (KNIGHTS, UNITS),
    "hsv, submitted twice": ((*KNIGHTS, "workload.submission=twice"), UNITS),
    "hsv, brute force": ((*KNIGHTS, "workload.variant=brute_force"), UNITS),
    "hsv, overflow": ((*KNIGHTS, "workload.casters=whole", C + "delay_stream.size=1 KiB"), UNITS),
    "hsv kernels": (KERNELS, PROGRAMMED),
    "maps": (MAPS, TILES),
    "maps, table": ((*MAPS, C + "evaluator.design=table", C + "evaluator.kept_lines=1"), TILES),
    "maps, several": ((*MAPS, "workload.rasterization=linear", "workload.maps=csm_lispsm"), TILES),
}


def load(run, *more):
    return load_run(run[0], [*run[1:], *more])


def everything(result):
    """All of a result, as something that can be compared."""
    arrays = [result.shadow, *(each.counts for each in result.histograms), *result.maps.values()]
    titles = [*(each.title for each in result.histograms), *result.maps]
    return result_json(result), titles, [(array.dtype, array.shape, array.tobytes()) for array in arrays]


@pytest.mark.parametrize(("run", "machines"), RUNS.values(), ids=RUNS)
def test_what_is_kept_gives_every_machine_its_own_result(tmp_path, run, machines):
    kind_of(load(run)).render(load(run), tmp_path)

    for machine in machines:
        config = load(run, *machine, "statistics.interval_cycles=500")
        kind = kind_of(config)
        own = kind.simulate(config)
        for _ in range(2):
            replayed = kind.replay(config, tmp_path)
            assert everything(replayed) == everything(own)
            assert replayed.ok
            assert replayed.series.keys() == own.series.keys()


@pytest.mark.parametrize("name", ["izb", "hsv", "hsv kernels", "maps"])
def test_the_reference_model_plays_what_is_kept_like_a_run_on_its_own(tmp_path, name):
    run, (_, machine) = RUNS[name]
    smaller = () if name == "maps" else ("scene.resolution=[24, 20]",)
    kind_of(load(run)).render(load(run, *smaller), tmp_path)

    config = load(run, *smaller, *machine, "model=reference")
    kind = kind_of(config)

    assert everything(kind.replay(config, tmp_path)) == everything(kind.simulate(config))


def takes(run, *more):
    config = load(run, *more)
    return json.dumps(kind_of(config).functional(config).described())


CHANGES_WORK = [
    (TINY, "workload.locks=8"),
    ((*TINY, "workload.tile_order=block"), C + "builder.threads=3"),
    ((*TINY, "workload.node_layout=pool"), C + "builder.threads=3"),
    (KNIGHTS, C + "psv_buffers.count=2"),
    (KNIGHTS, C + "psv_cache.size=4 KiB"),
    (KNIGHTS, C + "psv_cache.line=64 B"),
    (KNIGHTS, C + "psv_cache.ways=2"),
    (KNIGHTS, C + "delay_stream.size=4 KiB"),
    (KERNELS, "workload.psv_buffers=2"),
    (KERNELS, "workload.fixed_function.components.psv_cache.size=4 KiB"),
    (MAPS, C + "z_cache.size=6 KiB"),
    (MAPS, C + "z_cache.ways=2"),
    (MAPS, C + "z_cache.codec=anchor"),
    (MAPS, C + "z_cache.granularity=8 B"),
    (MAPS, C + "z_cache.first_row=far"),
    (MAPS, C + "z_cache.last_delta=row_2"),
    ((*MAPS, C + "z_cache.codec=none"), C + "z_cache.tile=8"),
    (MAPS, C + "evaluator.design=full"),
    (MAPS, C + "evaluator.constant_bits=8"),
    ((*MAPS, C + "evaluator.design=table"), C + "evaluator.kept_lines=1"),
]
CHANGES_TIME = [
    (TINY, C + "builder.threads=3"),
    (TINY, C + "l2.size=4KiB"),
    (KNIGHTS, C + "stage_2.lanes=4"),
    (KNIGHTS, C + "psv_cache.mshrs=2"),
    (KNIGHTS, C + "delay_stream.prefetch=2 KiB"),
    (KNIGHTS, "machine.clocks.core=500 MHz"),
    (KNIGHTS, "model=reference"),
    (KERNELS, C + "processors.count=2"),
    (KERNELS, C + "psv_cache.size=32 KiB"),
    (MAPS, C + "evaluator.exponentials=4"),
    (MAPS, C + "evaluator.kept_lines=1"),
    (MAPS, C + "dram.scheduler=fcfs"),
]


@pytest.mark.parametrize(("run", "change"), CHANGES_WORK)
def test_what_changes_the_work_is_not_shared(tmp_path, run, change):
    assert takes(run) != takes(run, change)

    kind_of(load(run)).render(load(run), tmp_path)
    with pytest.raises(ArchsimError, match="the work of a run whose picture or work differs"):
        kind_of(load(run)).replay(load(run, change), tmp_path)


@pytest.mark.parametrize(("run", "change"), CHANGES_TIME)
def test_what_changes_time_only_is_shared(run, change):
    assert takes(run) == takes(run, change)


def test_executing_sees_nothing_of_the_machine_but_what_is_compared():
    """A wrong share would need a way around `Functional`."""
    config = load(MAPS)
    functional = kind_of(config).functional(config)

    assert functional._fields == ("scene", "workload", "seed", "taken")
    assert set(functional.described()) == {"scene", "workload", "seed", "machine"}
    assert functional.described()["machine"] == functional.taken._asdict()


def test_chunks_are_read_one_by_one(tmp_path, monkeypatch):
    from archsim.trace import kept
    from archsim.trace.records import RECORD, Tasks

    task = Tasks(np.array([0, 1]), np.zeros(1, RECORD))
    kept.write_chunks(tmp_path / "work", ((task, task) for _ in range(3)))
    loaded = []
    real = np.load
    monkeypatch.setattr(kept.np, "load", lambda stream: loaded.append(1) or real(stream))

    chunks = kept.read_chunks(tmp_path / "work", 2)
    next(chunks)
    assert len(loaded) == 4
    assert len(list(chunks)) == 2


ONE_ROW = (C + "dram.channels=1", C + "dram.rows=1")
TOO_SMALL = {
    "izb": (TINY, ONE_ROW),
    "hsv": (KNIGHTS, (C + "delay_stream.address=64 KiB",)),
    "hsv kernels": (KERNELS, (C + "locks.count=8",)),
    "maps": ((*MAPS, "workload.texels=[256, 256]"), ONE_ROW),
}


@pytest.mark.parametrize(("run", "small"), TOO_SMALL.values(), ids=TOO_SMALL)
def test_a_machine_that_cannot_hold_the_run_is_refused_at_replay(tmp_path, run, small):
    config = load(run, *small)
    kind = kind_of(config)
    kind.render(load(run), tmp_path)

    refused = []
    for play in (kind.simulate, lambda config: kind.replay(config, tmp_path)):
        with pytest.raises(ArchsimError) as error:
            play(config)
        refused.append(str(error.value))
    assert refused[0] == refused[1]
