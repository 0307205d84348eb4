"""Jobs in processes of their own."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from archsim.errors import ArchsimError
from archsim.reproduce.processes import in_processes
from archsim.run.progress import silent
from tests.reproduce import jobs


def test_results_come_in_the_order_of_the_jobs_and_progress_is_told():
    told = []

    results = in_processes(jobs.double, [(3,), (1,), (2,)], 2, lambda *report: told.append(report))

    assert results == [6, 2, 4]
    assert sorted(told) == [(f"doubling {number}", 1, 1) for number in (1, 2, 3)]


def test_a_job_s_problems_arrive_whole():
    with pytest.raises(ArchsimError) as caught:
        in_processes(jobs.wrong, [("x",)], 1, silent)

    assert str(caught.value) == "x is wrong; try another"
    assert [problem.hint for problem in caught.value.problems] == ["try another"]


def test_a_dead_worker_is_noticed():
    with pytest.raises(RuntimeError, match="exit code 7"):
        in_processes(jobs.die, [()], 1, silent)


PARENT = """
import sys
from archsim.reproduce.processes import in_processes
from archsim.run.progress import silent
from tests.reproduce import jobs

if __name__ == "__main__":
    in_processes(jobs.sleep, [(sys.argv[1],)], 1, silent)
"""


@pytest.mark.parametrize("signal_number", [signal.SIGKILL, signal.SIGINT])
def test_workers_go_when_the_parent_goes(tmp_path, signal_number):
    script = tmp_path / "parent.py"
    script.write_text(PARENT)
    seen = tmp_path / "seen"
    seen.mkdir()
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    with subprocess.Popen(
        [sys.executable, str(script), str(seen)], stderr=subprocess.DEVNULL, env=environment
    ) as parent:
        wait_until(lambda: any(seen.iterdir()))
        worker = int(next(seen.iterdir()).name)
        os.kill(parent.pid, signal_number)
        parent.wait(10)

    wait_until(lambda: not is_running(worker))


def is_running(process_id: int) -> bool:
    try:
        return Path(f"/proc/{process_id}/stat").read_text().split(")")[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


def wait_until(condition, seconds=30):
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.05)
