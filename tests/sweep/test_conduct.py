"""Every point once, every picture once, failures kept, nothing half done left behind."""

import json
from pathlib import Path

import pytest

from archsim.config import load_run
from archsim.errors import ArchsimError
from archsim.run import simulate
from archsim.run.folder import result_json
from archsim.sweep.job import Done, PointJob, RenderJob, perform
from archsim.sweep.plan import make_plan
from archsim.sweep.start import run_sweep
from archsim.sweep.store import check_folder, is_finished, only_one, read_failure, read_index
from archsim.sweep.watch import SilentWatch
from tests.sweep.small import InlineWorkers, loaded_sweep


def conducted(folder, workers=None, part="1of1", **changes):
    """Tally, workers, watch and points of a sweep done in a folder."""
    loaded, run = loaded_sweep(**changes), "runs/tiny.yaml"
    points = make_plan(loaded.config, run)
    workers, watch = workers or InlineWorkers(), SilentWatch()
    return run_sweep(loaded, run, (points, points), folder, (workers, part, watch)), workers, watch, points


def test_points_have_the_results_of_their_runs_and_pictures_are_rendered_once(tmp_path):
    tally, workers, watch, points = conducted(tmp_path)

    assert (tally.finished, tally.failed, tally.found) == (4, 0, 0)
    assert workers.num_rendered == 2
    assert workers.closed
    assert (watch.points, watch.errors) == (4, [])
    for point in points:
        stored = (tmp_path / "points" / point.digest / "result.json").read_text()
        assert stored == result_json(simulate(point.config))
    assert list((tmp_path / "work").iterdir()) == []


def test_what_is_finished_is_never_repeated(tmp_path):
    conducted(tmp_path)

    tally, workers, _, _ = conducted(tmp_path)
    assert (tally, workers.jobs) == ((0, 0, 4), [])

    more = [
        {"grid": {"machine.components.l2.size": ["1 KiB", "2 KiB", "4 KiB"]}},
        {"zip": {"workload.depth_offset_cells": [0.015625, 0.03125], "seed": [1, 2]}},
    ]
    tally, workers, _, _ = conducted(tmp_path, parameters=more)
    assert (tally.finished, tally.found) == (2, 4)
    assert workers.num_rendered == 0  # one point a picture: it renders for itself


def test_failures_are_kept_with_their_command_and_the_rest_goes_on(tmp_path):
    parameters = [
        {
            "grid": {
                "machine.components.l2.size": ["1 KiB", "3000 B"],
                "machine.components.locks.count": [64, 256],
            }
        }
    ]

    tally, _, watch, points = conducted(tmp_path, parameters=parameters)

    assert (tally.finished, tally.failed) == (1, 3)
    assert len(watch.errors) == 3
    assert "must be sets x ways x line" in read_failure(tmp_path, points[2].digest)
    assert "the kernels use 256 locks" in read_failure(tmp_path, points[0].digest)
    kept = json.loads((tmp_path / "failed" / f"{points[0].digest}.json").read_text())
    assert kept["command"] == (
        "archsim run runs/tiny.yaml --set 'scene.resolution=[16, 12]' "
        "--set 'machine.components.l2.size=1 KiB' --set machine.components.locks.count=64"
    )


def test_a_failure_is_tried_again_and_forgotten_when_it_is_over(tmp_path):
    def broken(job):
        return Done(0.1, "no memory left") if isinstance(job, PointJob) else perform(job)

    tally, _, _, points = conducted(tmp_path, InlineWorkers(do=broken))
    assert tally.failed == 4
    assert read_failure(tmp_path, points[0].digest) == "no memory left"

    tally, _, _, points = conducted(tmp_path)
    assert (tally.finished, tally.failed) == (4, 0)
    assert read_failure(tmp_path, points[0].digest) is None


def test_a_picture_that_cannot_be_rendered_fails_its_points_only(tmp_path):
    first = []

    def broken(job):
        first.extend([job] if isinstance(job, RenderJob) and not first else [])
        return Done(0.1, "no memory left") if job in first else perform(job)

    tally, _, _, _ = conducted(tmp_path, InlineWorkers(do=broken))

    assert (tally.finished, tally.failed) == (2, 2)


def test_an_error_that_nobody_foresaw_is_a_failure_with_its_place(monkeypatch):
    monkeypatch.setattr("archsim.sweep.job.kind_of", lambda config: 1 // 0)
    config = load_run("runs/tiny.yaml")

    done = perform(PointJob(Path("nowhere"), "d", config, "c", None))

    assert "ZeroDivisionError" in done.error
    assert "test_conduct.py" in done.error


def test_a_broken_law_is_a_failure(tmp_path, monkeypatch):
    from archsim.run.result import Check
    from tests.run.results import make_result

    class Broken:
        @staticmethod
        def simulate(config):
            return make_result(checks=[Check("books balance", False, "1 = 2")])

    monkeypatch.setattr("archsim.sweep.job.kind_of", lambda config: Broken)

    done = perform(PointJob(tmp_path, "d", load_run("runs/tiny.yaml"), "c", None))

    assert done.error == "check failed: books balance: 1 = 2"
    assert not is_finished(tmp_path, "d")


def test_two_processes_do_not_work_on_one_share(tmp_path):
    with only_one(tmp_path, "1of2"):
        with pytest.raises(ArchsimError, match="another process is working on this sweep"):
            conducted(tmp_path, part="1of2")
        conducted(tmp_path, part="2of2")


def test_leftovers_of_a_killed_process_are_swept_out(tmp_path):
    _, _, _, points = conducted(tmp_path)
    digest = points[0].digest
    (tmp_path / "points" / digest).rename(tmp_path / "points" / f".{digest}-unfinished-abc")
    (tmp_path / "work" / "1of1" / "half").mkdir(parents=True)

    tally, _, _, _ = conducted(tmp_path)

    assert tally.finished == 1
    assert {path.name for path in (tmp_path / "points").iterdir()} == {point.digest for point in points}
    assert list((tmp_path / "work").iterdir()) == []


def test_the_index_lists_all_points_in_order(tmp_path):
    _, _, _, points = conducted(tmp_path)

    index = read_index(tmp_path)

    assert index.name == "small"
    assert [entry.digest for entry in index.points] == [point.digest for point in points]
    assert index.points[0].parameters["seed"] == 1
    with pytest.raises(ArchsimError, match="is not a sweep"):
        read_index(tmp_path / "points")
    (tmp_path / "sweep.json").write_text("{}")
    with pytest.raises(ArchsimError, match="is broken"):
        read_index(tmp_path)


def test_a_point_that_is_written_in_two_ways_is_done_once(tmp_path):
    sizes = [{"grid": {"machine.components.l2.size": ["1 KiB", "1024 B", "2 KiB"]}}]

    tally, workers, watch, points = conducted(tmp_path, parameters=sizes)

    assert len(points) == 3
    assert (tally.finished, watch.points) == (2, 2)
    assert sum(isinstance(job, PointJob) for job in workers.jobs) == 2


def test_a_sweep_that_was_just_begun_can_be_begun_again(tmp_path):
    """Another shard has made its lock, or a process was killed before it wrote the index."""
    (tmp_path / ".1of2.lock").touch()
    (tmp_path / "run.yaml").touch()
    check_folder(tmp_path)

    (tmp_path / "thesis.tex").touch()
    with pytest.raises(ArchsimError, match="something else than a sweep"):
        check_folder(tmp_path)
