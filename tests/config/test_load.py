"""Loading: packaged configurations, resolved text that loads back, origins, and no heavy imports."""

from __future__ import annotations

import subprocess
import sys

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from archsim import resources
from archsim.config import (
    IzbConfig,
    MachineConfig,
    RunConfig,
    SceneConfig,
    WalkthroughConfig,
    load_any,
    load_machine,
    load_run,
    load_run_with_origins,
    load_scene,
    load_sweep,
    resolved_yaml,
)
from archsim.config.dram import DramConfig
from archsim.errors import ArchsimError

CONFIGS = resources.root() / "configs"


def packaged(kind: str) -> list[str]:
    return sorted(path.stem for path in (CONFIGS / kind).glob("*.yaml"))


@pytest.mark.parametrize("name", packaged("runs"))
def test_packaged_runs_load_and_are_called_by_their_file(name):
    assert load_run(resources.config("runs", name)).name == name


@pytest.mark.parametrize("name", packaged("machines"))
def test_packaged_machines_load_and_are_called_by_their_file(name):
    assert load_machine(resources.config("machines", name)).name == name


@pytest.mark.parametrize("name", packaged("scenes"))
def test_packaged_scenes_load_and_are_called_by_their_file(name):
    assert load_scene(resources.config("scenes", name)).name == name


@pytest.mark.parametrize("name", packaged("runs"))
def test_resolved_text_loads_back_to_an_equal_run(write, name):
    run = load_run(resources.config("runs", name))
    text = resolved_yaml(run)
    assert load_run(write("resolved.yaml", text)) == run
    assert "base:" not in text
    assert "line: 64 B" in text


def test_resolved_text_is_in_the_order_of_the_schema():
    text = resolved_yaml(load_run("runs/tiny.yaml", ["seed=3"]))
    keys = [line.partition(":")[0] for line in text.splitlines() if line[0] not in " -"]
    assert keys == list(RunConfig.model_fields)


def test_resolved_meshes_are_absolute_paths_or_names(write):
    write("cube.npz", "")
    by_path = load_run("runs/tiny.yaml", ["scene.mesh=cube.npz"])
    write("elsewhere/resolved.yaml", resolved_yaml(by_path))
    assert load_run("elsewhere/resolved.yaml") == by_path
    assert "mesh: nx_aggressor_7k5" in resolved_yaml(
        load_run("runs/tiny.yaml", ["scene.mesh=nx_aggressor_7k5"])
    )


_SIZES = st.integers(0, 6).map(lambda power: 2**power)
_NUMBERS = st.floats(-1e9, 1e9, allow_subnormal=True).map(lambda number: 0.0 if number == 0 else number)
_OVERRIDES = st.fixed_dictionaries(
    {},
    optional={
        "name": st.from_regex(r"\A[A-Za-z0-9][A-Za-z0-9 _.+-]{0,20}\Z"),
        "seed": st.integers(0, 2**32 - 1),
        "model": st.sampled_from(["reference", "compiled"]),
        "scene.lights.0.position": st.tuples(_NUMBERS, _NUMBERS, _NUMBERS).map(list),
        "scene.camera.near": st.floats(1e-300, 1e9),
        "scene.mesh.seed": st.integers(0, 2**32 - 1),
        "scene.mesh.parameters": st.dictionaries(
            st.text("aby1.e ~", max_size=5), _NUMBERS | st.integers(-9, 9)
        ),
        "workload.depth_offset_cells": st.floats(0, 1000),
        "machine.clocks.core": st.integers(1, 4000).map(lambda megahertz: f"{megahertz} MHz"),
        "machine.components.l2.size": _SIZES.map(lambda sets: sets * 128),
        "machine.components.l2.hit_cycles": st.integers(1, 10**6),
        "machine.components.dram.timing.n_wr": st.integers(1, 10**6),
    },
)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(_OVERRIDES)
def test_any_run_loads_back_from_its_resolved_text(write, chosen):
    overrides = [f"{path}={value!r}" for path, value in chosen.items()]
    run = load_run("runs/tiny.yaml", overrides)
    text = resolved_yaml(run)
    again = load_run(write("resolved.yaml", text))
    assert again == run
    assert resolved_yaml(again) == text


def test_origins_tell_where_each_value_is_written(write):
    write("run.yaml", "base: runs/tiny.yaml\nworkload:\n  light: 0\n")
    loaded = load_run_with_origins("run.yaml", ["machine.components.l2.ways=4"])
    assert str(loaded.origin("workload.light")) == "run.yaml:3:10"
    assert str(loaded.origin("machine.components.l2.ways")) == "--set machine.components.l2.ways=4"
    assert loaded.origin("machine.components.l2.size").file.endswith("configs/machines/tiny.yaml")
    assert loaded.origin("scene.lights.0.position").file.endswith("configs/scenes/tiny.yaml")
    assert loaded.origin("workload.tile_order").file.endswith("configs/workloads/izb.yaml")
    assert loaded.origin("model") is None
    assert loaded.config == load_run("run.yaml", ["machine.components.l2.ways=4"])


def test_a_machine_replaces_a_machine(problems):
    run = load_run("runs/tiny.yaml", ["machine=machines/johnson2004.yaml"])
    assert run.machine == load_machine("machines/johnson2004.yaml")


def test_runs_are_frozen():
    run = load_run("runs/tiny.yaml")
    with pytest.raises(ValidationError, match="frozen"):
        run.seed = 1


def test_the_schema_can_be_exported():
    schema = RunConfig.model_json_schema()
    assert schema["$defs"]["CacheConfig"]["properties"]["size"]["examples"] == ["16 KiB"]


def test_importing_configurations_imports_nothing_heavy():
    code = (
        "import archsim.config, sys; print([m for m in ('numpy', 'numba', 'matplotlib') if m in sys.modules])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=resources.root()
    )
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("path", "kind"),
    [
        ("runs/tiny.yaml", RunConfig),
        ("machines/johnson2004.yaml", MachineConfig),
        ("scenes/tiny.yaml", SceneConfig),
        ("workloads/izb.yaml", IzbConfig),
    ],
)
def test_the_keys_tell_what_a_file_describes(path, kind):
    assert isinstance(load_any(path), kind)


def test_walkthroughs_and_components_by_themselves_are_told_apart_too():
    walkthrough = resources.experiment("aila2004") / "knights.yaml"
    assert isinstance(load_any(walkthrough), WalkthroughConfig)
    assert isinstance(load_any("dram/hbm2.yaml"), DramConfig)


def test_a_drawn_range_is_checked_in_plain_words(tmp_path):
    """Of a range and a list, either of which may be there, what is said is about the one that is."""
    path = tmp_path / "sweep.yaml"
    path.write_text(
        "name: s\nrun: tiny\nparameters:\n"
        "- random: {count: 2, seed: 1, values: {seed: {low: 5, high: 3}, a: {low: x, high: 2}, b: 7}}\n"
    )
    with pytest.raises(ArchsimError) as caught:
        load_sweep(path)

    values = "parameters.0.random.values"
    assert [problem.what for problem in caught.value.problems] == [
        f"{values}.seed.high: must be at least low, 5",
        f"{values}.a.low: must be a number, not 'x'",
        f"{values}.b: must be a list, not 7",
    ]
