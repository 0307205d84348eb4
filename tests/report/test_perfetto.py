"""The trace is what Perfetto reads: known phases, slices that nest, requests that begin and end."""

import json
from collections import Counter, defaultdict

from archsim.machine.timeline import Window, record
from archsim.report.perfetto import Labels, perfetto
from archsim.report.waterfall import waterfall_figure
from tests.machine.build import work
from tests.machine.test_timeline import tiny
from tests.model.unit.test_unit import fed
from tests.report.pages import check_self_contained


def events():
    spec, fresh = tiny("izb_build")
    return json.loads(perfetto(record(spec, fresh()), Labels(["l1", "l2"], 10**9)))["traceEvents"]


def test_slices_of_a_track_nest():
    tracks = defaultdict(list)
    for event in events():
        if event["ph"] == "X" and event["pid"] < 1000:
            tracks[event["pid"], event["tid"]].append((event["ts"], -event["dur"]))
    assert tracks
    for spans in tracks.values():
        open_ends = []
        for start, duration in sorted(spans):
            end = start - duration
            while open_ends and open_ends[-1] <= start + 1e-9:
                open_ends.pop()
            assert not open_ends or end <= open_ends[-1] + 1e-9
            open_ends.append(end)


def test_every_request_that_begins_ends():
    begun, ended = {}, {}
    for event in events():
        if event["ph"] in "be":
            (begun if event["ph"] == "b" else ended)[event["id"]] = event["ts"]

    assert begun.keys() == ended.keys()
    assert begun
    assert all(ended[number] > start for number, start in begun.items())


def test_all_tracks_have_names_and_times_are_microseconds():
    found = events()
    named = {event["pid"] for event in found if event["ph"] == "M"}

    assert {event["pid"] for event in found} == named
    assert set(Counter(event["ph"] for event in found)) == {"M", "X", "b", "e", "C"}
    assert min(event["dur"] for event in found if event["ph"] == "X") == 0.001  # a cycle of 1 GHz


def test_the_fifo_before_the_cores_is_a_counter():
    timeline = record(fed(1), work([5], [5], [5]))
    trace = json.loads(perfetto(timeline, Labels(["l1"], 10**9, channels=("fragments",))))["traceEvents"]

    held = [(event["ts"], event["args"]["held"]) for event in trace if event["name"] == "fragments"]
    assert held[:4] == [(0.0, 1), (0.0, 0), (0.001, 1), (0.002, 2)]
    assert "fifo (tasks)" in {event["args"].get("name") for event in trace if event["ph"] == "M"}


def test_the_waterfall_is_a_figure():
    spec, fresh = tiny("izb_build")

    page = check_self_contained(waterfall_figure(record(spec, fresh()), Window(0, 60)))

    assert "waits for the DRAM" in page.text
