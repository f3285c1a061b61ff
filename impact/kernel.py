"""The compiled core: what one collision is made of, and the equations it obeys.

Everything here is in scaled units: the fastest approach is 1, the largest Delassus diagonal is 1, the
stiffest contact is 1, so every tolerance is a plain number. Evolution runs along the parameter σ with
``dδ/dσ = -u_n`` and ``dp_n/dσ = k δ**η``; dividing two such lines gives the paper's (10) and (21).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import numba
import numpy as np
import numpy.typing as npt

from impact._checks import Array
from impact.contact import ContactMode, Phase

Function = TypeVar("Function", bound=Callable[..., Any])

njit: Any = numba.njit  # its stubs do not know `_nrt`
OPTIONS = {
    "cache": True,
    "error_model": "numpy",
    "_nrt": False,
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}
compiled: Callable[[Function], Function] = njit(**OPTIONS)
"""Compile a function to machine code on first call and keep the code on disk.

It goes without reference counts (`_nrt`), which cost more than the work; so it must not create arrays. Python
cannot call it: without wrappers for that, all of the engine compiles in two thirds of the time.

What is kept is renewed when the function's own file changes, not when a function changes that it calls: after
an edit delete all `*.nbi` and `*.nbc` beside this file, or old and new code run together.
"""
inlined: Callable[[Function], Function] = njit(forceinline=True, **OPTIONS)
"""The same for a small function that is called so often that the call itself would cost most."""
merged: Callable[[Function], Function] = njit(inline="always", **OPTIONS)
"""The same for a function with one caller, into which it is written.

Machine code is made anew for a function with all that it calls, so a chain of five costs five times the end.
"""
compiled_entry: Callable[[Function], Function] = njit(cache=True, error_model="numpy", nogil=True)
"""The same for a function that Python calls; it lets other threads run."""

INACTIVE, COMPRESSION, RESTITUTION = (int(phase) for phase in Phase)
FRICTIONLESS, STICKING, STARTING, SLIDING = (int(mode) for mode in ContactMode)
SPEED_FLOOR = 1e-13
"""A contact velocity this small counts as zero; it also keeps a grazing contact from chattering."""
ORDER = 20
"""Order of the Taylor series; a step at tolerance 1e-12 then spans about two radians of the oscillation.

A multiple of four, for `value_at`.
"""

CONTACT = np.dtype(
    [
        ("stiffness", np.float64),
        ("exponent", np.float64),
        ("friction", np.float64),
        ("restitution", np.float64),
        ("energy_dropped", np.float64),  # lost where restitution ended
        ("friction_work", np.float64),  # turned into heat by sliding
    ]
)
"""What one contact is, and what the collision made of it."""

TERMS = ORDER + 1
SQUARE, INVERSE, DIRECTION_1, DIRECTION_2, GROWTH, HEAT, SLIP_SERIES = range(7)
"""Series of a slide: ``|u_t|²``, ``1 / |u_t|``, unit vector of ``u_t``, ``d|u_t|/dσ``, friction work."""

LIVE = np.dtype(
    [
        *((name, np.float64) for name in CONTACT.names or ()),
        ("phase", np.int64),
        ("mode", np.int64),
        ("direction_1", np.float64),  # of sliding, along the two tangents
        ("direction_2", np.float64),
        ("onset", np.int64),  # order of the first term that moves a starting slide, -1 if not yet met
        ("slowest", np.float64),  # slip velocity that is as good as none
        ("compression", np.float64),  # δ
        ("rest_compression", np.float64),  # δ at which restitution ends
        ("first_impulse", np.float64),  # p_n when the contact became active
        ("last_impulse", np.float64),  # p_n at which restitution ends under Poisson's law
        ("velocity", np.float64, (3,)),  # u now: along the normal, then along the two tangents
        ("impulse", np.float64, (3,)),  # p since the start of the collision
        ("opening", np.float64, (3,)),  # p when the present state began
        ("compressions", np.float64, (TERMS,)),  # series of δ from now on
        ("velocities", np.float64, (3, TERMS)),  # series of u
        ("forces", np.float64, (3, TERMS)),  # series of dp/dσ
        ("impulses", np.float64, (3, TERMS)),  # series of Δp
        ("slips", np.float64, (SLIP_SERIES, TERMS)),
    ]
)
"""One contact under way. It holds all that is known of it, so that most functions need nothing else."""

Contact = Any
"""One record of dtype `LIVE`."""


class Core(NamedTuple):
    """One collision under way, n contacts of r rows each; the arrays are altered in place."""

    contacts: npt.NDArray[np.void]  # (n,) of dtype LIVE
    delassus: Array  # (n r, n r) A
    held: Array  # (n r, n r) Cholesky factor that keeps the sticking contacts at rest; unused if r = 1
    rows: int  # r
    tolerance: float
    poisson: bool


@compiled
def elastic_energy(contact: Contact) -> float:
    """Energy ``k δ**(η+1) / (η+1)`` stored in a contact."""
    power = contact.exponent + 1.0
    return float(contact.stiffness * max(contact.compression, 0.0) ** power / power)


@inlined
def value_at(series: Array, time: float) -> float:
    """Value of a series at σ = `time`, by Horner's rule in four strands.

    The processor follows the strands side by side; one strand would wait for itself at every term.
    """
    fourth = (time * time) * (time * time)
    zeroth = series[ORDER]
    first = second = third = 0.0
    for order in range(ORDER - 4, -1, -4):
        third = third * fourth + series[order + 3]
        second = second * fourth + series[order + 2]
        first = first * fourth + series[order + 1]
        zeroth = zeroth * fourth + series[order]
    return float(zeroth + time * (first + time * (second + time * third)))


@inlined
def slope_at(series: Array, time: float) -> float:
    """Slope of a series at σ = `time`, in the same way."""
    fourth = (time * time) * (time * time)
    zeroth = first = second = third = 0.0
    for order in range(ORDER - 4, -1, -4):
        third = third * fourth + (order + 4) * series[order + 4]
        second = second * fourth + (order + 3) * series[order + 3]
        first = first * fourth + (order + 2) * series[order + 2]
        zeroth = zeroth * fourth + (order + 1) * series[order + 1]
    return float(zeroth + time * (first + time * (second + time * third)))


@inlined
def acceleration(core: Core, row: int, order: int) -> float:
    """Term of ``du/dσ = A dp/dσ`` for one row, by the same term of all forces."""
    total = 0.0
    column = 0
    for index in range(core.contacts.size):
        contact = core.contacts[index]
        if contact.phase != INACTIVE:
            total += core.delassus[row, column] * contact.forces[0, order]
            if core.rows > 1:  # written out, because nothing is done more often
                total += core.delassus[row, column + 1] * contact.forces[1, order]
                total += core.delassus[row, column + 2] * contact.forces[2, order]
        column += core.rows
    return total


@compiled
def push(core: Core, row: int, impulse: float) -> None:
    """Give an impulse at once along one row, and to all contacts the velocity that follows from it."""
    core.contacts[row // core.rows].impulse[row % core.rows] += impulse
    column = 0
    for index in range(core.contacts.size):
        contact = core.contacts[index]
        for axis in range(core.rows):
            contact.velocity[axis] += core.delassus[column, row] * impulse
            column += 1
