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
    Core,
    compiled,
    elastic_energy,
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
        if contact.phase == INACTIVE and core.velocity[index * core.rows] < -0.5 * SPEED_FLOOR:
            activate(core, index)
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
        if core.velocity[index * core.rows] < -SETTLED:
            return False
        stored += elastic_energy(core, index)
    if stored > SETTLED**2:
        return False
    for index in range(core.contacts.size):
        finish(core, index)
    return True


@compiled
def wake_resting(core: Core) -> bool:
    """Activate one contact at rest that the forces of the next moment push together, if there is one."""
    for index in range(core.contacts.size):
        row = index * core.rows
        if core.contacts[index].phase != INACTIVE or core.velocity[row] > 2.0 * SPEED_FLOOR:
            continue
        push = 0.0
        size = 0.0
        for column in range(core.velocity.size):
            part = core.delassus[row, column] * core.forces[column, 0]
            push -= part
            size += abs(part)
        if push > max(1e-9 * size, FAINTEST_PUSH):
            activate(core, index)
            return True
    return False


@compiled
def look_ahead(core: Core) -> None:
    """Write the forces of the next moment into the first column of `core.forces`, and choose friction modes.

    Each pass carries the push one contact further, so that a row of touching balls is felt to its end.
    """
    for row in range(core.velocity.size):
        core.forces[row, 0] = 0.0
    for _ in range(core.contacts.size):
        for index in range(core.contacts.size):
            contact = core.contacts[index]
            if contact.phase != INACTIVE:
                depth = contact.compression if contact.compression > 0.0 else _depth_soon(core, index)
                core.forces[index * core.rows, 0] = spring_force(core, index, depth)
        if core.rows > 1:
            choose_modes(core)


@compiled
def _depth_soon(core: Core, index: int) -> float:
    """Depth that a contact which has just begun will have a moment later."""
    row = index * core.rows
    closing = -core.velocity[row]
    for column in range(core.velocity.size):
        closing -= MOMENT * core.delassus[row, column] * core.forces[column, 0]
    return float(MOMENT * max(closing, 0.0))


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
    for index in range(core.contacts.size):
        if phase_margin(core, index, 0.0) > EVENT_TOLERANCE:
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
        elif remaining(core, index, 0.0) > EVENT_TOLERANCE:
            contact.phase = COMPRESSION  # pushed together again before restitution could end
            continue
        if remaining(core, index, 0.0) <= EVENT_TOLERANCE:
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
    if core.rows > 1 and contact.mode in (STARTING, SLIDING):
        for tangent, direction in ((row + 1, contact.direction_1), (row + 2, contact.direction_2)):
            drag = -contact.friction * owed * direction
            core.impulse[tangent] += drag
            for other in range(core.velocity.size):
                core.velocity[other] += core.delassus[other, tangent] * drag
