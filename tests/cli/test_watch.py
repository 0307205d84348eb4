"""The live table of a sweep under way."""

import io

from rich.console import Console

from archsim.cli.watch import LiveTable
from archsim.sweep.job import Done


def shown(table):
    console = Console(width=100, record=True, file=io.StringIO())
    console.print(table.picture())
    return console.export_text()


def test_it_shows_what_runs_what_failed_and_what_is_left():
    with LiveTable(Console(file=io.StringIO())) as table:
        table.begin(10, 4)
        table.started(1, "archsim run a")
        table.started(2, "archsim run b")
        table.started(3, "rendering for 3 points")
        table.started(4, "archsim run c" + 60 * " --set" + " last=1")
        table.ended(1, "archsim run a", Done(1.0))
        table.ended(2, "archsim run b", Done(1.0, "Traceback\nno memory"))

        text = shown(table)

    assert "rendering for 3 points" in text
    assert " 6 of 10 points, 1 failed, about" in text
    assert "last=1" in text  # in what a point differs comes last
    assert "no memory  [archsim run b]" in text
