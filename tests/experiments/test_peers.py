"""What is handed to the peers, and what is read of theirs; no peer is needed."""

import importlib
import sys
from configparser import ConfigParser

import numpy as np
import pytest

from archsim import resources
from archsim.config import load_machine
from archsim.machine.build import group_machine
from archsim.model.cache.spec import Replacement
from archsim.model.dram.commands import Command
from archsim.model.dram.reference import bank_of, column_of, field
from archsim.trace.accesses import Kind

FOLDER = resources.experiment("peers")


@pytest.fixture(scope="module")
def scripts():
    """The experiment's modules by name."""
    sys.path.insert(0, str(FOLDER))
    try:
        yield {name: importlib.import_module(name) for name in ("traces", "caches", "dramsim3", "dram")}
    finally:
        sys.path.remove(str(FOLDER))


@pytest.fixture(params=["ddr3_1600", "ddr4_2400", "ddr4_3200"])
def spec(scripts, request):
    return scripts["dram"].memory(request.param, []).part.spec


def sections(scripts, spec):
    config = ConfigParser()
    config.read_string(scripts["dramsim3"].configuration(spec, scripts["dramsim3"].Policy()))
    return config


def test_a_configuration_says_the_same_address_map(scripts, spec):
    config = sections(scripts, spec)
    structure, mapping = config["dram_structure"], config["system"]["address_mapping"]
    bits = {
        "ch": 0,
        "ra": 0,
        "bg": int(structure["bankgroups"]).bit_length() - 1,
        "ba": int(structure["banks_per_group"]).bit_length() - 1,
        "ro": int(structure["rows"]).bit_length() - 1,
        "co": (int(structure["columns"]) // int(structure["BL"])).bit_length() - 1,
    }

    def decoded(address):
        rest, found = address >> 6, {}
        for place in range(10, -1, -2):
            name = mapping[place : place + 2]
            found[name] = rest & ((1 << bits[name]) - 1)
            rest >>= bits[name]
        return found

    assert int(config["system"]["channel_size"]) << 20 == 64 << sum(bits.values())
    for address in np.random.default_rng(1).integers(0, 1 << 32, 50).tolist():
        theirs = decoded(address)
        assert theirs["ba"] * spec.num_groups + theirs["bg"] == bank_of(spec, address)
        assert theirs["ro"] == field(address, spec.row)
        assert theirs["co"] == column_of(spec, address)


def test_a_configuration_says_the_same_timing(scripts, spec):
    timing = {name: int(value) for name, value in sections(scripts, spec)["timing"].items()}

    assert timing["tras"] + timing["trp"] == spec.timing.n_rc
    assert timing["cl"] + spec.burst_clocks - timing["cwl"] + timing["trtrs"] == spec.timing.n_rtw
    assert (timing["tccd_s"], timing["tccd_l"]) == (spec.timing.n_ccd, spec.timing.n_ccd_l)
    assert (timing["trfc"], timing["trefi"]) == (spec.timing.n_rfc, spec.timing.n_refi)


def test_a_configuration_of_what_the_peer_cannot_say_is_refused(scripts, spec):
    with pytest.raises(ValueError, match="no hash of banks"):
        scripts["dramsim3"].configuration(spec._replace(bank_hash=2), scripts["dramsim3"].Policy())


def test_a_trace_ends_with_a_request_that_is_never_made(scripts):
    made = scripts["traces"].requests(np.array([64, 130]), np.array([False, True]), 7)

    lines = scripts["dramsim3"].trace_text(made).splitlines()

    assert lines[:2] == ["0x40 READ 0", "0x80 WRITE 7"]
    assert int(lines[2].split()[2]) > 10**9


def test_requests_of_one_line_and_of_one_clock_are_told_apart(scripts):
    traces = scripts["traces"]
    made = traces.requests(np.array([128, 128, 192, 0]))
    made["cycle"] = [3, 3, 3, 9]

    assert traces.unmerged(made)["address"].tolist() == [128, 129, 194, 3]
    assert traces.one_a_clock(made)["cycle"].tolist() == [3, 4, 5, 9]


def test_commands_are_read(scripts):
    spec = scripts["dram"].memory("ddr4_2400", []).part.spec
    text = (
        "2    activate     0   0   3   1    0x200      0x0\n"
        "18   read         0   0   3   1    0x200      0x5\n"
        "40   precharge   -1   0   3   1     -0x1     -0x1\n"
        "60   refresh     -1   0  -1  -1     -0x1     -0x1\n"
    )

    found = scripts["dramsim3"].commands_of(text, spec)

    kept = found[["clock", "command", "bank", "row", "column", "bursts"]].tolist()
    assert kept == [
        (2, Command.ACT, 7, 0x200, 0, 0),
        (18, Command.RD, 7, 0x200, 5, 1),
        (40, Command.PRE, 7, 0, 0, 0),
        (60, Command.REF, 0, 0, 0, 0),
    ]


def test_requests_are_tallied(scripts, tmp_path):
    chosen = scripts["dram"].memory("ddr4_2400", [])
    made = scripts["traces"].requests(np.array([0, 256, 1 << 17]), np.array([False, True, False]))

    found = scripts["dram"].ours(chosen, made, tmp_path)

    assert (found.reads, found.writes, found.row_hits, found.broken_rules) == (2, 1, 1, 0)
    assert (found.activates, found.precharged) == (2, 1)


def test_every_cache_is_the_one_that_was_meant(scripts):
    caches = scripts["caches"]
    for levels in caches.chains():
        machine = group_machine(load_machine("machines/tiny.yaml", caches.overrides(levels)), "builder")
        for spec, level in zip(machine.spec.caches[-len(levels) :], levels, strict=True):
            assert (spec.num_sets, spec.num_ways, spec.line_bytes) == level[:3]
            assert Replacement(spec.replacement).name == level.policy.upper()


def test_caches_count_what_the_peer_counts(scripts):
    level = scripts["caches"].Level(1, 1, 32, "lru")
    made = scripts["traces"].accesses(np.array([0, 4, 64]), 4, np.array([True, False, False]))

    found = scripts["caches"].ours((level,), made)

    assert found == ([(1, 2, 1)], 2)


def test_a_store_that_allocates_is_a_load_and_a_store(scripts):
    caches = scripts["caches"]
    level = caches.Level(1, 1, 32, "lru")

    assert caches._operation(8, Kind.WRITE, level) == ((8,), (8,))
    assert caches._operation(8, Kind.WRITE, level._replace(is_through=True)) == (None, (8,))
    assert caches._operation(8, Kind.READ, level) == ((8,), None)
