"""The state transition diagram: evolve, make the transition, until no contact is active.

Read `follow_diagram` first; it is the whole algorithm. What happens inside a state is in `evolve`, what
happens between two states in `transition`, and the equations both rest on in `kernel`.
"""

from __future__ import annotations

from typing import Protocol, TypeVar

import numpy as np

from impact._checks import require_within
from impact.collision import Collision, ConvergenceError
from impact.contact import RestitutionLaw
from impact.evolve import evolve
from impact.kernel import Core, compiled_entry, merged
from impact.record import STATES, Record, Room, new_records, open_state, room_needed
from impact.scaling import (
    MOST_STATES,
    Tasks,
    contact_table,
    load,
    new_core,
    new_tasks,
    scale,
    settle_accounts,
)
from impact.system import ImpactSystem
from impact.transition import engage, transition

FINISHED, EXHAUSTED, STALLED, RUNAWAY = 0, 1, 2, 3
MOST_ROUNDS = 10_000
"""Events in one state, after which a run is given up."""
MOST_BORROWED = 1e6
"""Energy that Poisson's law may make at a contact, over that of the approach."""
REASONS = {
    EXHAUSTED: f"more than {MOST_STATES} states",
    STALLED: "a state that does not end",
    RUNAWAY: "Poisson's law makes energy without bound here",
}

Outcome = TypeVar("Outcome", covariant=True)


class Scene(Protocol[Outcome]):
    """What `collide` can run: anything that knows its system and how to present its collision."""

    def system(self) -> ImpactSystem:
        """Return the bodies and contacts."""

    def outcome(self, collision: Collision) -> Outcome:
        """Present the collision in the scene's own words."""


@merged
def follow_diagram(core: Core, record: Record, most_states: int) -> int:
    """Run a collision from first contact to last; say how it ended."""
    state, rounds = 0, 0
    while engage(core):
        rounds = 0 if record.counts[STATES] > state else rounds + 1
        state = record.counts[STATES]
        if state >= most_states:
            return EXHAUSTED
        open_state(core, record)
        if rounds > MOST_ROUNDS or not evolve(core, record):
            return STALLED
        transition(core, record)
        for index in range(core.contacts.size):
            if core.contacts[index].energy_dropped < -MOST_BORROWED:
                return RUNAWAY
    return FINISHED


@compiled_entry
def run(tasks: Tasks, records: Record, core: Core, first: int, last: int) -> None:
    """Run tasks `first` up to `last` in one core; results go into `tasks`, notes into `records`."""
    for row in range(first, last):
        record = Record(records.counts[row], records.states[row], records.events[row], records.samples[row])
        scale(tasks, row)
        load(tasks, row, core)
        tasks.status[row] = follow_diagram(core, record, tasks.most_states)
        settle_accounts(tasks, row, core)


def collide(
    scene: Scene[Outcome],
    *,
    law: RestitutionLaw = RestitutionLaw.ENERGY,
    rtol: float = 1e-13,
) -> Outcome:
    """Let bodies collide at several contacts at once.

    Parameters
    ----------
    scene : TwoBallDrop, BallColumn, BallChain, CueShot or ImpactSystem
        What collides.
    law : RestitutionLaw
        When a contact ends: by energy (the paper's law) or by Poisson's impulses.
    rtol : float
        Error allowed in one step, relative to the fastest approach, within [1e-14, 1e-3]; the outcome is
        about a hundred times less exact where friction stops a slide.

    Returns
    -------
    Collision or ShotOutcome
        Velocities after the collision and how they came about. A `CueShot` gives a `ShotOutcome`.

    Raises
    ------
    ConvergenceError
        If the collision does not end; its `partial` holds what happened so far.

    Examples
    --------
    Figure 4 of the paper:

    >>> from impact import Ball, Contact, TwoBallDrop
    >>> ball = Ball(mass=1.0, radius=0.02)
    >>> drop = TwoBallDrop(upper=ball, lower=ball, approach_velocity=-3.0,
    ...                    ball_ball=Contact(restitution=0.9**0.5),
    ...                    ball_table=Contact(restitution=0.4**0.5, stiffness=10.0))
    >>> outcome = collide(drop)
    >>> outcome.states
    ('S1', 'S3', 'S1', 'S2')
    >>> outcome.velocities.round(6).tolist()
    [2.44136, 0.735552]
    """
    require_within("rtol", rtol, 1e-14, 1e-3)
    system = scene.system()
    rows = system.jacobian.reshape(-1, system.velocity.size)
    contacts = contact_table(system.contacts)[np.newaxis]
    delassus = (rows @ system.inverse_mass @ rows.T)[np.newaxis]
    room = Room(states=8, events=32, samples=512)
    while True:
        tasks = new_tasks(contacts, delassus, (rows @ system.velocity)[np.newaxis], law, rtol)
        records = new_records(1, len(system.contacts), len(rows), room)
        run(tasks, records, new_core(tasks), 0, 1)
        needed = room_needed(records, room)
        if needed == room:
            break
        room = needed
    collision = Collision.from_run(system, law, tasks, records)
    outcome = scene.outcome(collision)
    if tasks.status[0] != FINISHED:
        raise ConvergenceError(f"the collision did not end: {REASONS[int(tasks.status[0])]}", outcome)
    return outcome
