"""Transitions of the diagram: which contacts start, turn and end, and what that costs in energy."""

from __future__ import annotations

from impact.evolve import EVENT_TOLERANCE, phase_margin, remaining
from impact.kernel import (
    COMPRESSION,
    INACTIVE,
    RESTITUTION,
    SLIDING,
    SPEED_FLOOR,
    STARTING,
    Contact,
    Core,
    acceleration,
    compiled,
    elastic_energy,
    push,
)
from impact.record import (
    COMPRESSION_ENDS,
    REACTIVATION,
    RESTITUTION_ENDS,
    Record,
    close_state,
    note_event,
)
from impact.series import spring_force
from impact.starting import tangential_response
from impact.sticking import choose_modes

SETTLED = 1e-9
"""Closing speed, and square root of the energy, below which nothing more is worth following."""
FAINTEST_PUSH = 1e-100
"""Push that counts; down a row of n balls at rest the first moment carries about MOMENT**(2 n)."""
MOMENT = 1e-2
"""How far ahead forces are looked at where contacts have just begun and have none yet."""


@compiled
def engage(core: Core) -> bool:
    """Activate the contacts that close, or rest and are pushed; say whether any is active and matters."""
    any_active = False
    for index in range(core.contacts.size):
        contact = core.contacts[index]
        if contact.phase == INACTIVE and contact.velocity[0] < -0.5 * SPEED_FLOOR:
            activate(contact)
        any_active = any_active or contact.phase != INACTIVE
    if not any_active or settled(core):
        return False
    look_ahead(core)
    while wake_resting(core):
        look_ahead(core)
    return True


@compiled
def settled(core: Core) -> bool:
    """Whether all that is left is below tolerance: a collapse takes infinitely many states (Theorem 3)."""
    stored = 0.0
    for index in range(core.contacts.size):
        contact = core.contacts[index]
        if contact.velocity[0] < -SETTLED:
            return False
        stored += elastic_energy(contact)
    if stored > SETTLED**2:
        return False
    for index in range(core.contacts.size):
        finish(core, index)
    return True


@compiled
def wake_resting(core: Core) -> bool:
    """Activate one contact at rest that the forces of the next moment push together, if there is one."""
    for index in range(core.contacts.size):
        contact = core.contacts[index]
        if contact.phase != INACTIVE or contact.velocity[0] > 2.0 * SPEED_FLOOR:
            continue
        row = index * core.rows
        size = 0.0
        column = 0
        for other in range(core.contacts.size):
            for axis in range(core.rows):
                size += abs(core.delassus[row, column] * core.contacts[other].forces[axis, 0])
                column += 1
        if -acceleration(core, row, 0) > max(1e-9 * size, FAINTEST_PUSH):
            contact.velocity[0] = min(contact.velocity[0], 0.0)  # else it may open before it is pushed
            activate(contact)
            return True
    return False


@compiled
def look_ahead(core: Core) -> None:
    """Write the forces of the next moment into the first terms of the force series; choose friction modes.

    Each pass carries the push one contact further, so that a row of touching balls is felt to its end.
    """
    for index in range(core.contacts.size):
        for axis in range(core.rows):
            core.contacts[index].forces[axis, 0] = 0.0
    for _ in range(core.contacts.size):
        for index in range(core.contacts.size):
            contact = core.contacts[index]
            if contact.phase != INACTIVE:
                depth = contact.compression if contact.compression > 0.0 else _depth_soon(core, index)
                contact.forces[0, 0] = spring_force(contact, depth)
        if core.rows > 1:
            choose_modes(core)


@compiled
def _depth_soon(core: Core, index: int) -> float:
    """Depth that a contact which has just begun will have a moment later."""
    opening = core.contacts[index].velocity[0] + MOMENT * acceleration(core, index * core.rows, 0)
    return float(MOMENT * max(-opening, 0.0))


@compiled
def activate(contact: Contact) -> None:
    """Begin compression at a contact."""
    contact.phase = COMPRESSION
    contact.compression = 0.0
    contact.first_impulse = contact.impulse[0]


@compiled
def transition(core: Core, record: Record) -> None:
    """Move every contact whose margin has vanished into its next phase.

    The state closes if that changed which contacts are active.
    """
    changed = False
    for index in range(core.contacts.size):
        contact = core.contacts[index]
        if phase_margin(contact, 0.0) > EVENT_TOLERANCE:
            continue
        if contact.phase == INACTIVE:
            activate(contact)
            note_event(record, REACTIVATION, index)
            changed = True
            continue
        if contact.phase == COMPRESSION:
            turn(contact, core.poisson)
            note_event(record, COMPRESSION_ENDS, index)
        elif remaining(contact, 0.0) > EVENT_TOLERANCE:
            contact.phase = COMPRESSION  # pushed together again before restitution could end
            continue
        if remaining(contact, 0.0) <= EVENT_TOLERANCE:
            finish(core, index)
            note_event(record, RESTITUTION_ENDS, index)
            changed = True
    if changed:
        close_state(core, record)


@compiled
def turn(contact: Contact, poisson: bool) -> None:
    """End compression and set where restitution will end (Section 2.2), or its rival by Poisson."""
    restitution = contact.restitution
    kept = (1.0 - restitution**2) ** (1.0 / (contact.exponent + 1.0))
    contact.phase = RESTITUTION
    contact.rest_compression = kept * contact.compression
    if poisson:
        impulse = contact.impulse[0]
        contact.last_impulse = impulse + restitution * (impulse - contact.first_impulse)


@compiled
def finish(core: Core, index: int) -> None:
    """End a contact and drop the energy left in it."""
    contact = core.contacts[index]
    contact.energy_dropped += elastic_energy(contact)
    if core.poisson and contact.phase == RESTITUTION:
        pay_impulse_owed(core, index)
    contact.compression = 0.0
    contact.phase = INACTIVE


@compiled
def pay_impulse_owed(core: Core, index: int) -> None:
    """Give at once the impulse Poisson's law still asks of an empty spring; its energy becomes negative."""
    contact = core.contacts[index]
    row = index * core.rows
    owed = contact.last_impulse - contact.impulse[0]
    if owed <= EVENT_TOLERANCE:
        return
    contact.energy_dropped -= owed * (contact.velocity[0] + 0.5 * core.delassus[row, row] * owed)
    push(core, row, owed)
    if core.rows > 1 and contact.mode in (STARTING, SLIDING):
        drag_at_once(core, index, contact.friction * owed)


@compiled
def drag_at_once(core: Core, index: int, limit: float) -> None:
    """Let friction brake a slide by an impulse up to a limit; it stops a slide, it does not turn it round."""
    contact = core.contacts[index]
    ahead_1, ahead_2 = contact.direction_1, contact.direction_2
    slip = contact.velocity[1] * ahead_1 + contact.velocity[2] * ahead_2
    first, mixed, second = tangential_response(core, index)
    response = first * ahead_1**2 + 2.0 * mixed * ahead_1 * ahead_2 + second * ahead_2**2
    drag = min(limit, max(slip, 0.0) / response)
    contact.friction_work += drag * (slip - 0.5 * response * drag)
    push(core, 3 * index + 1, -drag * ahead_1)
    push(core, 3 * index + 2, -drag * ahead_2)
