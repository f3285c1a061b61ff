"""The compiled core: what one collision is made of, and the rates at which it changes.

Everything here is in scaled units: the fastest approach is 1, the largest Delassus diagonal is 1, the
stiffest contact is 1, so every tolerance is a plain number. Evolution runs along the parameter σ with
``dδ/dσ = -u_n`` and ``dp_n/dσ = k δ**η``; dividing two such lines gives the paper's (10) and (21).

A *point* on the way lies in one row of `Core.work`: ``[δ (n) | Δp (n r) | friction work (n, if r = 3)]``,
with n contacts of r rows each and Δp counted from the last event.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar, cast

import numba
import numpy as np
import numpy.typing as npt

from impact._checks import Array
from impact.contact import ContactMode, Phase

Function = TypeVar("Function", bound=Callable[..., Any])

compiled = cast(Callable[[Function], Function], numba.njit(cache=True, error_model="numpy"))
"""Compile a function to machine code on first call and keep the code on disk."""
compiled_parallel = cast(
    Callable[[Function], Function], numba.njit(cache=True, parallel=True, error_model="numpy")
)
"""The same, with `parallel_range` loops spread over the threads."""
parallel_range: type[range] = numba.prange

INACTIVE, COMPRESSION, RESTITUTION = (int(phase) for phase in Phase)
FRICTIONLESS, STICKING, STARTING, SLIDING = (int(mode) for mode in ContactMode)
SPEED_FLOOR = 1e-13
"""A contact velocity this small counts as zero; it also keeps a grazing contact from chattering."""

CONTACT = np.dtype(
    [
        ("stiffness", np.float64),
        ("exponent", np.float64),
        ("friction", np.float64),
        ("restitution", np.float64),
        ("peak_stiffness", np.float64),  # steepest slope dF/dδ the contact may reach
        ("phase", np.int64),
        ("mode", np.int64),
        ("compression", np.float64),  # δ
        ("rest_compression", np.float64),  # δ at which restitution ends
        ("first_impulse", np.float64),  # p_n when the contact became active
        ("last_impulse", np.float64),  # p_n at which restitution ends under Poisson's law
        ("energy_dropped", np.float64),  # lost where restitution ended
        ("friction_work", np.float64),  # turned into heat by sliding
    ]
)
"""One contact: first what it is, then how it fares."""

SLOPES, DENSE = 0, 16
"""First of the 16 rows of stage slopes and of the 7 rows of dense coefficients in `Core.work`."""
POINT, END, TRIAL, RATES, VELOCITY, OPENING, STEP, WORK_ROWS = range(23, 31)
"""Start, end and inside of a step; rates and u last looked at; p when the state began; the next step."""


class Core(NamedTuple):
    """One collision under way; the arrays are altered in place."""

    contacts: npt.NDArray[np.void]  # (n,) of dtype CONTACT
    delassus: Array  # (n r, n r) A
    velocity: Array  # (n r,) u at the last event
    impulse: Array  # (n r,) p since the start of the collision
    work: Array  # (WORK_ROWS, size of a point)
    rows: int  # r
    tolerance: float
    poisson: bool


@compiled
def normal_force(stiffness: float, exponent: float, compression: float) -> float:
    """Force ``k δ**η`` of the virtual spring; a spring never pulls."""
    if compression <= 0.0:
        return 0.0
    if exponent == 1.0:
        return stiffness * compression
    if exponent == 1.5:
        return stiffness * compression * math.sqrt(compression)
    return float(stiffness * compression**exponent)


@compiled
def elastic_energy(core: Core, index: int) -> float:
    """Energy ``k δ**(η+1) / (η+1)`` stored in one contact."""
    contact = core.contacts[index]
    force = normal_force(contact.stiffness, contact.exponent, contact.compression)
    return float(force * contact.compression / (contact.exponent + 1.0))


@compiled
def load_point(core: Core, row: int) -> None:
    """Write the present state as a point: its compressions, and no change yet."""
    core.work[row, :] = 0.0
    for index in range(core.contacts.size):
        core.work[row, index] = core.contacts[index].compression


@compiled
def contact_velocity(core: Core, source: int) -> None:
    """Write ``u = u⁽⁰⁾ + A Δp`` at a point into row VELOCITY (5, 6, 18)."""
    work = core.work
    count = core.contacts.size
    for row in range(core.velocity.size):
        total = core.velocity[row]
        for column in range(core.velocity.size):
            total += core.delassus[row, column] * work[source, count + column]
        work[VELOCITY, row] = total


@compiled
def acceleration(core: Core, row: int, rates: int) -> float:
    """Rate of change of row `row` of u, given the row of `work` that holds the rates of a point."""
    total = 0.0
    for column in range(core.velocity.size):
        total += core.delassus[row, column] * core.work[rates, core.contacts.size + column]
    return total


@compiled
def rates_at(core: Core, source: int, target: int) -> None:
    """Write the rates of change at a point into row `target`, and u into row VELOCITY."""
    work = core.work
    count = core.contacts.size
    contact_velocity(core, source)
    for column in range(work.shape[1]):
        work[target, column] = 0.0
    for index in range(count):
        contact = core.contacts[index]
        if contact.phase != INACTIVE:
            row = index * core.rows
            work[target, index] = -work[VELOCITY, row]
            work[target, count + row] = normal_force(contact.stiffness, contact.exponent, work[source, index])
