"""What identifies a point, and how points are dealt to shards."""

import pytest

from archsim import resources
from archsim.config import load_sweep
from archsim.errors import ArchsimError
from archsim.sweep.plan import make_plan, shard
from tests.sweep.small import sweep


def plan(**changes):
    return make_plan(sweep(**changes), "runs/tiny.yaml")


def grid(**values):
    return {"parameters": [{"grid": values}]}


def test_a_point_is_called_by_all_that_its_result_depends_on():
    points = plan(
        parameters=[
            {
                "list": [
                    {"seed": 1},
                    {"seed": 2},
                    {"machine.components.l2.ways": 4},
                    {"scene.camera.fovy_degrees": 50.0},
                    {"model": "reference"},
                ]
            }
        ]
    )

    assert len({point.digest for point in points}) == 5
    assert [point.digest for point in points] == [
        point.digest
        for point in plan(name="other", parameters=[{"list": [point.parameters for point in points]}], set={})
    ]


def test_points_of_one_picture_share_its_work():
    machine = plan(**grid(**{"machine.components.l2.ways": [1, 2], "model": ["reference", "compiled"]}))
    picture = plan(**grid(**{"scene.resolution": [[8, 6], [16, 12]], "workload.light": [0]}))

    assert len({point.functional_digest for point in machine}) == 1
    assert len({point.functional_digest for point in picture}) == 2


def test_work_that_is_dealt_to_threads_depends_on_their_number():
    def works(order):
        points = plan(
            set={"workload.tile_order": order}, **grid(**{"machine.components.builder.threads": [1, 2]})
        )
        return len({point.functional_digest for point in points})

    assert (works("block"), works("interleaved")) == (2, 1)


def test_what_is_no_run_carries_its_reason():
    good, bad = plan(**grid(**{"machine.components.l2.size": ["1 KiB", "3000 B"]}))

    assert (good.error, bad.config) == (None, None)
    assert "machine.components.l2.size" in bad.error
    assert good.digest != bad.digest


def test_a_run_that_is_not_there_ends_the_sweep_at_once():
    with pytest.raises(ArchsimError, match="did you mean"):
        make_plan(sweep(), "runs/tinny.yaml")


@pytest.mark.parametrize("count", [1, 2, 3, 5, 9])
def test_shards_are_a_partition_that_keeps_pictures_together(count):
    points = plan(**grid(**{"scene.resolution": [[8, 6], [16, 12]], "machine.components.l2.ways": [1, 2, 4]}))

    shards = [shard(points, index, count) for index in range(1, count + 1)]

    assert sorted(p.digest for part in shards for p in part) == sorted(p.digest for p in points)
    assert max(map(len, shards)) - min(map(len, shards)) <= 1
    if count == 2:
        assert all(len({point.functional_digest for point in part}) == 1 for part in shards)


@pytest.mark.parametrize(("index", "count"), [(0, 2), (3, 2), (1, 0)])
def test_there_is_no_such_shard(index, count):
    with pytest.raises(ArchsimError, match="I/N"):
        shard([], index, count)


@pytest.mark.parametrize(
    "path", sorted((resources.root() / "configs" / "sweeps").glob("*.yaml")), ids=lambda p: p.stem
)
def test_packaged_sweeps_have_only_points_that_are_runs(path):
    config = load_sweep(path)

    points = make_plan(config, config.run)

    assert [point.error for point in points if point.error] == []
    assert len({point.digest for point in points}) == len(points) > 1


def test_the_readmes_example_is_a_sweep(tmp_path):
    readme = (resources.root() / "archsim" / "sweep" / "README.md").read_text()
    (tmp_path / "example.yaml").write_text(readme.split("```yaml\n")[1].split("```")[0])

    points = make_plan(load_sweep(tmp_path / "example.yaml"), "runs/tiny.yaml")

    assert len(points) == (4 + 4 * 2) * 3
    assert [point.error for point in points if point.error] == []
