"""Transitions of the diagram: which contacts start, turn and end, and what that costs in energy."""

from __future__ import annotations

from impact.evolve import EVENT_TOLERANCE, margin, remaining
from impact.kernel import (
    COMPRESSION,
    INACTIVE,
    POINT,
    RATES,
    RESTITUTION,
    SPEED_FLOOR,
    Core,
    acceleration,
    compiled,
    contact_velocity,
    elastic_energy,
    load_point,
    rates_at,
)
from impact.record import (
    COMPRESSION_ENDS,
    REACTIVATION,
    RESTITUTION_ENDS,
    Record,
    close_state,
    note_event,
)


@compiled
def engage(core: Core) -> bool:
    """Activate the contacts that close, or rest and are pushed; say whether any is active and matters."""
    any_active = False
    for index in range(core.contacts.size):
        contact = core.contacts[index]
        if contact.phase == INACTIVE and core.velocity[index * core.rows] < -0.5 * SPEED_FLOOR:
            activate(core, index)
        any_active = any_active or contact.phase != INACTIVE
    if not any_active or settled(core):
        return False
    while wake_resting(core):
        pass
    return True


@compiled
def settled(core: Core) -> bool:
    """Whether all that is left is below tolerance: a collapse takes infinitely many states (Theorem 3)."""
    stored = 0.0
    for index in range(core.contacts.size):
        if core.velocity[index * core.rows] < -core.tolerance:
            return False
        stored += elastic_energy(core, index)
    if stored > core.tolerance**2:
        return False
    for index in range(core.contacts.size):
        finish(core, index)
    return True


@compiled
def wake_resting(core: Core) -> bool:
    """Activate one contact at rest that the forces of the next moment push together, if there is one."""
    look_ahead(core)
    for index in range(core.contacts.size):
        row = index * core.rows
        if core.contacts[index].phase != INACTIVE or core.velocity[row] > 2.0 * SPEED_FLOOR:
            continue
        push = -acceleration(core, row, RATES)
        size = 0.0
        for column in range(core.velocity.size):
            size += abs(core.delassus[row, column] * core.work[RATES, core.contacts.size + column])
        if push > 1e-9 * size:
            activate(core, index)
            return True
    return False


@compiled
def look_ahead(core: Core) -> None:
    """Write into row RATES the rates a moment later, when contacts that just began have some force.

    Each pass carries the push one contact further, so that a row of touching balls is felt to its end.
    """
    moment = 1e-4
    load_point(core, POINT)
    rates_at(core, POINT, RATES)
    for _ in range(core.contacts.size):
        for index in range(core.contacts.size):
            contact = core.contacts[index]
            if contact.phase != INACTIVE:
                row = index * core.rows
                closing = -core.velocity[row] - moment * acceleration(core, row, RATES)
                core.work[POINT, index] = contact.compression + moment * max(closing, 0.0)
        rates_at(core, POINT, RATES)


@compiled
def activate(core: Core, index: int) -> None:
    """Begin compression at a contact."""
    contact = core.contacts[index]
    contact.phase = COMPRESSION
    contact.compression = 0.0
    contact.first_impulse = core.impulse[index * core.rows]


@compiled
def transition(core: Core, record: Record) -> None:
    """Move every contact whose margin has vanished into its next phase.

    The state closes if that changed which contacts are active.
    """
    changed = False
    load_point(core, POINT)
    contact_velocity(core, POINT)
    for index in range(core.contacts.size):
        if margin(core, index, POINT) > EVENT_TOLERANCE:
            continue
        contact = core.contacts[index]
        if contact.phase == INACTIVE:
            activate(core, index)
            note_event(record, REACTIVATION, index)
            changed = True
            continue
        if contact.phase == COMPRESSION:
            turn(core, index)
            note_event(record, COMPRESSION_ENDS, index)
        elif remaining(core, index, POINT) > EVENT_TOLERANCE:
            contact.phase = COMPRESSION  # pushed together again before restitution could end
            continue
        if remaining(core, index, POINT) <= EVENT_TOLERANCE:
            finish(core, index)
            note_event(record, RESTITUTION_ENDS, index)
            changed = True
    if changed:
        close_state(core, record)


@compiled
def turn(core: Core, index: int) -> None:
    """End compression and set where restitution will end (Section 2.2), or its rival by Poisson."""
    contact = core.contacts[index]
    restitution = contact.restitution
    impulse = core.impulse[index * core.rows]
    kept = (1.0 - restitution**2) ** (1.0 / (contact.exponent + 1.0))
    contact.phase = RESTITUTION
    contact.rest_compression = kept * contact.compression
    contact.last_impulse = impulse + restitution * (impulse - contact.first_impulse)


@compiled
def finish(core: Core, index: int) -> None:
    """End a contact and drop the energy left in it."""
    contact = core.contacts[index]
    contact.energy_dropped += elastic_energy(core, index)
    if core.poisson and contact.phase == RESTITUTION:
        pay_impulse_owed(core, index)
    contact.compression = 0.0
    contact.phase = INACTIVE


@compiled
def pay_impulse_owed(core: Core, index: int) -> None:
    """Give at once the impulse Poisson's law still asks of an empty spring; its energy becomes negative."""
    contact = core.contacts[index]
    row = index * core.rows
    owed = contact.last_impulse - core.impulse[row]
    if owed <= EVENT_TOLERANCE:
        return
    contact.energy_dropped -= owed * (core.velocity[row] + 0.5 * core.delassus[row, row] * owed)
    core.impulse[row] += owed
    for other in range(core.velocity.size):
        core.velocity[other] += core.delassus[other, row] * owed
