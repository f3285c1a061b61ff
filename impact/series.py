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
from impact.kernel import INACTIVE, ORDER, Core, compiled

FOOT = 1e-5
"""Below this depth a Hertzian spring is taken as linear, since ``δ**1.5`` has no series at δ = 0.

The energy stored there is less than 1e-12 of the whole, so no outcome feels it.
"""


@compiled
def expand(core: Core) -> None:
    """Write the series of compression, force, impulse and velocity from the present state on."""
    _load(core)
    count = core.contacts.size
    rows = core.rows
    for order in range(ORDER):
        for index in range(count):
            contact = core.contacts[index]
            if contact.phase != INACTIVE:
                core.forces[index * rows, order] = _force_term(core, index, order)
                core.compressions[index, order + 1] = -core.velocities[index * rows, order] / (order + 1)
        if rows > 1:
            friction_terms(core, order)
        for row in range(core.velocity.size):
            core.impulses[row, order + 1] = core.forces[row, order] / (order + 1)
        for row in range(core.velocity.size):
            total = 0.0
            for column in range(core.velocity.size):
                total += core.delassus[row, column] * core.impulses[column, order + 1]
            core.velocities[row, order + 1] = total


@compiled
def _load(core: Core) -> None:
    """Set the terms of order 0, and all others to zero."""
    core.compressions[:, :] = 0.0
    core.velocities[:, :] = 0.0
    core.forces[:, :] = 0.0
    core.impulses[:, :] = 0.0
    core.slips[:, :, :] = 0.0
    for index in range(core.contacts.size):
        core.compressions[index, 0] = core.contacts[index].compression
        core.contacts[index].onset = -1
    for row in range(core.velocity.size):
        core.velocities[row, 0] = core.velocity[row]


@compiled
def spring_force(core: Core, index: int, depth: float) -> float:
    """Force ``k δ**η`` of the virtual spring at a depth."""
    contact = core.contacts[index]
    if contact.exponent == 1.0:
        return float(contact.stiffness * depth)
    if depth < FOOT:
        return float(contact.stiffness * FOOT ** (contact.exponent - 1.0) * depth)
    return float(contact.stiffness * depth**contact.exponent)


@compiled
def _force_term(core: Core, index: int, order: int) -> float:
    """One term of the normal force."""
    contact = core.contacts[index]
    term = core.compressions[index, order]
    if order == 0:
        return spring_force(core, index, term)
    if contact.exponent == 1.0:
        return float(contact.stiffness * term)
    if core.compressions[index, 0] < FOOT:
        return float(contact.stiffness * FOOT ** (contact.exponent - 1.0) * term)
    return _power_term(core.compressions[index], core.forces[index * core.rows], contact.exponent, order)


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
    longest = math.inf
    for row in range(core.velocity.size):
        longest = min(longest, _reach(core.impulses[row], core.tolerance))
    for index in range(core.contacts.size):
        longest = min(longest, _reach(core.compressions[index], core.tolerance))
    for index in range(core.contacts.size):
        contact = core.contacts[index]
        if contact.phase != INACTIVE and contact.exponent != 1.0 and contact.compression < FOOT:
            longest = min(longest, _time_in_foot(core.compressions[index], longest))
    return longest


@compiled
def _reach(series: Array, tolerance: float) -> float:
    reach = math.inf
    for order in (ORDER - 1, ORDER):
        term = abs(series[order])
        if term > 0.0:
            reach = min(reach, (tolerance / term) ** (1.0 / order))
    return reach


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
