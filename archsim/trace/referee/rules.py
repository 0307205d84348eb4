"""The referee: the rules of a DRAM's data sheet, one by one, for a stream of commands.

It knows the data sheet (the machine's timing and sizes) and nothing of the controller whose commands it judges. Every
rule looks back at the commands that matter to it.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from archsim.config.dram import DramConfig
from archsim.trace.referee.commands import Issued

MOST_POSTPONED = 8  # REF commands that may be late, or early (JESD79-4 sec. 4.26; JESD79-3 sec. 4.13)


class Violation(NamedTuple):
    """A command that broke a rule."""

    line: int
    rule: str
    what: str


def violations(dram: DramConfig, commands: Iterable[Issued]) -> Iterator[Violation]:
    """All violations in a stream of commands, in its order."""
    channels = [Channel(dram) for _ in range(dram.channels)]
    for command in commands:
        if command.channel >= dram.channels:
            yield Violation(command.line, "range", f"channel {command.channel} of {dram.channels}")
            continue
        yield from channels[command.channel].judge(command)


class Bank:
    """What a bank was told, and when; None: never."""

    def __init__(self) -> None:
        self.open_row: int | None = None
        self.act: int | None = None
        self.pre: int | None = None
        self.rd: int | None = None
        self.wr: int | None = None


class Channel:
    """What was told to a channel, and when."""

    def __init__(self, dram: DramConfig):
        self.dram, self.timing = dram, dram.timing
        self.banks = [Bank() for _ in range(dram.banks)]
        self.clock = -1
        self.acts: deque[tuple[int, int]] = deque(maxlen=max(4, dram.banks))  # (clock, bank), the newest last
        self.last_column: dict[str, tuple[int, int]] = {}  # (clock, bank) of the last RD and WR
        self.last_of_group: dict[tuple[str, int], int] = {}  # clock of the last ACT, RD and WR in a group
        self.last_ref: int | None = None
        self.refs = 0
        self.data_end = 0  # clock after the last data on the bus
        self.late_reported = 0
        self.found: list[Violation] = []

    def judge(self, command: Issued) -> list[Violation]:
        """The rules that this command breaks."""
        self.found = []
        if command.clock <= self.clock:
            self._break(command, "command bus", f"one command a clock; the last was in clock {self.clock}")
        self.clock = max(self.clock, command.clock)
        self._refresh_in_time(command)
        if self._is_in_range(command):
            handler = {
                "ACT": self._act,
                "PRE": self._pre,
                "PREA": self._prea,
                "RD": self._rd,
                "WR": self._wr,
                "REF": self._ref,
            }[command.command]
            handler(command)
        return self.found

    def _break(self, command: Issued, rule: str, what: str) -> None:
        place = f" of bank {command.bank}" if command.bank >= 0 else ""
        self.found.append(Violation(command.line, rule, f"{command.command}{place}: {what}"))

    def _apart(self, command: Issued, rule: str, since: int | None, least: int, after: str) -> None:
        """At least `least` clocks since an earlier event."""
        if since is not None and command.clock - since < least:
            what = f"{command.clock - since} clocks after {after} in clock {since}, at least {least} needed"
            self._break(command, rule, what)

    def _is_in_range(self, command: Issued) -> bool:
        dram = self.dram
        columns = dram.row_bytes // dram.channel_width
        limits = {"bank": dram.banks, "row": dram.rows, "column": columns}
        for name, limit in limits.items():
            if getattr(command, name) >= limit:
                self._break(command, "range", f"{name} {getattr(command, name)} of {limit}")
                return False
        return True

    def _group(self, bank: int) -> int:
        return bank % self.dram.bank_groups

    def _refresh_in_time(self, command: Issued) -> None:
        """On average one REF every n_refi; no more than eight may be postponed."""
        if self.timing.n_refi == 0:
            return
        late = command.clock // self.timing.n_refi - self.refs
        if late > max(MOST_POSTPONED, self.late_reported):
            self.late_reported = late
            self._break(
                command, "n_refi", f"{late} REF are due, no more than {MOST_POSTPONED} may be postponed"
            )

    def _act(self, command: Issued) -> None:
        timing, bank, clock = self.timing, self.banks[command.bank], command.clock
        if bank.open_row is not None:
            self._break(command, "bank open", f"row {bank.open_row} is open")
        self._apart(command, "n_rc", bank.act, timing.n_rc, "its ACT")
        self._apart(command, "n_rp", bank.pre, timing.n_rp, "its PRE")
        self._apart(command, "n_rfc", self.last_ref, timing.n_rfc, "REF")
        if self.acts:
            self._apart(command, "n_rrd", self.acts[-1][0], timing.n_rrd, f"ACT of bank {self.acts[-1][1]}")
        if timing.n_rrd_l is not None:
            since = self.last_of_group.get(("ACT", self._group(command.bank)))
            self._apart(command, "n_rrd_l", since, timing.n_rrd_l, "ACT in its group")
        if timing.n_faw is not None and len(self.acts) >= 4:
            self._apart(command, "n_faw", self.acts[-4][0], timing.n_faw, "the fourth ACT before")

        bank.open_row, bank.act = command.row, clock
        self.acts.append((clock, command.bank))
        self.last_of_group["ACT", self._group(command.bank)] = clock

    def _pre(self, command: Issued) -> None:
        self._close(command, self.banks[command.bank])

    def _prea(self, command: Issued) -> None:
        for number, bank in enumerate(self.banks):
            if bank.open_row is not None:
                self._close(command._replace(bank=number), bank)

    def _close(self, command: Issued, bank: Bank) -> None:
        """Data sheets allow the PRE of a closed bank; it does nothing."""
        if bank.open_row is None:
            return
        timing = self.timing
        self._apart(command, "n_ras", bank.act, timing.n_ras, "its ACT")
        self._apart(command, "n_rtp", bank.rd, timing.n_rtp, "its RD")
        self._apart(command, "n_wr", self._written(bank.wr), timing.n_wr, "its last data")

        bank.open_row, bank.pre = None, command.clock

    def _written(self, wr: int | None) -> int | None:
        """The clock after the data of a WR."""
        return None if wr is None else wr + self.timing.n_wl + self.dram.burst_clocks

    def _rd(self, command: Issued) -> None:
        timing, group = self.timing, self._group(command.bank)
        self._column(command, timing.n_rcd_read, "n_rcd_read")
        if "WR" in self.last_column:
            clock, bank = self.last_column["WR"]
            after = f"the data of WR of bank {bank}"
            self._apart(command, "n_wtr", self._written(clock), timing.n_wtr, after)
        if timing.n_wtr_l is not None:
            written = self._written(self.last_of_group.get(("WR", group)))
            self._apart(command, "n_wtr_l", written, timing.n_wtr_l, "the data of WR in its group")
        self._data(command, timing.n_cl)

        self.banks[command.bank].rd = command.clock

    def _wr(self, command: Issued) -> None:
        timing = self.timing
        self._column(command, timing.n_rcd_write, "n_rcd_write")
        if "RD" in self.last_column:
            clock, bank = self.last_column["RD"]
            self._apart(command, "n_rtw", clock, timing.n_rtw, f"RD of bank {bank}")
        self._data(command, timing.n_wl)

        self.banks[command.bank].wr = command.clock

    def _column(self, command: Issued, n_rcd: int, rule: str) -> None:
        """What RD and WR have in common: the open row, and the command before."""
        timing, bank, group = self.timing, self.banks[command.bank], self._group(command.bank)
        if bank.open_row is None:
            self._break(command, "bank closed", "no row is open")
        elif bank.open_row != command.row:
            self._break(command, "row", f"row {bank.open_row} is open, not {command.row}")
        self._apart(command, rule, bank.act, n_rcd, "its ACT")
        last = max(self.last_column.values(), default=None)
        if last is not None:
            self._apart(
                command, "n_ccd", last[0], timing.n_ccd, f"the last column command, of bank {last[1]}"
            )
        if timing.n_ccd_l is not None:
            for kind in ("RD", "WR"):
                since = self.last_of_group.get((kind, group))
                self._apart(command, "n_ccd_l", since, timing.n_ccd_l, f"{kind} in its group")

    def _data(self, command: Issued, latency: int) -> None:
        """The burst's data must find the bus free. Notes the command, too."""
        start = command.clock + latency
        if start < self.data_end:
            what = f"its data would start in clock {start}, the bus is taken until {self.data_end}"
            self._break(command, "data bus", what)
        self.data_end = max(self.data_end, start + self.dram.burst_clocks)
        self.last_column[command.command] = (command.clock, command.bank)
        self.last_of_group[command.command, self._group(command.bank)] = command.clock

    def _ref(self, command: Issued) -> None:
        timing = self.timing
        for number, bank in enumerate(self.banks):
            if bank.open_row is not None:
                self._break(command, "bank open", f"row {bank.open_row} of bank {number} is open")
            self._apart(command, "n_rp", bank.pre, timing.n_rp, f"PRE of bank {number}")
            self._apart(command, "n_rc", bank.act, timing.n_rc, f"ACT of bank {number}")
        self._apart(command, "n_rfc", self.last_ref, timing.n_rfc, "REF")
        early = self.refs + 1 - command.clock // timing.n_refi if timing.n_refi else 0
        if early > MOST_POSTPONED:
            self._break(
                command, "n_refi", f"{early} REF too many, no more than {MOST_POSTPONED} may be early"
            )

        self.last_ref, self.refs = command.clock, self.refs + 1
