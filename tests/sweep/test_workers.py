"""Processes that do jobs: results come back, a dead process costs one job, a cluster gives the same."""

import os
import signal
import time

import pytest

from archsim.errors import ArchsimError
from archsim.sweep.job import Done, RenderJob
from archsim.sweep.workers import DaskWorkers, LocalWorkers
from tests.sweep.test_conduct import conducted


def answer(job):
    """What a job says: seconds to sleep, `die`, or an error."""
    if job == "die":
        os.kill(os.getpid(), signal.SIGKILL)
    time.sleep(job if isinstance(job, float) else 0)
    return Done(float(os.getpid()), str(job))


def taken(workers, number):
    found = {}
    while len(found) < number:
        found.update(workers.take(10))
    return found


@pytest.fixture
def workers():
    workers = LocalWorkers(2, answer, is_cold=False)
    yield workers
    workers.close()


def test_processes_stay_and_are_used_again(workers):
    workers.hand(1, "a")
    workers.hand(2, "b")
    first = taken(workers, 2)
    workers.hand(3, "c")
    second = taken(workers, 1)

    assert {token: done.error for token, done in first.items()} == {1: "a", 2: "b"}
    assert second[3].seconds in {done.seconds for done in first.values()}


def test_a_process_that_dies_costs_its_job_only(workers):
    workers.hand(1, "die")
    workers.hand(2, 0.3)

    found = taken(workers, 2)

    assert found[1].error == "the process that did it ended early, with exit code -9"
    assert found[2].error == "0.3"
    workers.hand(3, "again")
    assert taken(workers, 1)[3].error == "again"


def test_waiting_ends_when_nothing_comes(workers):
    workers.hand(1, 5.0)
    started = time.monotonic()

    assert workers.take(0.05) == []
    assert time.monotonic() - started < 4


def test_a_dask_cluster_does_a_sweep(tmp_path):
    from distributed import LocalCluster

    with LocalCluster(
        n_workers=1, threads_per_worker=2, processes=False, dashboard_address=None, protocol="inproc://"
    ) as cluster:
        workers = DaskWorkers(cluster.scheduler_address)
        assert workers.capacity == 2
        tally, _, watch, _ = conducted(tmp_path, workers)

    assert (tally.finished, tally.failed, watch.errors) == (4, 0, [])


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "nonsense://nowhere"])
def test_a_scheduler_that_is_not_there_is_named(address):
    from dask import config

    with (
        config.set({"distributed.comm.timeouts.connect": "1s"}),
        pytest.raises(ArchsimError, match=f"no Dask scheduler at '{address}'"),
    ):
        DaskWorkers(address)


def test_one_process_compiles_before_the_others_begin(tmp_path):
    workers = LocalWorkers(2, answer, is_cold=True)
    try:
        assert workers.capacity == 1
        workers.hand(1, RenderJob(None, tmp_path))
        taken(workers, 1)
        assert workers.capacity == 1  # a picture was rendered, no point was played yet
        workers.hand(2, "a")
        taken(workers, 1)
        assert workers.capacity == 2
    finally:
        workers.close()
