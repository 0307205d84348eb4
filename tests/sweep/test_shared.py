"""What points of a sweep share: every machine parameter of the packaged sweeps is on the right side."""

import pytest
import yaml

from archsim import resources
from archsim.config import load_run, load_sweep
from archsim.run import simulate
from archsim.run.folder import result_json
from archsim.run.kinds import kind_of
from archsim.sweep.expand import expand, overrides
from archsim.sweep.plan import make_plan
from archsim.sweep.start import run_sweep
from archsim.sweep.watch import SilentWatch
from tests.run.test_rendering import KNIGHTS, MAPS, everything
from tests.sweep.small import InlineWorkers, loaded_sweep

SWEEPS = {path.stem: path for path in sorted((resources.root() / "configs" / "sweeps").glob("*.yaml"))}
C = "machine.components."

# machine parameters of packaged sweeps that change picture or work; all the others change time only
FUNCTIONAL = {
    C + "psv_buffers.count",
    C + "psv_cache.size",
    C + "delay_stream.size",
    C + "evaluator.design",
    C + "evaluator.kept_lines",  # of designs with a table; the others are told nothing of it
    C + "z_cache.codec",
    C + "z_cache.size",
    C + "z_cache.tile",
}


def small_of(name: str) -> tuple[str, ...]:
    """A run of the same kind and machine that takes a second, and its values."""
    if name.startswith("hsv"):
        return KNIGHTS
    if name.startswith("lograster"):
        return (*MAPS, "workload.compare=none")
    run = "runs/tiny.yaml" if name == "tiny" else "runs/izb_knot.yaml"
    grids = ("workload.logical_grid=[64, 64]", "workload.physical_grid=[64, 64]")
    return (run, "scene.resolution=[32, 24]", *grids)


def pairs(name: str):
    """(parameter, values of one point, values of another) for every machine parameter of a packaged sweep."""
    points = expand(load_sweep(SWEEPS[name]))
    for key in dict.fromkeys(key for point in points for key in point if key.startswith("machine.")):
        one = next(point for point in points if key in point)
        others = [point for point in points if point.get(key, one[key]) != one[key]]
        yield key, one, min(others, key=lambda other: len(different(one, other)))


def different(one, other):
    return {key for key in {*one, *other} if one.get(key) != other.get(key)}


PAIRS = [(name, *pair) for name in SWEEPS for pair in pairs(name)]


def on_machine(name, point):
    """The small run with the point's values of the machine."""
    run, *own = small_of(name)
    machine = {key: value for key, value in point.items() if key.startswith("machine.")}
    return load_run(run, [*own, *overrides(machine)])


@pytest.mark.parametrize(("name", "key", "one", "other"), PAIRS, ids=[f"{n} {k}" for n, k, *_ in PAIRS])
def test_parameters_of_packaged_sweeps_are_on_the_right_side(tmp_path, name, key, one, other):
    first, second = on_machine(name, one), on_machine(name, other)
    kind = kind_of(first)

    shared = kind.functional(first).described() == kind.functional(second).described()

    assert shared == (not FUNCTIONAL & different(one, other))
    if shared:
        kind.render(first, tmp_path)
        assert everything(kind.replay(second, tmp_path)) == everything(kind.simulate(second))


PICTURES = {
    "izb_caches": (84, 4),
    "hsv_units": (24, 1),
    "hsv_psv": (8, 8),
    "lograster_memory": (24, 1),
    "lograster_evaluators": (6, 5),
    "tiny": (9, 1),
}


@pytest.mark.parametrize(("name", "expected"), PICTURES.items(), ids=PICTURES)
def test_packaged_sweeps_render_a_picture_for_each_functional_configuration(name, expected):
    config = load_sweep(SWEEPS[name])

    points = make_plan(config, config.run)

    assert (len(points), len({point.functional_digest for point in points})) == expected


def both_models(run, **changes):
    """A sweep of a small run over these values and both models."""
    pairs = (override.split("=", 1) for override in run[1:])
    own = {key: yaml.safe_load(text) for key, text in pairs}
    models = {"model": ["compiled", "reference"]}
    return loaded_sweep(run=run[0], set=own, parameters=[{"grid": {**changes, **models}}])


SMALL_SWEEPS = {
    "hsv": (KNIGHTS, {C + "stage_2.lanes": [1, 4], C + "psv_buffers.count": [1, 4]}),
    "maps": (MAPS, {C + "fine.interval_cycles": [1, 2], C + "z_cache.codec": ["lloyd", "none"]}),
}


@pytest.mark.parametrize(("run", "changes"), SMALL_SWEEPS.values(), ids=SMALL_SWEEPS)
def test_points_of_every_kind_have_the_results_of_their_runs(tmp_path, run, changes):
    loaded, workers = both_models(run, **changes), InlineWorkers()
    points = make_plan(loaded.config, loaded.config.run)

    tally = run_sweep(loaded, loaded.config.run, (points, points), tmp_path, (workers, "1of1", SilentWatch()))

    assert (tally.finished, tally.failed, workers.num_rendered) == (8, 0, 2)
    for point in points:
        stored = (tmp_path / "points" / point.digest / "result.json").read_text()
        assert stored == result_json(simulate(point.config))
    assert list((tmp_path / "work").iterdir()) == []
