"""Coulomb friction at any number of contacts: sliding, sticking, and the start of sliding (Section 3.1)."""

from __future__ import annotations

import math

from impact._checks import Array
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
    Core,
    compiled,
    value_at,
)
from impact.starting import starting_term

STOPPED = 30.0
"""Slip velocity, over the tolerance, at which a slide is looked at for a stop."""
AT_REST = 100.0
"""Slip velocity, over the tolerance, that counts as none: well above what errors leave across the slide."""
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
        if contact.mode == SLIDING:
            _direction_term(core, index, order)
            _sliding_term(core, index, order)
        starting += contact.mode == STARTING
        held += contact.mode == STICKING
    for _ in range(MOST_ROUNDS if starting > 1 or (starting > 0 and held > 0) else 1):
        change = 0.0
        if held > 0:
            hold(core, core.forces, order)
        for index in range(core.contacts.size if starting > 0 else 0):
            if core.contacts[index].phase != INACTIVE and core.contacts[index].mode == STARTING:
                change = max(change, starting_term(core, index, order))
        if change <= 1e-15:
            break
    for index in range(core.contacts.size):
        core.slips[index, HEAT, order + 1] = -_power_of_friction(core, index, order) / (order + 1)


@compiled
def _direction_term(core: Core, index: int, order: int) -> None:
    """Write one term of the unit vector of the slip velocity."""
    slip = core.slips[index]
    first = core.velocities[3 * index + 1]
    second = core.velocities[3 * index + 2]
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
    for lower in range(order + 1):
        slip[DIRECTION_1, order] += first[lower] * slip[INVERSE, order - lower]
        slip[DIRECTION_2, order] += second[lower] * slip[INVERSE, order - lower]


@compiled
def _sliding_term(core: Core, index: int, order: int) -> None:
    """Write one term of ``-μ (dp_n/dσ) û_t``."""
    slip = core.slips[index]
    normal = core.forces[3 * index]
    friction = core.contacts[index].friction
    for lower in range(order + 1):
        core.forces[3 * index + 1, order] -= friction * normal[lower] * slip[DIRECTION_1, order - lower]
        core.forces[3 * index + 2, order] -= friction * normal[lower] * slip[DIRECTION_2, order - lower]


@compiled
def _power_of_friction(core: Core, index: int, order: int) -> float:
    total = 0.0
    for row in (3 * index + 1, 3 * index + 2):
        for lower in range(order + 1):
            total += core.velocities[row, lower] * core.forces[row, order - lower]
    return total


@compiled
def slip_along(core: Core, index: int, time: float) -> float:
    """Slip velocity along the direction noted for the contact."""
    contact = core.contacts[index]
    return float(
        value_at(core.velocities, 3 * index + 1, time) * contact.direction_1
        + value_at(core.velocities, 3 * index + 2, time) * contact.direction_2
    )


@compiled
def turn_directions(core: Core) -> None:
    """Note the present direction of every slide; one that had just started is now a slide like any other."""
    for index in range(core.contacts.size):
        contact = core.contacts[index]
        slip = math.hypot(core.velocity[3 * index + 1], core.velocity[3 * index + 2])
        if (
            contact.phase != INACTIVE
            and contact.mode in (STARTING, SLIDING)
            and slip > STOPPED * core.tolerance
        ):
            contact.mode = SLIDING
            contact.direction_1 = core.velocity[3 * index + 1] / slip
            contact.direction_2 = core.velocity[3 * index + 2] / slip


@compiled
def friction_margin(core: Core, index: int, time: float) -> float:
    """How far an active contact is from leaving its mode; positive while it stays."""
    contact = core.contacts[index]
    if contact.mode == SLIDING:
        return slip_along(core, index, time) - STOPPED * core.tolerance
    if contact.mode == STICKING:
        first = value_at(core.forces, 3 * index + 1, time)
        second = value_at(core.forces, 3 * index + 2, time)
        limit = contact.friction * value_at(core.forces, 3 * index, time)
        return float(limit * (1.0 + 1e-9) + 1e-15 - math.hypot(first, second))
    return math.inf


@compiled
def is_held(core: Core, index: int) -> bool:
    """Whether a contact is active and sticks."""
    contact = core.contacts[index]
    return bool(contact.phase != INACTIVE and contact.mode == STICKING)


@compiled
def hold(core: Core, forces: Array, column: int) -> None:
    """Write into one column of `forces` the friction that keeps all sticking contacts at rest together."""
    for index in range(core.contacts.size):
        if is_held(core, index):
            for row in (3 * index + 1, 3 * index + 2):
                forces[row, column] = 0.0
    size = core.velocity.size
    for row in range(size):  # forward substitution, with the unknowns kept in place
        if row % 3 == 0 or not is_held(core, row // 3):
            continue
        total = 0.0
        for other in range(size):
            if other % 3 == 0 or not is_held(core, other // 3):
                total -= core.delassus[row, other] * forces[other, column]
        for other in range(row):
            total -= core.held[row, other] * forces[other, column]
        forces[row, column] = total / core.held[row, row]
    for row in range(size - 1, -1, -1):  # back substitution
        if row % 3 == 0 or not is_held(core, row // 3):
            continue
        total = forces[row, column]
        for other in range(row + 1, size):
            total -= core.held[other, row] * forces[other, column]
        forces[row, column] = total / core.held[row, row]


@compiled
def factor_held(core: Core) -> None:
    """Cholesky factor of the Delassus block of the sticking contacts.

    A tiny ridge lets contacts share a load that the laws do not divide, as two feet of one rigid body do.
    """
    size = core.velocity.size
    core.held[:, :] = 0.0
    for row in range(size):
        if row % 3 == 0 or not is_held(core, row // 3):
            continue
        for column in range(row + 1):
            if column % 3 == 0 or not is_held(core, column // 3):
                continue
            total = core.delassus[row, column]
            for other in range(column):
                total -= core.held[row, other] * core.held[column, other]
            if row == column:
                core.held[row, row] = math.sqrt(max(total, 0.0) + 1e-13)
            else:
                core.held[row, column] = total / core.held[column, column]
