"""The state of the compiled DRAM: queues, banks, channels, and what each channel will do next."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.model.compiled import NEVER, QueueState, new_queues, record
from archsim.model.dram.commands import COMMAND, DRAM_COUNTERS
from archsim.model.dram.spec import DramSpec

CLOSED = -1  # no row is open
NOBODY = 0  # the slot of no request
NO_KEY = 1 << 62  # its key; the key of others is the number with which they entered
# A wish, the least of which goes first, is from its lowest bit on: bank, whether of a write, key, ROW_BIT. A channel
# has at most 4,096 banks and serves at most 2**36 requests.
BANK_BITS = 12
KEY_SHIFT = BANK_BITS + 1
ROW_BIT = 1 << 49  # it needs an ACT or PRE first
NO_WISH = 1 << 62
NO_REQUESTER = 0  # who wants an answer has a number below 0
READS, WRITES = 0, 1  # kinds of requests; without a write queue, both wait in the first window
TO_READ, TO_WRITE, TO_ACT, TO_PRE = range(4)  # what a bank may be told; the first two by the kind of request

# What a channel does next.
PLAN_AGAIN, COLUMN, ROW, CLOSE, REFRESH = range(5)

LOG_CAPACITY = 1 << 17  # commands

ACTIVATES_OF_WINDOW = 4  # n_faw: the window holds four ACT
LONG_AGO = -(1 << 40)  # of an ACT that there has not been

_BANK_FIELDS = (
    "open_row",  # row in the row buffer, or CLOSED
    "last_use",  # clock of the last ACT or column command
    "opened",  # clock of the last ACT
    "closed",  # clock of the last PRE
    "act_ready",  # first clock for an ACT as far as it depends on the bank, or its group: a REF waits for that, too
)
_CHANNEL_FIELDS = (
    "last_burst",  # column command of the last request's last burst
    "next_refresh",  # when a REF is due
    "refresh_began",  # when the last REF was due
    "refresh_ended",  # when the banks could be used after it
    "written",  # when the last data written ended
    "written_bank",  # where it went
    "last_read",  # clock of the last RD
    "data_beats",  # beats of time until the data of the request answered last has moved
    "data_end",  # when the data of all requests served so far has moved
    "last_wake",  # clock at which the channel was last woken
    "is_draining",  # whether writes are served, if they have a queue of their own
    "sent",  # requests sent to the channel
    "entered",  # requests that entered a window
    "plan_due",  # when the plan is carried out
    "patience_ends",  # until this clock no request has waited for too long
)
_QUEUED_FIELDS = (
    "arrival",  # tick
    "rank",  # cache that sent the request; below 0: who asks without a cache
    "order",  # number of the request among those sent
    "clock",  # first at or after the arrival
    "address",
    "requester",
)
QUEUED = record(*_QUEUED_FIELDS, indices=("bursts", "is_write"))
WAITING = record(*_QUEUED_FIELDS, "row", "number", indices=("bursts", "is_write", "bank", "next"))
# What a request waited for, in clocks: from one to before the next, other requests, a refresh, others, its row,
# others, the bus to turn, others; then for its data.
REQUEST_WAIT = record("refreshing", "refreshed", "opening", "opened", "turning", "turned", "column")
LIST = record(
    "first_key", "hit_key", indices=("first", "last", "hit")
)  # slots; `hit`: the first of the open row
BANK = record(*_BANK_FIELDS)
CHANNEL = record(
    *_CHANNEL_FIELDS,
    *DRAM_COUNTERS,
    indices=(
        "free",  # first slot that no request uses
        "num_reads",  # reads in the first window
        "num_writes",  # writes in a window
        "plan",  # COLUMN, ROW ...
        "is_strict",  # whether it considers the oldest request only
        "kinds",  # bit for each kind of request that it considers
        "plan_bank",
        "plan_slot",  # request that it is for
    ),
)


class DramState(NamedTuple):
    """H channels, B banks. Times are memory clocks unless said otherwise.

    A request is sent, perhaps before it arrives, to a ring (`queue`); the oldest of them enter a window (`waiting`),
    where each is in the list of its bank and kind, the oldest first.
    """

    queue: QueueState  # QUEUED [2 H] sent: to the first window of each channel, then to its write queue
    waiting: np.ndarray  # WAITING [H, 1 + window entries] slots, the first unused
    lists: np.ndarray  # LIST [H, B, 2] waiting READS and WRITES of a bank
    banks: np.ndarray  # BANK [H, B]
    bounds: np.ndarray  # [H, 4 B] earliest clock of what each bank may be told: RD of all banks, WR, ACT, PRE
    wishes: np.ndarray  # [H, 4 B] first request considered that wants it, or NO_WISH: see `note_wishes`
    activates: np.ndarray  # [H, 4] clocks of the last four ACT, the oldest first
    channels: np.ndarray  # CHANNEL [H]
    waits: np.ndarray  # REQUEST_WAIT [H] of the request that was answered last
    due: np.ndarray  # [H] clock at which each channel must be woken
    next_due: np.ndarray  # [1] the first of them, or an earlier clock
    log: np.ndarray  # COMMAND [L] commands recorded; L = 0: none are
    log_size: np.ndarray  # [2] number of them, and of those for which there was no room


def recording(state: DramState) -> DramState:
    """The state with room for a record of commands, to be taken when it is half full."""
    return state._replace(log=np.zeros(LOG_CAPACITY, COMMAND))


def new_dram(spec: DramSpec, queue_capacity: int) -> DramState:
    """All banks closed, all queues empty, nothing recorded."""
    refresh = spec.timing.n_refi if spec.timing.n_refi > 0 else NEVER
    num_slots = 1 + spec.num_queue_entries + spec.num_write_entries
    waiting = np.zeros((spec.num_channels, num_slots), WAITING)
    waiting["next"][:, 1:-1] = np.arange(2, num_slots)
    waiting["number"][:, NOBODY] = NO_KEY
    lists = np.zeros((spec.num_channels, spec.num_banks, 2), LIST)
    lists["first_key"] = lists["hit_key"] = NO_KEY
    banks = np.zeros((spec.num_channels, spec.num_banks), BANK)
    banks["open_row"] = CLOSED
    banks["closed"] = -1
    channels = np.zeros(spec.num_channels, CHANNEL)
    channels["last_burst"] = channels["last_wake"] = -1
    channels["next_refresh"] = refresh
    channels["written"] = channels["last_read"] = LONG_AGO
    channels["free"] = 1
    channels["kinds"] = 1 << READS if spec.num_write_entries > 0 else 1 << READS | 1 << WRITES
    channels["plan"], channels["plan_due"] = PLAN_AGAIN, refresh
    return DramState(
        queue=new_queues(2 * spec.num_channels, queue_capacity, QUEUED),
        waiting=waiting,
        lists=lists,
        banks=banks,
        bounds=np.zeros((spec.num_channels, 4 * spec.num_banks), np.int64),
        wishes=np.full((spec.num_channels, 4 * spec.num_banks), NO_WISH),
        activates=np.full((spec.num_channels, ACTIVATES_OF_WINDOW), LONG_AGO, np.int64),
        channels=channels,
        waits=np.zeros(spec.num_channels, REQUEST_WAIT),
        due=np.full(spec.num_channels, refresh),
        next_due=np.array([refresh]),
        log=np.zeros(0, COMMAND),
        log_size=np.zeros(2, np.int64),
    )
