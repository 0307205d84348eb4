"""The DRAM sections of a machine: chips, timing, queues and policies, with the checks between their numbers."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from archsim.config.section import Count, Finding, Section, Size, Small, is_power_of_two, report
from archsim.units import Frequency, format_bytes

MAX_DRAM_BYTES = 2**40
ADDRESS_FIELDS = ("row", "bank", "line", "channel", "offset")
GROUP = "group"  # one more field where there are bank groups

Clocks = Annotated[int, Field(ge=1, le=1_000_000, json_schema_extra={"unit": "memory clocks"})]
LongTime = Annotated[int, Field(ge=0, le=1_000_000_000, json_schema_extra={"unit": "memory clocks"})]


class TimingConfig(Section):
    """Constraints of the DRAM's data sheet in memory clocks."""

    n_cl: Clocks  # read command to first data
    n_wl: Clocks  # write command to first data
    n_rcd_read: Clocks  # activate to read
    n_rcd_write: Clocks  # activate to write
    n_rp: Clocks  # precharge to activate
    n_ras: Clocks  # activate to precharge
    n_rc: Clocks  # activate to activate, same bank
    n_rrd: Clocks  # activate to activate, other bank
    n_rrd_l: Clocks | None = None  # the same within a bank group; given if and only if there are groups
    n_faw: Clocks | None = None  # activate to the fourth activate after it; null: no such rule
    n_ccd: Clocks  # column command to column command
    n_ccd_l: Clocks | None = None  # the same within a bank group
    n_rtp: Clocks  # read to precharge
    n_wr: Clocks  # last data written to precharge
    n_wtr: Clocks  # last data written to read
    n_wtr_l: Clocks | None = None  # the same within a bank group
    n_rtw: Clocks  # read to write
    n_rfc: Clocks  # refresh to activate
    n_refi: LongTime  # between refreshes; 0: never

    @model_validator(mode="after")
    def _check(self) -> TimingConfig:
        report(_check_timing(self))
        return self


class WriteQueueConfig(Section):
    """Writes wait apart from reads; they are served when `high` wait, until `low` do, or while no read waits."""

    entries: Count  # oldest writes of a channel that the scheduler sees
    high: Count  # waiting writes that start a drain
    low: Annotated[int, Field(ge=0)]  # waiting writes that end it

    @model_validator(mode="after")
    def _check(self) -> WriteQueueConfig:
        found = []
        if self.high > self.entries:
            found.append(Finding(("high",), f"must be at most entries, {self.entries}, not {self.high}"))
        if self.low >= self.high:
            found.append(Finding(("low",), f"must be below high, {self.high}, not {self.low}"))
        report(found)
        return self


class DramConfig(Section):
    """Independent DRAM channels, each with its own commands, data and banks."""

    kind: Literal["dram"]
    clock: str  # its clock, by name
    frequency: Frequency | None = None  # that the timing is meant for; checked against the clock if given
    channels: Small  # independent channels
    banks: Small  # of a channel
    bank_groups: Small = 1  # of a channel; 1: none
    rows: Count  # of a bank
    row_bytes: Size  # of one bank
    channel_width: Size  # bytes of one beat
    burst_beats: Annotated[int, Field(ge=2, le=256)]  # beats of one column command
    data_rate: Literal[2, 4]  # beats a clock
    address_map: str  # ADDRESS_FIELDS, and GROUP, from the most to the least significant bits
    bank_hash: Literal["none", "xor"] = "none"  # xor: the lowest bits of the row are XORed into the bank
    queue_entries: Count  # oldest requests of a channel that the scheduler sees
    write_queue: WriteQueueConfig | None = None  # null: writes wait among the reads
    scheduler: Literal["fcfs", "fr_fcfs"]  # fcfs: the oldest request; fr_fcfs: row hits first
    max_wait_clocks: LongTime  # fr_fcfs: a longer wait is served first
    page_policy: Literal["open", "closed", "timeout"] = "open"  # when a row that nobody wants is closed
    page_timeout_clocks: Clocks | None = None  # timeout: from a row's last use until it is closed
    timing: TimingConfig  # constraints of the data sheet

    @property
    def capacity_bytes(self) -> int:
        return self.channels * self.banks * self.rows * self.row_bytes

    @property
    def burst_clocks(self) -> int:
        """Clocks of a burst's data."""
        return self.burst_beats // self.data_rate

    @property
    def burst_bytes(self) -> int:
        return self.burst_beats * self.channel_width

    def address_fields(self, line_bytes: int) -> dict[str, tuple[int, int]]:
        """(shift, bits) of every field of the byte address, for the last cache's line size."""
        sizes = {
            "offset": line_bytes,
            "channel": self.channels,
            "line": self.row_bytes // line_bytes,
            GROUP: self.bank_groups,
            "bank": self.banks // self.bank_groups,
            "row": self.rows,
        }
        fields, shift = {}, 0
        for name in reversed(self.address_map.split(":")):
            bits = sizes[name].bit_length() - 1
            fields[name] = (shift, bits)
            shift += bits
        return fields

    @model_validator(mode="after")
    def _check(self) -> DramConfig:
        checks = (_check_sizes, _check_data_bus, _check_groups, _check_address_map, _check_page_policy)
        report([finding for check in checks for finding in check(self)])
        return self


class IdealDramConfig(Section):
    """A DRAM that serves every request when it comes: a fixed latency, any bandwidth."""

    kind: Literal["ideal_dram"]
    clock: str  # its clock, by name
    size: Size  # capacity
    latency_clocks: Clocks  # from a read's arrival to its data

    @property
    def capacity_bytes(self) -> int:
        return self.size


def _check_timing(timing: TimingConfig) -> list[Finding]:
    found = []
    if timing.n_ras < timing.n_rcd_read:
        found.append(Finding(("n_ras",), f"must be at least n_rcd_read, {timing.n_rcd_read}"))
    if timing.n_rc < timing.n_ras + timing.n_rp:
        found.append(Finding(("n_rc",), f"must be at least n_ras + n_rp, {timing.n_ras + timing.n_rp}"))
    if timing.n_faw is not None and timing.n_faw < timing.n_rrd:
        found.append(Finding(("n_faw",), f"must be at least n_rrd, {timing.n_rrd}"))
    for name in ("n_rrd", "n_ccd", "n_wtr"):
        within, any_group = getattr(timing, f"{name}_l"), getattr(timing, name)
        if within is not None and within < any_group:
            found.append(Finding((f"{name}_l",), f"must be at least {name}, {any_group}"))
    least = 4 * (timing.n_rfc + timing.n_rc)  # or refresh would leave no time to serve a request
    if 0 < timing.n_refi < least:
        found.append(Finding(("n_refi",), f"must be at least 4 (n_rfc + n_rc), {least}, or 0 for no refresh"))
    return found


def _check_sizes(dram: DramConfig) -> list[Finding]:
    names = ["channels", "banks", "bank_groups", "rows", "row_bytes", "channel_width", "burst_beats"]
    found = [
        Finding((name,), f"must be a power of two, not {getattr(dram, name)}")
        for name in names
        if not is_power_of_two(getattr(dram, name))
    ]
    if dram.capacity_bytes > MAX_DRAM_BYTES:
        what = f"channels x banks x rows x row_bytes is above {format_bytes(MAX_DRAM_BYTES)}"
        found.append(Finding(("rows",), what))
    return found


def _check_data_bus(dram: DramConfig) -> list[Finding]:
    """Bursts that would take part of a clock, or meet on the data bus."""
    timing, found = dram.timing, []
    if dram.burst_beats % dram.data_rate:
        found.append(Finding(("burst_beats",), f"must be whole clocks of {dram.data_rate} beats"))
    if timing.n_ccd < dram.burst_clocks:
        what = f"must be at least the clocks of a burst's data, {dram.burst_clocks}"
        found.append(Finding(("timing", "n_ccd"), what))
    least = timing.n_cl + dram.burst_clocks - timing.n_wl
    if timing.n_rtw < least:
        what = f"must be at least n_cl + the clocks of a burst's data - n_wl, {least}"
        found.append(Finding(("timing", "n_rtw"), what))
    return found


def _check_groups(dram: DramConfig) -> list[Finding]:
    """Timing within bank groups where there are none, or none where there are."""
    found = []
    if dram.bank_groups > dram.banks:
        found.append(Finding(("bank_groups",), f"must be at most banks, {dram.banks}"))
    for name in ("n_rrd_l", "n_ccd_l", "n_wtr_l"):
        is_given = getattr(dram.timing, name) is not None
        if is_given and dram.bank_groups == 1:
            found.append(Finding(("timing", name), "has no effect without bank_groups"))
        if not is_given and dram.bank_groups > 1:
            found.append(Finding(("timing",), f"must give {name}: there are bank_groups"))
    return found


def _check_address_map(dram: DramConfig) -> list[Finding]:
    names = dram.address_map.split(":")
    wanted = [*ADDRESS_FIELDS[:2], *([GROUP] if dram.bank_groups > 1 else []), *ADDRESS_FIELDS[2:]]
    if sorted(names) != sorted(wanted):
        what = f"must hold {', '.join(wanted)} once each, with ':' between, not '{dram.address_map}'"
        return [Finding(("address_map",), what)]
    if names[-1] != "offset":
        return [Finding(("address_map",), "must end with offset: a request stays in one row")]
    return []


def _check_page_policy(dram: DramConfig) -> list[Finding]:
    if dram.page_policy == "timeout" and dram.page_timeout_clocks is None:
        return [Finding((), "must give page_timeout_clocks: page_policy is timeout")]
    if dram.page_policy != "timeout" and dram.page_timeout_clocks is not None:
        return [Finding(("page_timeout_clocks",), "has no effect unless page_policy is timeout")]
    return []
