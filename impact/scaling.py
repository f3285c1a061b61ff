"""From SI units to the kernel's own, and back.

Speeds are measured by the fastest approach, impulses by that speed over the largest Delassus diagonal, and
compressions so that the stiffest contact gets stiffness 1. With one exponent for all contacts only stiffness
ratios survive (Theorem 1), and nothing depends on the approach velocity but as a factor (Theorem 4).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from impact._checks import Array
from impact.contact import RestitutionLaw
from impact.kernel import CONTACT, ORDER, SLIP_SERIES, Core, compiled, compiled_allocating

if TYPE_CHECKING:
    from impact.system import ImpactSystem


class Task(NamedTuple):
    """One collision in SI units; impulse, units and the sums in `contacts` are filled in by the run."""

    contacts: npt.NDArray[np.void]  # (n,) of dtype CONTACT
    delassus: Array  # (n r, n r)
    velocity: Array  # (n r,) u before the collision
    impulse: Array  # (n r,) p
    units: Array  # (3,) of speed, impulse, compression
    tolerance: float
    poisson: bool


def new_task(system: ImpactSystem, law: RestitutionLaw, tolerance: float) -> Task:
    """Reduce a system to its contacts: A = J M⁻¹ Jᵀ and u = J v."""
    rows = system.jacobian.reshape(-1, system.velocity.size)
    contacts = np.zeros(len(system.contacts), CONTACT)
    for record, contact in zip(contacts, system.contacts, strict=True):
        record["stiffness"] = contact.stiffness
        record["exponent"] = contact.exponent
        record["friction"] = contact.friction
        record["restitution"] = contact.restitution
    return Task(
        contacts,
        rows @ system.inverse_mass @ rows.T,
        rows @ system.velocity,
        np.zeros(len(rows)),
        np.ones(3),
        tolerance,
        law is RestitutionLaw.POISSON,
    )


@compiled_allocating
def new_core(task: Task) -> Core:
    """Scale a task and lay out what the kernel works on."""
    count = task.contacts.size
    rows = task.velocity.size // count
    speed = 0.0
    response = 0.0
    for index in range(count):
        speed = max(speed, -task.velocity[index * rows])
        response = max(response, task.delassus[index * rows, index * rows])
    if speed == 0.0:
        speed = 1.0  # nothing approaches, so nothing will happen
    task.units[0] = speed
    task.units[1] = speed / response
    task.units[2] = _length_unit(task, speed * speed / response)
    for contact in task.contacts:
        contact.stiffness *= task.units[2] ** (contact.exponent + 1.0) * response / speed**2
    size = task.velocity.size
    tangents = count if rows > 1 else 0
    return Core(
        task.contacts,
        task.delassus / response,
        task.velocity / speed,
        np.zeros(size),
        np.zeros(size),
        np.zeros((count, ORDER + 1)),
        np.zeros((size, ORDER + 1)),
        np.zeros((size, ORDER + 1)),
        np.zeros((size, ORDER + 1)),
        np.zeros((tangents, SLIP_SERIES, ORDER + 1)),
        np.zeros((tangents * 3, tangents * 3)),
        rows,
        task.tolerance,
        task.poisson,
    )


@compiled
def _length_unit(task: Task, energy: float) -> float:
    """Smallest compression at which a contact would store `energy` (up to a factor)."""
    length = np.inf
    for contact in task.contacts:
        length = min(length, (energy / contact.stiffness) ** (1.0 / (contact.exponent + 1.0)))
    return length


@compiled
def settle_accounts(task: Task, core: Core) -> None:
    """Write impulses and energies back in SI units."""
    energy_unit = task.units[0] * task.units[1]
    for row in range(task.impulse.size):
        task.impulse[row] = core.impulse[row] * task.units[1]
    for index in range(task.contacts.size):
        contact = task.contacts[index]
        contact.energy_dropped *= energy_unit
        contact.friction_work *= energy_unit
