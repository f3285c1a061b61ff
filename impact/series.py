"""Taylor series of the motion inside a state.

The impact equations are so plain that every derivative follows from the one before: ``δ`` from ``u``, the
force from ``δ``, ``Δp`` from the force, and ``u = u⁽⁰⁾ + A Δp`` (5, 6, 18). A step of order 20 needs no trial
and no error estimate but its own last terms, and it is its own dense output.

Method: À. Jorba, M. Zou, "A software package for the numerical integration of ODEs by means of high-order
Taylor methods", Experimental Mathematics 14 (2005) 99-117, doi:10.1080/10586458.2005.10128904; the recurrence
for powers is their Proposition 2.1.
"""

from __future__ import annotations

import math

from impact._checks import Array
from impact.friction import friction_terms
from impact.kernel import INACTIVE, ORDER, Contact, Core, acceleration, compiled, inlined

FOOT = 1e-5
"""Below this depth a Hertzian spring is taken as linear, since ``δ**1.5`` has no series at δ = 0.

The energy stored there is less than 1e-12 of the whole, so no outcome feels it.
"""
FARTHEST = 0.8
"""Longest step of a Hertzian spring, over the time that would empty it: ``δ**1.5`` has no series there.

A loose tolerance alone would let the first steps go beyond: small terms do not tell that a series converges.
"""


@compiled
def expand(core: Core) -> None:
    """Write the series of compression, force, impulse and velocity from the present state on."""
    for index in range(core.contacts.size):
        _load(core.contacts[index], core.rows)
    for order in range(ORDER):
        share = 1.0 / (order + 1)
        for index in range(core.contacts.size):
            contact = core.contacts[index]
            if contact.phase != INACTIVE:
                contact.forces[0, order] = _force_term(contact, order)
                contact.compressions[order + 1] = -contact.velocities[0, order] * share
        if core.rows > 1:
            friction_terms(core, order)
        row = 0
        for index in range(core.contacts.size):
            contact = core.contacts[index]
            for axis in range(core.rows):
                contact.impulses[axis, order + 1] = contact.forces[axis, order] * share
                contact.velocities[axis, order + 1] = acceleration(core, row, order) * share
                row += 1


@inlined
def _load(contact: Contact, rows: int) -> None:
    """Set the terms of order 0, and all others to zero."""
    contact.onset = -1
    contact.compressions[:] = 0.0
    contact.compressions[0] = contact.compression
    for axis in range(rows):
        contact.velocities[axis, :] = 0.0
        contact.velocities[axis, 0] = contact.velocity[axis]
        contact.forces[axis, :] = 0.0
        contact.impulses[axis, :] = 0.0


@inlined
def spring_force(contact: Contact, depth: float) -> float:
    """Force ``k δ**η`` of the virtual spring at a depth."""
    if contact.exponent == 1.0:
        return float(contact.stiffness * depth)
    if depth < FOOT:
        return float(contact.stiffness * FOOT ** (contact.exponent - 1.0) * depth)
    return float(contact.stiffness * depth**contact.exponent)


@inlined
def _force_term(contact: Contact, order: int) -> float:
    """One term of the normal force."""
    term = contact.compressions[order]
    if order == 0:
        return spring_force(contact, term)
    if contact.exponent == 1.0:
        return float(contact.stiffness * term)
    if contact.compressions[0] < FOOT:
        return float(contact.stiffness * FOOT ** (contact.exponent - 1.0) * term)
    return _power_term(contact.compressions, contact.forces[0], contact.exponent, order)


@compiled
def _power_term(base: Array, power: Array, exponent: float, order: int) -> float:
    """One term of the series ``power = c base**exponent``, whose earlier terms are known."""
    total = 0.0
    for lower in range(1, order + 1):
        total += (exponent * lower - (order - lower)) * base[lower] * power[order - lower]
    return float(total / (order * base[0]))


@compiled
def longest_step(core: Core) -> float:
    """Step at which the last two terms of every impulse and compression are within tolerance."""
    last = 0.0
    before_last = 0.0
    for index in range(core.contacts.size):
        contact = core.contacts[index]
        last = max(last, abs(contact.compressions[ORDER]))
        before_last = max(before_last, abs(contact.compressions[ORDER - 1]))
        for axis in range(core.rows):
            last = max(last, abs(contact.impulses[axis, ORDER]))
            before_last = max(before_last, abs(contact.impulses[axis, ORDER - 1]))
    longest = math.inf
    if last > 0.0:
        longest = (core.tolerance / last) ** (1.0 / ORDER)
    if before_last > 0.0:
        longest = min(longest, (core.tolerance / before_last) ** (1.0 / (ORDER - 1)))
    for index in range(core.contacts.size):
        contact = core.contacts[index]
        if contact.phase == INACTIVE or contact.exponent == 1.0:
            continue
        if contact.compression < FOOT:
            longest = min(longest, _time_in_foot(contact.compressions, longest))
        else:
            longest = min(longest, FARTHEST * contact.compression / max(abs(contact.velocity[0]), 1e-300))
    return longest


@compiled
def _time_in_foot(series: Array, longest: float) -> float:
    """Time until a contact that has just begun may have grown to twice the foot."""
    time = min(longest, 1e3)
    while True:
        depth = 0.0
        for order in range(ORDER, -1, -1):
            depth = depth * time + abs(series[order])
        if depth <= 2.0 * FOOT:
            return time
        time *= 0.7
