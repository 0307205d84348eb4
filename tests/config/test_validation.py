"""Every problem of a run, all at once, in plain words and at its place."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from archsim.config import load_run
from archsim.config.document import dump
from archsim.errors import ArchsimError

MANY = """\
base: runs/tiny.yaml
modle: compiled
model: compild
seed: -1
name: 5
scene:
  mesh: nx_bloodprisn_8k9
  camera:
    eye: [0, 0]
    fovy_degrees: 180
    near: .nan
  lights: []
  resolution: [1280, true]
workload:
  light: yes
  physical_grid: [12, 0]
  tile_order: blok
machine:
  clocks: {core: 1.2 ghz}
  components:
    l2: {sise: 1 KiB, line: 16 KB, ports: 0, ways: 2.0, private: 1}
    foo: {kind: cashe}
    bar: 5
    baz: {}
    b.c: {kind: fifo, entries: 1}
    dram: {timing: {n_refi: 5, n_rc: 3}, scheduler: fifo}
"""


def test_all_problems_come_at_once_in_the_order_of_the_text(write, problems):
    write("run.yaml", MANY)
    assert problems(load_run, "run.yaml") == [
        "run.yaml:2:1: unknown key 'modle'; did you mean 'model'?",
        "run.yaml:3:8: model: must be reference or compiled, not 'compild'; did you mean 'compiled'?",
        "run.yaml:4:7: seed: must be at least 0, not -1",
        "run.yaml:5:7: name: must be text, not 5",
        "run.yaml:7:9: no packaged mesh is named 'nx_bloodprisn_8k9'; did you mean 'nx_bloodprison_8k9'?",
        "run.yaml:9:10: scene.camera.eye: too short a list",
        "run.yaml:10:19: scene.camera.fovy_degrees: must be at most 170, not 180",
        "run.yaml:11:11: scene.camera.near: must be a finite number, not nan",
        "run.yaml:12:11: scene.lights: must have at least 1 in it, not 0",
        "run.yaml:13:22: scene.resolution.1: must be a whole number, not true",
        "run.yaml:15:10: workload.light: must be a whole number, not 'yes'",
        "run.yaml:16:23: workload.physical_grid.1: must be at least 1, not 0",
        "run.yaml:17:15: workload.tile_order: must be interleaved or block, not 'blok'; did you mean 'block'?",
        "run.yaml:19:18: machine.clocks.core: '1.2 ghz' is not a frequency; did you mean 'GHz'?",
        "run.yaml:21:10: unknown key 'machine.components.l2.sise'; did you mean 'size'?",
        "run.yaml:21:29: machine.components.l2.line: '16 KB' is not a size; "
        "write KiB (1024 bytes) or kB (1000 bytes)",
        "run.yaml:21:43: machine.components.l2.ports: must be at least 1, not 0",
        "run.yaml:21:52: machine.components.l2.ways: must be a whole number, not 2.0",
        "run.yaml:21:66: machine.components.l2.private: must be true or false, not 1",
        "run.yaml:22:17: machine.components.foo.kind: must be a known kind, not 'cashe'; did you mean 'cache'?",
        "run.yaml:23:10: machine.components.bar: must be a mapping of keys, not 5",
        "run.yaml:24:5: missing key 'machine.components.baz.kind'",
        "run.yaml:25:5: machine.components.b.c: must be a name of letters a to z, digits, '_' and '-', not 'b.c'",
        "run.yaml:26:29: machine.components.dram.timing.n_refi: must be at least 4 (n_rfc + n_rc), 92, "
        "or 0 for no refresh",
        "run.yaml:26:38: machine.components.dram.timing.n_rc: must be at least n_ras + n_rp, 14",
        "run.yaml:26:53: machine.components.dram.scheduler: must be fcfs or fr_fcfs, not 'fifo'",
    ]


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("scene.lights.0.positon=[1,2,3]", "unknown key 'scene.lights.0.positon'; did you mean 'position'?"),
        ("scene.lights=5", "scene.lights: must be a list, not 5"),
        ("scene.lights=[5]", "scene.lights.0: must be a mapping of keys, not 5"),
        ("scene.mesh=5", "scene.mesh: must be text, not 5"),
        ("scene.camera.near=true", "scene.camera.near: must be a number, not true"),
        ("scene.camera.near=0", "scene.camera.near: must be above 0, not 0"),
        ("scene.camera.eye=[1,2,3,4]", "scene.camera.eye: must have at most 3 in it, not 4"),
        ("scene.camera.eye=[1,2,1e300]", "scene.camera.eye.2: must be at most 1e+09, not 1e+300"),
        ("machine=5", "machine: must be a mapping of keys, not 5"),
        ("machine.components=[]", "machine.components: must be a mapping of keys, not a list"),
        ("machine.clocks={}", "machine.clocks: must have at least 1 in it, not 0"),
        (
            "machine.components.dram.kind=[dram]",
            "machine.components.dram.kind: must be a known kind, not a list",
        ),
        ("<x>=1", "unknown key '<x>'"),
        ("[key]=1", "unknown key '[key]'"),
        ("{a}=1", "unknown key '{a}'"),
        (
            "scene.name='a/b'",
            "scene.name: must be a name of letters a to z, digits, spaces and any of _ . + -, not 'a/b'",
        ),
        ("name=null", "name: must be text, not null"),
        ("workload.kind=ibz", "workload.kind: must be a known kind, not 'ibz'; did you mean 'izb'?"),
        (
            "machine.components.<FifoConfig>=3",
            "machine.components.<FifoConfig>: must be a mapping of keys, not 3",
        ),
    ],
)
def test_one_wrong_value_is_told_in_plain_words(problems, override, message):
    found = problems(load_run, "runs/tiny.yaml", [override])
    assert any(line.startswith(f"--set {override}: {message}") for line in found), found


def test_missing_keys_are_said_at_the_mapping(write, problems):
    write(
        "run.yaml", "base: runs/tiny.yaml\nscene:\n  base: scenes/tiny.yaml\n  camera: {base: camera.yaml}\n"
    )
    write("camera.yaml", "eye: [1, 2, 3]\n")
    assert problems(load_run, "run.yaml") == [
        f"run.yaml:4:3: missing key 'scene.camera.{key}'" for key in ("target", "up", "fovy_degrees", "near")
    ]


def test_a_file_that_is_no_mapping(write, problems):
    write("run.yaml", "[1, 2]")
    assert problems(load_run, "run.yaml") == ["run.yaml:1:1: the file: must be a mapping of keys, not a list"]


_KEYS = [
    "scene",
    "mesh",
    "camera",
    "eye",
    "lights",
    "0",
    "view",
    "machine",
    "components",
    "l2",
    "dram",
    "kind",
]
_KEYS += ["timing", "clocks", "roles", "workload", "light", "<CacheConfig>", "[key]", "parameters", "seed"]
_LEAVES = (
    st.none() | st.booleans() | st.integers() | st.floats() | st.sampled_from([*_KEYS, "cache", "", "16 KiB"])
)
_VALUES = st.recursive(
    _LEAVES,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(_KEYS), inner, max_size=3),
)


@settings(max_examples=200, deadline=None)
@given(st.lists(st.sampled_from(_KEYS), min_size=1, max_size=5), _VALUES)
def test_nonsense_is_always_an_error_with_a_place(keys, value):
    text = dump({"value": value}).removeprefix("value:").strip()
    override = f"{'.'.join(keys)}={text or 'null'}"
    try:
        load_run("runs/tiny.yaml", [override])
        problems = []
    except ArchsimError as error:
        problems = error.problems
    assert all(problem.where is not None for problem in problems)
