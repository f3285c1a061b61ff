"""The compiled notebook: states, events and the path between them, in tables of fixed length.

Counting goes on when a table is full, so the caller learns how much room a second run needs.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from impact._checks import Array
from impact.kernel import INACTIVE, SPEED_FLOOR, Core, compiled, value_at

Integers = npt.NDArray[np.int64]

STATES, SAMPLES, EVENTS, IS_OPEN = 0, 1, 2, 3
COMPRESSION_ENDS, RESTITUTION_ENDS, REACTIVATION = 0, 1, 2


class Record(NamedTuple):
    """What is written down during one collision; with a leading axis N, during N collisions."""

    counts: Integers  # (4,) states, samples, events; whether a state has begun and not ended
    states: Integers  # (states, 2 + n) first and last sample, then which contacts are active
    events: Integers  # (events, 3) state, code, contact
    samples: Array  # (samples, 2 n + n r) compressions, modes (-1 if inactive), impulses


class Room(NamedTuple):
    """How much fits into a record."""

    states: int
    events: int
    samples: int


def new_records(collisions: int, contacts: int, size: int, room: Room) -> Record:
    """Empty notebooks for N collisions of n contacts and impulses of `size` numbers."""
    return Record(
        np.zeros((collisions, 4), np.int64),
        np.empty((collisions, room.states, 2 + contacts), np.int64),
        np.empty((collisions, room.events, 3), np.int64),
        np.empty((collisions, room.samples, 2 * contacts + size)),
    )


def room_needed(records: Record, room: Room) -> Room:
    """Room that would have held everything; what was not wanted at all stays so."""
    states, samples, events, _ = records.counts.max(axis=0, initial=0).tolist()
    return Room(
        max(room.states, states + 1),
        max(room.events, events) if room.events else 0,
        max(room.samples, samples) if room.samples else 0,
    )


@compiled
def note_sample(core: Core, record: Record, time: float) -> None:
    """Write down where the present step is at a time."""
    sample = record.counts[SAMPLES]
    record.counts[SAMPLES] += 1
    if sample >= record.samples.shape[0]:
        return
    count = core.contacts.size
    for index in range(count):
        contact = core.contacts[index]
        record.samples[sample, index] = value_at(contact.compressions, time)
        record.samples[sample, count + index] = contact.mode if contact.phase != INACTIVE else -1
        for axis in range(core.rows):
            impulse = contact.impulse[axis] + value_at(contact.impulses[axis], time)
            record.samples[sample, 2 * count + index * core.rows + axis] = impulse


@compiled
def note_event(record: Record, code: int, index: int) -> None:
    """Write down that something happened at a contact in the present state."""
    event = record.counts[EVENTS]
    record.counts[EVENTS] += 1
    if event < record.events.shape[0]:
        record.events[event, 0] = record.counts[STATES]
        record.events[event, 1] = code
        record.events[event, 2] = index


@compiled
def open_state(core: Core, record: Record) -> None:
    """Begin a state, unless one has begun: note which contacts are active and where the path starts."""
    if record.counts[IS_OPEN]:
        return
    record.counts[IS_OPEN] = 1
    for index in range(core.contacts.size):
        contact = core.contacts[index]
        for axis in range(core.rows):
            contact.opening[axis] = contact.impulse[axis]
    state = record.counts[STATES]
    if state < record.states.shape[0]:
        record.states[state, 0] = record.counts[SAMPLES]
        for index in range(core.contacts.size):
            record.states[state, 2 + index] = core.contacts[index].phase != INACTIVE


@compiled
def close_state(core: Core, record: Record) -> None:
    """End a state; one in which no impulse grew is no state and is written over by the next."""
    record.counts[IS_OPEN] = 0
    growth = 0.0
    for index in range(core.contacts.size):
        contact = core.contacts[index]
        for axis in range(core.rows):
            growth = max(growth, abs(contact.impulse[axis] - contact.opening[axis]))
    if growth <= SPEED_FLOOR:
        return
    state = record.counts[STATES]
    record.counts[STATES] += 1
    if state < record.states.shape[0]:
        record.states[state, 1] = record.counts[SAMPLES]
