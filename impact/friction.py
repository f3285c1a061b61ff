"""Coulomb friction at any number of contacts: sliding, sticking, and the start of sliding (Section 3.1)."""

from __future__ import annotations

import math

from impact.kernel import (
    DIRECTION_1,
    DIRECTION_2,
    HEAT,
    INACTIVE,
    INVERSE,
    SLIDING,
    SQUARE,
    STARTING,
    STICKING,
    Contact,
    Core,
    compiled,
    inlined,
    value_at,
)
from impact.starting import starting_term

STOPPED = 30.0
"""Slip velocity, over the slowest that counts, at which a slide is looked at for a stop."""
AT_REST = 100.0
"""Slip velocity, over the slowest that counts, that is none: well above what errors leave across a slide."""
MOST_ROUNDS = 60


@compiled
def friction_terms(core: Core, order: int) -> None:
    """Write one term of the friction force at every active contact, and of the work it does.

    The normal forces must be known to this order. What slides depends on earlier terms only. What sticks or
    starts to slide depends on the other contacts' same term, so those are gone through until they agree.
    """
    starting = 0
    held = 0
    for index in range(core.contacts.size):
        contact = core.contacts[index]
        if contact.phase == INACTIVE:
            continue
        contact.slips[HEAT, 0] = 0.0
        if contact.mode == SLIDING:
            _direction_term(contact, order)
            _sliding_term(contact, order)
        starting += contact.mode == STARTING
        held += contact.mode == STICKING
    for _ in range(MOST_ROUNDS if starting > 1 or (starting > 0 and held > 0) else 1):
        change = 0.0
        if held > 0:
            hold(core, order)
        for index in range(core.contacts.size if starting > 0 else 0):
            if core.contacts[index].phase != INACTIVE and core.contacts[index].mode == STARTING:
                change = max(change, starting_term(core, index, order))
        if change <= 1e-15:
            break
    for index in range(core.contacts.size):
        contact = core.contacts[index]
        if contact.phase != INACTIVE and contact.mode in (STARTING, SLIDING):
            contact.slips[HEAT, order + 1] = -_power_of_friction(contact, order) / (order + 1)


@compiled
def _direction_term(contact: Contact, order: int) -> None:
    """Write one term of the unit vector of the slip velocity."""
    slip = contact.slips
    first, second = contact.velocities[1], contact.velocities[2]
    square = 0.0
    for lower in range(order + 1):
        square += first[lower] * first[order - lower] + second[lower] * second[order - lower]
    slip[SQUARE, order] = square
    if order == 0:
        slip[INVERSE, 0] = 1.0 / math.sqrt(square)
    else:
        total = 0.0
        for lower in range(1, order + 1):
            total += (0.5 * lower - order) * slip[SQUARE, lower] * slip[INVERSE, order - lower]
        slip[INVERSE, order] = total / (order * slip[SQUARE, 0])
    along_1, along_2 = 0.0, 0.0
    for lower in range(order + 1):
        along_1 += first[lower] * slip[INVERSE, order - lower]
        along_2 += second[lower] * slip[INVERSE, order - lower]
    slip[DIRECTION_1, order], slip[DIRECTION_2, order] = along_1, along_2


@compiled
def _sliding_term(contact: Contact, order: int) -> None:
    """Write one term of ``-μ (dp_n/dσ) û_t``."""
    slip, forces = contact.slips, contact.forces
    along_1, along_2 = 0.0, 0.0
    for lower in range(order + 1):
        along_1 += forces[0, lower] * slip[DIRECTION_1, order - lower]
        along_2 += forces[0, lower] * slip[DIRECTION_2, order - lower]
    forces[1, order], forces[2, order] = -contact.friction * along_1, -contact.friction * along_2


@compiled
def _power_of_friction(contact: Contact, order: int) -> float:
    first, second = 0.0, 0.0
    for lower in range(order + 1):
        first += contact.velocities[1, lower] * contact.forces[1, order - lower]
        second += contact.velocities[2, lower] * contact.forces[2, order - lower]
    return first + second


@inlined
def slip_along(contact: Contact, time: float) -> float:
    """Slip velocity along the direction noted for the contact."""
    first = value_at(contact.velocities[1], time)
    second = value_at(contact.velocities[2], time)
    return float(first * contact.direction_1 + second * contact.direction_2)


@compiled
def turn_directions(core: Core) -> bool:
    """Note the present direction of every slide; one that had just started is now a slide like any other.

    False if a slide that started is too slow for that: it may have stopped at once, so it must be looked at
    again.
    """
    all_slide = True
    for index in range(core.contacts.size):
        contact = core.contacts[index]
        if contact.phase == INACTIVE or contact.mode not in (STARTING, SLIDING):
            continue
        slip = math.hypot(contact.velocity[1], contact.velocity[2])
        if slip > STOPPED * contact.slowest:
            contact.mode = SLIDING
            contact.direction_1 = contact.velocity[1] / slip
            contact.direction_2 = contact.velocity[2] / slip
        elif contact.mode == STARTING:
            all_slide = False
    return all_slide


@compiled
def friction_margin(contact: Contact, time: float) -> float:
    """How far an active contact is from leaving its mode; positive while it stays."""
    if contact.mode == SLIDING:
        return float(slip_along(contact, time) - STOPPED * contact.slowest)
    if contact.mode == STICKING:
        first = value_at(contact.forces[1], time)
        second = value_at(contact.forces[2], time)
        limit = contact.friction * value_at(contact.forces[0], time)
        return float(limit * (1.0 + 1e-9) + 1e-15 - math.hypot(first, second))
    return math.inf


@inlined
def is_held(core: Core, row: int) -> bool:
    """Whether a row is a tangent of a contact that is active and sticks."""
    contact = core.contacts[row // 3]
    return bool(row % 3 > 0 and contact.phase != INACTIVE and contact.mode == STICKING)


@compiled
def hold(core: Core, order: int) -> None:
    """Write one term of the friction that keeps all sticking contacts at rest together.

    The unknowns stay where they belong, among the forces; `held` is their matrix, already factored.
    """
    contacts = core.contacts
    size = 3 * contacts.size
    for row in range(size):  # forward substitution
        if not is_held(core, row):
            continue
        total = 0.0
        for other in range(size):
            if not is_held(core, other):
                total -= core.delassus[row, other] * contacts[other // 3].forces[other % 3, order]
            elif other < row:
                total -= core.held[row, other] * contacts[other // 3].forces[other % 3, order]
        contacts[row // 3].forces[row % 3, order] = total / core.held[row, row]
    for row in range(size - 1, -1, -1):  # back substitution
        if not is_held(core, row):
            continue
        total = contacts[row // 3].forces[row % 3, order]
        for other in range(row + 1, size):
            if is_held(core, other):
                total -= core.held[other, row] * contacts[other // 3].forces[other % 3, order]
        contacts[row // 3].forces[row % 3, order] = total / core.held[row, row]


@compiled
def factor_held(core: Core) -> None:
    """Cholesky factor of the Delassus block of the sticking contacts.

    A tiny ridge lets contacts share a load that the laws do not divide, as two feet of one rigid body do.
    """
    size = 3 * core.contacts.size
    core.held[:, :] = 0.0
    for row in range(size):
        if not is_held(core, row):
            continue
        for column in range(row + 1):
            if not is_held(core, column):
                continue
            total = core.delassus[row, column]
            for other in range(column):
                total -= core.held[row, other] * core.held[column, other]
            if row == column:
                core.held[row, row] = math.sqrt(max(total, 0.0) + 1e-13)
            else:
                core.held[row, column] = total / core.held[column, column]
