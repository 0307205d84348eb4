"""Every rule of the data sheet is known to the referee: one clock too early breaks it, in time it does not."""

import pytest

from archsim.config import load_machine
from archsim.config.dram import DramConfig
from archsim.trace.referee.commands import Issued
from archsim.trace.referee.rules import violations

TIMING = {
    "n_cl": 11,
    "n_wl": 5,
    "n_rcd_read": 13,
    "n_rcd_write": 7,
    "n_rp": 17,
    "n_ras": 19,
    "n_rc": 47,
    "n_rrd": 3,
    "n_rrd_l": 6,
    "n_faw": 20,
    "n_ccd": 5,
    "n_ccd_l": 9,
    "n_rtp": 8,
    "n_wr": 31,
    "n_wtr": 21,
    "n_wtr_l": 37,
    "n_rtw": 14,
    "n_rfc": 53,
    "n_refi": 400,
}
BURST = 4  # clocks of data


@pytest.fixture(scope="module")
def dram():
    """Two channels of eight banks in two groups."""
    sizes = "banks: 8, bank_groups: 2, channels: 2, address_map: row:bank:group:line:channel:offset"
    timing = ", ".join(f"{name}: {value}" for name, value in TIMING.items())
    machine = load_machine(
        "machines/tiny.yaml",
        [
            *(f"components.dram.{pair.replace(': ', '=')}" for pair in sizes.split(", ")),
            f"components.dram.timing={{{timing}}}",
        ],
    )
    return machine.find("dram", DramConfig)


def commands(text):
    """`10 ACT 3 7` is an ACT of bank 3, row 7 in clock 10 of channel 0; lines count from 2."""
    for number, line in enumerate(text.strip().splitlines(), start=2):
        clock, command, *place = line.split()
        yield Issued(number, int(clock), 0, command, *(int(p) for p in place), *[-1] * (3 - len(place)))


def broken(dram, text):
    return [(violation.line, violation.rule) for violation in violations(dram, commands(text))]


# (rule, commands before, the command judged without its clock, the first clock allowed)
RULES = [
    ("n_rcd_read", "0 ACT 0 5", "RD 0 5 0", 13),
    ("n_rcd_write", "0 ACT 0 5", "WR 0 5 0", 7),
    ("n_ras", "0 ACT 0 5", "PRE 0", 19),
    ("n_ras", "0 ACT 0 5", "PREA", 19),
    ("n_rp", "0 ACT 0 5\n60 PRE 0", "ACT 0 6", 77),
    ("n_rp", "0 ACT 0 5\n60 PREA", "REF", 77),
    ("n_rc", "0 ACT 0 5\n19 PRE 0", "ACT 0 6", 47),
    ("n_rc", "0 ACT 0 5\n19 PRE 0", "REF", 47),
    ("n_rrd", "0 ACT 0 5", "ACT 1 5", 3),
    ("n_rrd_l", "0 ACT 0 5", "ACT 2 5", 6),
    ("n_faw", "0 ACT 0 5\n3 ACT 1 5\n6 ACT 2 5\n9 ACT 3 5", "ACT 4 5", 20),
    ("n_rfc", "0 REF", "ACT 0 5", 53),
    ("n_rfc", "0 REF", "REF", 53),
    ("n_ccd", "0 ACT 0 5\n3 ACT 1 5\n30 RD 0 5 0", "RD 1 5 0", 35),
    ("n_ccd", "0 ACT 0 5\n3 ACT 1 5\n30 WR 0 5 0", "WR 1 5 0", 35),
    ("n_ccd_l", "0 ACT 0 5\n6 ACT 2 5\n30 RD 0 5 0", "RD 2 5 0", 39),
    ("n_ccd_l", "0 ACT 0 5\n6 ACT 2 5\n30 WR 0 5 0", "WR 2 5 0", 39),
    ("n_rtp", "0 ACT 0 5\n30 RD 0 5 0", "PRE 0", 38),
    ("n_wr", "0 ACT 0 5\n30 WR 0 5 0", "PRE 0", 30 + 5 + BURST + 31),
    ("n_wr", "0 ACT 0 5\n30 WR 0 5 0", "PREA", 30 + 5 + BURST + 31),
    ("n_wtr", "0 ACT 0 5\n3 ACT 1 5\n30 WR 0 5 0", "RD 1 5 0", 30 + 5 + BURST + 21),
    ("n_wtr_l", "0 ACT 0 5\n30 WR 0 5 0", "RD 0 5 8", 30 + 5 + BURST + 37),
    ("n_rtw", "0 ACT 0 5\n30 RD 0 5 0", "WR 0 5 0", 44),
    ("command bus", "30 ACT 0 5", "ACT 1 5", 31),
]


@pytest.mark.parametrize(("rule", "before", "command", "first"), RULES, ids=[f"{r[0]}-{r[2]}" for r in RULES])
def test_one_clock_too_early_breaks_the_rule(dram, rule, before, command, first):
    last = 2 + len(before.splitlines())
    in_time = broken(dram, f"{before}\n{first} {command}")
    early = broken(dram, f"{before}\n{first - 1} {command}")

    assert (last, rule) not in in_time
    assert (last, rule) in early
    assert {line for line, _ in early} == {last}


ALONE = [case for case in RULES if case[0] != "command bus"]


@pytest.mark.parametrize(("rule", "before", "command", "first"), ALONE, ids=[f"{r[0]}-{r[2]}" for r in ALONE])
def test_it_breaks_that_rule_only(dram, rule, before, command, first):
    assert broken(dram, f"{before}\n{first} {command}") == []
    assert broken(dram, f"{before}\n{first - 1} {command}") == [(2 + len(before.splitlines()), rule)]


@pytest.mark.parametrize(
    ("rule", "text"),
    [
        ("bank open", "0 ACT 0 5\n60 ACT 0 6"),
        ("bank open", "0 ACT 0 5\n60 REF"),
        ("bank closed", "0 RD 0 5 0"),
        ("bank closed", "0 ACT 0 5\n60 PRE 0\n80 WR 0 5 0"),
        ("row", "0 ACT 0 5\n60 RD 0 6 0"),
        ("range", "0 ACT 8 5"),
        ("range", "0 ACT 0 4096"),
        ("range", "0 ACT 0 5\n60 RD 0 5 256"),
        ("n_refi", "3600 ACT 0 5"),  # nine are due
        ("n_refi", "\n".join(f"{60 * i} REF" for i in range(10))),  # the tenth comes in 540, when one is due
    ],
)
def test_what_a_bank_may_not_be_told(dram, rule, text):
    found = broken(dram, text)

    assert rule in [each for _, each in found], found
    assert found[0][0] == 1 + len(text.splitlines())


def test_the_data_bus_carries_one_burst_at_a_time(dram):
    """n_rtw alone would allow it: data of the WR would start in 36 while that of the RD lasts until 45."""
    short = dram.model_copy(update={"timing": dram.timing.model_copy(update={"n_rtw": 1})})

    assert broken(short, "0 ACT 0 5\n3 ACT 1 5\n30 RD 0 5 0\n39 WR 1 5 0") == [(5, "data bus")]
    assert broken(short, "0 ACT 0 5\n3 ACT 1 5\n30 RD 0 5 0\n40 WR 1 5 0") == []


def test_channels_have_nothing_to_do_with_each_other(dram):
    first = Issued(2, 10, 0, "ACT", 0, 5, -1)
    assert list(violations(dram, [first, first._replace(channel=1)])) == []
    assert [v.rule for v in violations(dram, [first._replace(channel=2)])] == ["range"]


def test_eight_refreshes_may_be_postponed(dram):
    assert broken(dram, "3599 ACT 0 5") == []


def test_a_closed_bank_may_be_closed_again(dram):
    assert broken(dram, "0 PRE 0\n1 PREA\n2 PRE 0") == []


def test_without_refresh_none_is_missed(dram):
    never = dram.model_copy(update={"timing": dram.timing.model_copy(update={"n_refi": 0})})
    assert broken(never, "1000000 ACT 0 5\n1000060 PREA\n1000100 REF") == []
