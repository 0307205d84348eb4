"""Whose request a cache looks up next, compiled, for those that do not go by arrival alone."""

from __future__ import annotations

from archsim.model.cache.spec import Arbiter
from archsim.model.compiled import NEVER, num_items, slot_of, step


@step
def chosen(spec, owner, inbox, cache, cycle):
    """Position in the cache's inbox of the request to look up in `cycle`; the first one has arrived."""
    found, least = 0, NEVER
    for position in range(num_items(inbox, cache)):
        waiting = inbox.items[cache, slot_of(inbox, cache, position)]
        if waiting["arrival"] > cycle:
            break
        turn = waiting["rank"]
        if spec["arbiter"] == Arbiter.ROUND_ROBIN and turn <= owner["last_sender"]:
            turn += NEVER >> 1
        if turn < least:
            found, least = position, turn
    return found


@step
def next_choice(inbox, cache, cycle):
    """When the first request arrives after `cycle`, which may be chosen instead of one refused then; or NEVER."""
    for position in range(num_items(inbox, cache)):
        arrival = inbox.items[cache, slot_of(inbox, cache, position)]["arrival"]
        if arrival > cycle:
            return arrival
    return NEVER
