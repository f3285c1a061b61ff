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
compiled: Callable[[Function], Function] = njit(
    cache=True, error_model="numpy", _nrt=False, no_cpython_wrapper=True, no_cfunc_wrapper=True
)
"""Compile a function to machine code on first call and keep the code on disk.

It goes without reference counts (`_nrt`), which cost more than the work; so it must not create arrays. Python
cannot call it: without wrappers for that, all of the engine compiles in two thirds of the time.
"""
compiled_entry: Callable[[Function], Function] = njit(cache=True, error_model="numpy", nogil=True)
"""The same for a function that creates arrays or is called from Python; it lets other threads run."""

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
        ("phase", np.int64),
        ("mode", np.int64),
        ("direction_1", np.float64),  # of sliding, along the two tangents
        ("direction_2", np.float64),
        ("onset", np.int64),  # order of the first term that moves a starting slide, -1 if not yet met
        ("compression", np.float64),  # δ
        ("rest_compression", np.float64),  # δ at which restitution ends
        ("first_impulse", np.float64),  # p_n when the contact became active
        ("last_impulse", np.float64),  # p_n at which restitution ends under Poisson's law
        ("energy_dropped", np.float64),  # lost where restitution ended
        ("friction_work", np.float64),  # turned into heat by sliding
    ]
)
"""One contact: first what it is, then how it fares."""

SQUARE, INVERSE, DIRECTION_1, DIRECTION_2, GROWTH, HEAT, SLIP_SERIES = range(7)
"""Series of one contact: ``|u_t|²``, ``1 / |u_t|``, unit vector of ``u_t``, ``d|u_t|/dσ``, friction work."""


class Core(NamedTuple):
    """One collision under way, n contacts of r rows each; the arrays are altered in place."""

    contacts: npt.NDArray[np.void]  # (n,) of dtype CONTACT
    delassus: Array  # (n r, n r) A
    velocity: Array  # (n r,) u now
    impulse: Array  # (n r,) p since the start of the collision
    opening: Array  # (n r,) p when the present state began
    compressions: Array  # (n, ORDER + 1) series of δ from now on
    velocities: Array  # (n r, ORDER + 1) series of u
    forces: Array  # (n r, ORDER + 1) series of dp/dσ
    impulses: Array  # (n r, ORDER + 1) series of Δp
    slips: Array  # (n, SLIP_SERIES, ORDER + 1) series of sliding; empty if r = 1
    held: Array  # (n r, n r) Cholesky factor that keeps the sticking contacts at rest; empty if r = 1
    rows: int  # r
    tolerance: float
    poisson: bool


@compiled
def elastic_energy(core: Core, index: int) -> float:
    """Energy ``k δ**(η+1) / (η+1)`` stored in one contact."""
    contact = core.contacts[index]
    power = contact.exponent + 1.0
    return float(contact.stiffness * max(contact.compression, 0.0) ** power / power)


@compiled
def value_at(series: Array, row: int, time: float) -> float:
    """Value of one series of a table at σ = `time`, by Horner's rule in four strands.

    The processor follows the strands side by side; one strand would wait for itself at every term.
    """
    fourth = (time * time) * (time * time)
    zeroth = series[row, ORDER]
    first = second = third = 0.0
    for order in range(ORDER - 4, -1, -4):
        third = third * fourth + series[row, order + 3]
        second = second * fourth + series[row, order + 2]
        first = first * fourth + series[row, order + 1]
        zeroth = zeroth * fourth + series[row, order]
    return float(zeroth + time * (first + time * (second + time * third)))


@compiled
def slope_at(series: Array, row: int, time: float) -> float:
    """Slope of one series of a table at σ = `time`, in the same way."""
    fourth = (time * time) * (time * time)
    zeroth = first = second = third = 0.0
    for order in range(ORDER - 4, -1, -4):
        third = third * fourth + (order + 4) * series[row, order + 4]
        second = second * fourth + (order + 3) * series[row, order + 3]
        first = first * fourth + (order + 2) * series[row, order + 2]
        zeroth = zeroth * fourth + (order + 1) * series[row, order + 1]
    return float(zeroth + time * (first + time * (second + time * third)))
