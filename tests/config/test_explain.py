"""A key explained: value, unit, range, default, and the place that set it."""

from pathlib import Path

import pytest

from archsim.config import load_run_with_origins
from archsim.config.explain import explain, origins
from archsim.errors import ArchsimError


def explained(path, *overrides):
    return explain(load_run_with_origins("runs/tiny.yaml", overrides), path)


def test_a_value_from_a_file():
    found = explained("machine.components.l2.size")

    assert (found.value, found.unit) == ("1 KiB", "B")
    assert found.accepted == "a quantity such as 16 KiB from 1 to 1,099,511,627,776"
    assert found.default == "none: it must be given"
    assert found.where.file.endswith("configs/machines/tiny.yaml")
    lines = Path(found.where.file).read_text().splitlines()
    assert lines[found.where.line - 1].strip() == "size: 1 KiB"


def test_a_value_from_the_command_line_and_a_default():
    assert explained("seed", "seed=7").where.file == "--set seed=7"
    assert explained("seed").where is None
    assert (explained("seed").value, explained("seed").default) == ("0", "0")


@pytest.mark.parametrize(
    ("path", "value", "accepted"),
    [
        ("model", "compiled", "reference or compiled"),
        ("scene.resolution", "[64, 48]", "a list of 2, each a whole number from 1 to 8,192"),
        ("scene.resolution.1", "48", "a whole number from 1 to 8,192"),
        ("machine.clocks.core", "1 GHz", "a quantity such as 1.2 GHz"),
        ("machine.components.l2.private", "false", "true or false"),
        ("scene.camera.near", "0.1", "a number above 0 to 1e+09"),
        ("machine.components.shader.locks", "null", "text or null"),
    ],
)
def test_what_is_accepted(path, value, accepted):
    found = explained(path)
    assert (found.value, found.accepted) == (value, accepted)
    assert found.meaning


def test_a_mapping_lists_its_keys():
    assert explained("machine.roles").value == "izb_build, izb_raster, hsv_stages"


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("machine.components.l2.siez", "no key 'siez' in 'machine.components.l2'; did you mean 'size'"),
        ("mashine", "no key 'mashine'; did you mean 'machine'"),
        ("seed.more", "no key 'more' in 'seed'; it holds no keys"),
        ("scene.lights.1", "no key '1' in 'scene.lights'; there are: 0"),
        ("", "no key ''"),
    ],
)
def test_what_is_not_there_is_named(path, message):
    with pytest.raises(ArchsimError) as error:
        explained(path)
    assert message in str(error.value)


def test_every_value_has_its_origin():
    found = {
        key: (value, place)
        for key, value, place in origins(load_run_with_origins("runs/tiny.yaml", ["seed=7"]))
    }

    assert found["seed"] == ("7", "--set seed=7")
    assert found["workload.depth_offset_cells"] == ("0.015625", "the default")
    assert found["scene.resolution"][0] == "[64, 48]"
    assert "configs/machines/tiny.yaml:" in found["machine.components.l2.size"][1]
