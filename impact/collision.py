"""What came out of a collision, state by state."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from impact._checks import Array
from impact.contact import ContactMode, Event, RestitutionLaw
from impact.notebook import html_table
from impact.system import ImpactSystem

if TYPE_CHECKING:
    from impact.record import Record
    from impact.scaling import Tasks

EVENT_LETTERS = tuple(event.value for event in Event)


class ConvergenceError(RuntimeError):
    """A collision that did not end.

    Attributes
    ----------
    partial : Collision or ShotOutcome
        What had happened when the run was given up.
    """

    def __init__(self, message: str, partial: Any) -> None:
        super().__init__(message)
        self.partial = partial


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class Segment:
    """The stretch of a collision inside one state.

    Attributes
    ----------
    state : str
        Name of the state.
    events : str
        What happened, in order: C compression ended, R restitution ended, A a contact became active again,
        each with its contact counted from 1, as in ``"C2-C1-R2"``.
    impulses : (samples, n) array
        Normal impulses since the start of the collision, N s.
    tangential_impulses : (samples, n, r - 1) array
        Friction impulses along the contacts' tangents, N s.
    elastic_energies : (samples, n) array
        Energy stored in each contact, J.
    modes : tuple of n tuples of ContactMode
        Per contact the modes it went through; empty where it was not active.
    """

    state: str
    events: str
    impulses: Array
    tangential_impulses: Array
    elastic_energies: Array
    modes: tuple[tuple[ContactMode, ...], ...]

    def __repr__(self) -> str:
        ends = ", ".join(f"{impulse:.6g}" for impulse in self.impulses[-1])
        return f"<Segment {self.state}: {self.events or 'no event'}, impulses to ({ends}) N s>"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class Collision:
    """Outcome of a collision.

    Attributes
    ----------
    system : ImpactSystem
        What collided.
    law : RestitutionLaw
        Law that ended restitution.
    velocities : (d,) array
        Generalized velocity after the collision, in the order of `system.velocity`.
    impulses : (n,) array
        Normal impulse of each contact, N s.
    tangential_impulses : (n, r - 1) array
        Friction impulse of each contact along its tangents, N s.
    states : tuple of str
        Names of the states in order.
    energy_loss : float
        Kinetic energy before minus after, J.
    energy_dropped : (n,) array
        Energy lost at each contact where restitution ended, J. Under Poisson's law it may be negative.
    friction_work : (n,) array
        Energy turned into heat by sliding at each contact, J.
    """

    system: ImpactSystem
    law: RestitutionLaw
    velocities: Array
    impulses: Array
    tangential_impulses: Array
    states: tuple[str, ...]
    energy_loss: float
    energy_dropped: Array
    friction_work: Array
    tasks: Tasks
    records: Record

    @classmethod
    def from_run(cls, system: ImpactSystem, law: RestitutionLaw, tasks: Tasks, records: Record) -> Collision:
        """Read the outcome from the notes of a run of one task."""
        count = len(system.contacts)
        impulse = tasks.impulse[0]
        by_contact = impulse.reshape(count, -1)
        jacobian = system.jacobian.reshape(impulse.size, -1)
        return cls(
            system=system,
            law=law,
            velocities=system.velocity + system.inverse_mass @ (jacobian.T @ impulse),
            impulses=by_contact[:, 0],
            tangential_impulses=by_contact[:, 1:],
            states=tuple(_state_names(system, records)),
            energy_loss=float(-impulse @ (tasks.velocity[0] + 0.5 * tasks.delassus[0] @ impulse)),
            energy_dropped=tasks.contacts["energy_dropped"][0],
            friction_work=tasks.contacts["friction_work"][0],
            tasks=tasks,
            records=records,
        )

    @property
    def energy_borrowed(self) -> float:
        """Energy that Poisson's law took without its being stored, J; zero under the energy law."""
        return float(np.maximum(-self.energy_dropped, 0.0).sum())

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The stretch inside each state, in order."""
        return tuple(self._segment(index, name) for index, name in enumerate(self.states))

    def _segment(self, index: int, name: str) -> Segment:
        count = len(self.system.contacts)
        _, impulse_unit, length_unit = self.tasks.units[0]
        start, stop = self.records.states[0, index, :2]
        samples = self.records.samples[0, start:stop]
        impulses = (samples[:, 2 * count :] * impulse_unit).reshape(len(samples), count, -1)
        stiffness = np.array([contact.stiffness for contact in self.system.contacts])
        exponent = np.array([contact.exponent for contact in self.system.contacts])
        depths = np.maximum(samples[:, :count], 0.0) * length_unit
        energy = stiffness * depths ** (exponent + 1.0) / (exponent + 1.0)
        return Segment(
            state=name,
            events=_events(self.records, index),
            impulses=impulses[:, :, 0],
            tangential_impulses=impulses[:, :, 1:],
            elastic_energies=energy,
            modes=tuple(_modes(samples[:, count + contact]) for contact in range(count)),
        )

    def __repr__(self) -> str:
        velocities = ", ".join(f"{velocity:.6g}" for velocity in self.velocities)
        noun = "state" if len(self.states) == 1 else "states"
        shown = " ".join(self.states[:12]) + (" ..." if len(self.states) > 12 else "")
        text = f"velocities {velocities} in {noun} {shown or 'none'}; energy loss {self.energy_loss:.6g} J"
        if self.energy_borrowed > 1e-9 * abs(self.energy_loss):
            text += f"; the law borrowed {self.energy_borrowed:.6g} J that no contact had stored"
        return text

    def _repr_html_(self) -> str:
        """Show each state, its events and the impulses at its end."""
        ends = [", ".join(f"{impulse:.6g}" for impulse in each.impulses[-1]) for each in self.segments[:12]]
        rows = [(each.state, each.events, end) for each, end in zip(self.segments[:12], ends, strict=True)]
        return html_table(repr(self), rows, ("state", "events", "impulses, N s"))


def _state_names(system: ImpactSystem, records: Record) -> Iterator[str]:
    for row in records.states[0, : records.counts[0, 0], 2:].tolist():
        active = [index for index, flag in enumerate(row) if flag]
        unnamed = "{" + ",".join(str(index + 1) for index in active) + "}"
        yield system.state_names.get(frozenset(active), unnamed)


def _events(records: Record, state: int) -> str:
    noted = records.events[0, : records.counts[0, 2]]
    first, last = np.searchsorted(noted[:, 0], [state, state + 1])
    return "-".join(f"{EVENT_LETTERS[code]}{contact + 1}" for _, code, contact in noted[first:last].tolist())


def _modes(codes: Array) -> tuple[ContactMode, ...]:
    """Modes in the order they were met, each once in a row."""
    if not len(codes) or codes[0] < 0:
        return ()
    changes = np.flatnonzero(np.diff(codes)) + 1
    return tuple(ContactMode(int(code)) for code in codes[np.concatenate([[0], changes])])
