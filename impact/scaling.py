"""From SI units to the kernel's own, and back.

Speeds are measured by the fastest approach, impulses by that speed over the largest Delassus diagonal, and
compressions so that the stiffest contact gets stiffness 1. With one exponent for all contacts only stiffness
ratios survive (Theorem 1), and nothing depends on the approach velocity but as a factor (Theorem 4).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from impact._checks import Array
from impact.contact import Contact, RestitutionLaw
from impact.kernel import CONTACT, FRICTIONLESS, INACTIVE, LIVE, Core, compiled

Contacts = npt.NDArray[np.void]

MOST_STATES = 20_000
"""A run is given up after so many states; a jammed cue was seen to need a thousand."""


class Tasks(NamedTuple):
    """N collisions of n contacts with r rows each, in SI units; what a run fills in stands last."""

    delassus: Array  # (N, n r, n r) A
    velocity: Array  # (N, n r) u before the collision
    tolerance: float
    poisson: bool
    most_states: int
    contacts: Contacts  # (N, n) of dtype CONTACT; sums of energy are filled in
    impulse: Array  # (N, n r) p
    units: Array  # (N, 3) of speed, impulse, compression
    status: npt.NDArray[np.int64]  # (N,) how the run ended


def contact_table(contacts: Sequence[Contact]) -> Contacts:
    """Write contacts as records of the kernel."""
    table = np.zeros(len(contacts), CONTACT)
    for field in ("stiffness", "exponent", "friction", "restitution"):
        table[field] = [getattr(contact, field) for contact in contacts]
    return table


def new_tasks(
    contacts: Contacts, delassus: Array, velocity: Array, law: RestitutionLaw, tolerance: float
) -> Tasks:
    """Lay out tasks; `contacts` is copied, because a run writes into it."""
    return Tasks(
        np.ascontiguousarray(delassus),
        np.ascontiguousarray(velocity),
        tolerance,
        law is RestitutionLaw.POISSON,
        MOST_STATES,
        contacts.copy(),
        np.zeros_like(velocity),
        np.ones((len(velocity), 3)),
        np.zeros(len(velocity), np.int64),
    )


@compiled
def scale(tasks: Tasks, row: int) -> None:
    """Choose the units of one task and scale its stiffnesses."""
    contacts = tasks.contacts[row]
    rows = tasks.velocity.shape[1] // contacts.size
    speed = 0.0
    response = 0.0
    for index in range(contacts.size):
        speed = max(speed, -tasks.velocity[row, index * rows])
        response = max(response, tasks.delassus[row, index * rows, index * rows])
    if speed == 0.0:
        speed = 1.0  # nothing approaches, so nothing will happen
    energy = speed * speed / response
    length = np.inf
    for index in range(contacts.size):  # depth at which the stiffest contact stores this energy, or twice it
        power = contacts[index].exponent + 1.0
        length = min(length, (energy / contacts[index].stiffness) ** (1.0 / power))
    for index in range(contacts.size):
        contacts[index].stiffness *= length ** (contacts[index].exponent + 1.0) / energy
    tasks.units[row, 0] = speed
    tasks.units[row, 1] = speed / response
    tasks.units[row, 2] = length


def new_core(tasks: Tasks) -> Core:
    """Room for one collision under way; `load` fills it."""
    count = tasks.contacts.shape[1]
    size = tasks.velocity.shape[1]
    return Core(
        np.zeros(count, LIVE),
        np.zeros((size, size)),
        np.zeros((size, size)),
        size // count,
        tasks.tolerance,
        tasks.poisson,
    )


@compiled
def load(tasks: Tasks, row: int, core: Core) -> None:
    """Set the core to the start of one task, in scaled units."""
    speed, impulse = tasks.units[row, 0], tasks.units[row, 1]
    size = tasks.velocity.shape[1]
    fastest = 1.0
    for one in range(size):
        fastest = max(fastest, abs(tasks.velocity[row, one]) / speed)
        for other in range(size):
            core.delassus[one, other] = tasks.delassus[row, one, other] * (impulse / speed)
    for index in range(core.contacts.size):
        contact, given = core.contacts[index], tasks.contacts[row, index]
        contact.stiffness = given.stiffness
        contact.exponent = given.exponent
        contact.friction = given.friction
        contact.restitution = given.restitution
        contact.energy_dropped = 0.0
        contact.friction_work = 0.0
        contact.phase = INACTIVE
        contact.mode = FRICTIONLESS
        contact.slowest = core.tolerance * fastest
        contact.compression = 0.0
        contact.last_impulse = np.inf
        for axis in range(core.rows):
            contact.velocity[axis] = tasks.velocity[row, index * core.rows + axis] / speed
            contact.impulse[axis] = 0.0


@compiled
def settle_accounts(tasks: Tasks, row: int, core: Core) -> None:
    """Write impulses and energies back in SI units."""
    energy = tasks.units[row, 0] * tasks.units[row, 1]
    for index in range(core.contacts.size):
        contact, given = core.contacts[index], tasks.contacts[row, index]
        given.energy_dropped = contact.energy_dropped * energy
        given.friction_work = contact.friction_work * energy
        for axis in range(core.rows):
            tasks.impulse[row, index * core.rows + axis] = contact.impulse[axis] * tasks.units[row, 1]
