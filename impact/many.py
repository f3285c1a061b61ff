"""Thousands of collisions in one call: the same diagram, spread over rows and threads."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple, overload

import numpy as np
import numpy.typing as npt

from impact._checks import Array, require_within
from impact.batches import Batch, drop_batch, shot_batch
from impact.collision import ConvergenceError
from impact.contact import RestitutionLaw
from impact.diagram import FINISHED, run
from impact.drop import TwoBallDrop
from impact.kernel import compiled_allocating, compiled_parallel, parallel_range
from impact.record import STATES, Integers, Record
from impact.scaling import Task
from impact.shot import CueShot
from impact.system import TWO_CONTACT_STATES

MOST_STATES = 20_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ManyDrops:
    """Outcomes of N two-ball drops.

    Attributes
    ----------
    velocities : (N, 2) array
        Upper, then lower ball, m/s, up positive.
    states : sequence of N tuples of str
        Names of the states of each row.
    """

    velocities: Array
    states: Sequence[tuple[str, ...]]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ManyShots:
    """Outcomes of N cue shots.

    Attributes
    ----------
    velocity : (N, 3) array
        Of the ball's centre, m/s.
    angular_velocity : (N, 3) array
        Of the ball, rad/s.
    cue_speed : (N,) array
        Velocity of the cue along its original direction, m/s.
    states : sequence of N tuples of str
        Names of the states of each row.
    """

    velocity: Array
    angular_velocity: Array
    cue_speed: Array
    states: Sequence[tuple[str, ...]]


@overload
def collide_many(
    template: TwoBallDrop,
    *,
    law: RestitutionLaw = ...,
    rtol: float = ...,
    **parameters: npt.ArrayLike,
) -> ManyDrops: ...


@overload
def collide_many(
    template: CueShot,
    *,
    law: RestitutionLaw = ...,
    rtol: float = ...,
    **parameters: npt.ArrayLike,
) -> ManyShots: ...


def collide_many(
    template: TwoBallDrop | CueShot,
    *,
    law: RestitutionLaw = RestitutionLaw.ENERGY,
    rtol: float = 1e-12,
    **parameters: npt.ArrayLike,
) -> ManyDrops | ManyShots:
    """Run one scene for arrays of parameters.

    Parameters
    ----------
    template : TwoBallDrop or CueShot
        Gives every value that is not varied.
    law, rtol
        As in `collide`.
    **parameters : float, (N,) array, or (N, 3) array for vectors
        Values to vary, broadcast against each other. For drops: `upper_mass`, `lower_mass`,
        `ball_ball_restitution`, `ball_table_restitution`, `ball_ball_exponent`, `ball_table_exponent`,
        `stiffness_ratio` and `approach_velocity`. For shots: `normal`, `cue_velocity`, `ball_mass`,
        `cue_mass`, `tip_ball_restitution`, `tip_ball_friction`, `tip_ball_exponent`,
        `ball_table_restitution`, `ball_table_friction`, `ball_table_exponent` and `stiffness_ratio`. The
        ratio is always lower contact over upper: k₂/k₁ for the drop, k_bt/k_cb for the shot.

    Returns
    -------
    ManyDrops or ManyShots
        Velocities and states, row by row the same as `collide` gives.

    Raises
    ------
    TypeError
        If a parameter has no such name; the message lists those there are.
    ValueError
        If a value breaks its rule.
    ConvergenceError
        If a collision does not end; its `partial` holds the result with that row.

    Examples
    --------
    >>> from impact import Ball, Contact
    >>> ball = Ball(mass=0.0027, radius=0.020)
    >>> drop = TwoBallDrop(upper=ball, lower=ball, approach_velocity=-1.0,
    ...                    ball_ball=Contact(restitution=0.807755), ball_table=Contact(restitution=0.846529))
    >>> many = collide_many(drop, stiffness_ratio=[1.0, 10.0])
    >>> many.velocities.round(6).tolist()
    [[0.695761, 0.111605], [0.779398, 0.186644]]
    >>> many.states[1]
    ('S1', 'S3', 'S1', 'S2')
    """
    require_within("rtol", rtol, 1e-14, 1e-3)
    result: ManyDrops | ManyShots
    if isinstance(template, TwoBallDrop):
        velocities, states, stuck = _solve(drop_batch(template, parameters), law, rtol)
        result = ManyDrops(velocities=velocities, states=states)
    else:
        velocities, states, stuck = _solve(shot_batch(template, parameters), law, rtol)
        result = ManyShots(
            cue_speed=velocities[:, 0],
            velocity=velocities[:, 1:4],
            angular_velocity=velocities[:, 4:7],
            states=states,
        )
    if len(stuck):
        raise ConvergenceError(f"collisions in rows {stuck.tolist()} did not end", result)
    return result


class Rows(NamedTuple):
    """Tasks of many rows, and what they write."""

    contacts: npt.NDArray[np.void]  # (N, 2) of dtype CONTACT
    delassus: Array  # (N, 2 r, 2 r)
    velocity: Array  # (N, 2 r) u before the collision
    impulse: Array  # (N, 2 r) p
    status: Integers  # (N,) how the run ended
    counts: Integers  # (N,) of states
    active: Integers  # (N, room) per state the sum of 1 (contact 1 active) and 2 (contact 2 active)
    tolerance: float
    poisson: bool


def _solve(
    batch: Batch, law: RestitutionLaw, tolerance: float
) -> tuple[Array, Sequence[tuple[str, ...]], Integers]:
    """Run every row; give velocities after, names of states, and the rows that did not end."""
    count, degrees = batch.velocity.shape
    jacobian = np.broadcast_to(
        batch.jacobian.reshape(len(batch.jacobian), -1, degrees),
        (count, batch.jacobian[0, :, :, 0].size, degrees),
    )
    weighted = jacobian * batch.inverse_mass[:, np.newaxis, :]
    delassus = weighted @ jacobian.transpose(0, 2, 1)
    approach = np.einsum("nij,nj->ni", jacobian, batch.velocity)
    rows = _run_with_room(batch.contacts, delassus, approach, law, tolerance)
    velocities = batch.velocity + np.einsum("nij,ni->nj", weighted, rows.impulse)
    return velocities, tuple(_name_states(rows)), np.flatnonzero(rows.status != FINISHED)


def _run_with_room(
    contacts: npt.NDArray[np.void], delassus: Array, approach: Array, law: RestitutionLaw, tolerance: float
) -> Rows:
    """Run all rows, and once more with room for all states if some row had more than most do."""
    room = 32
    while True:
        rows = Rows(
            contacts.copy(),
            delassus,
            approach,
            np.zeros_like(approach),
            np.zeros(len(approach), np.int64),
            np.zeros(len(approach), np.int64),
            np.zeros((len(approach), room), np.int64),
            tolerance,
            law is RestitutionLaw.POISSON,
        )
        _run_rows(rows)
        longest = int(rows.counts.max(initial=0))
        if longest <= room:
            return rows
        room = longest


@compiled_allocating
def _run_row(rows: Rows, row: int) -> None:
    room = rows.active.shape[1]
    record = Record(
        np.zeros(4, np.int64), np.zeros((room, 4), np.int64), np.zeros((0, 3), np.int64), np.zeros((0, 0))
    )
    task = Task(
        rows.contacts[row],
        rows.delassus[row],
        rows.velocity[row],
        rows.impulse[row],
        np.ones(3),
        rows.tolerance,
        rows.poisson,
    )
    rows.status[row] = run(task, record, MOST_STATES)
    rows.counts[row] = record.counts[STATES]
    for state in range(min(room, record.counts[STATES])):
        rows.active[row, state] = record.states[state, 2] + 2 * record.states[state, 3]


@compiled_parallel
def _run_rows(rows: Rows) -> None:
    for row in parallel_range(rows.status.size):
        _run_row(rows, row)


def _name_states(rows: Rows) -> Iterator[tuple[str, ...]]:
    names = {1 * (0 in active) + 2 * (1 in active): name for active, name in TWO_CONTACT_STATES.items()}
    for codes, count in zip(rows.active.tolist(), rows.counts.tolist(), strict=True):
        yield tuple(names[code] for code in codes[:count])
