"""Thousands of collisions in one call: the same diagram, spread over rows and threads."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from reprlib import repr as shown
from typing import overload

import numpy as np
import numpy.typing as npt

from impact._checks import Array, require_at_least, require_within
from impact.batches import Batch, drop_batch, shot_batch
from impact.collision import ConvergenceError
from impact.contact import RestitutionLaw
from impact.diagram import FINISHED, run
from impact.drop import TwoBallDrop
from impact.record import STATES, Record, Room, new_records, room_needed
from impact.scaling import Tasks, new_core, new_tasks
from impact.shot import CueShot
from impact.system import TWO_CONTACT_STATES

PROCESSORS = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
ROWS_AT_LEAST = 16
"""Rows a thread takes at a time."""


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
    threads: int | None = ...,
    **parameters: npt.ArrayLike,
) -> ManyDrops: ...


@overload
def collide_many(
    template: CueShot,
    *,
    law: RestitutionLaw = ...,
    rtol: float = ...,
    threads: int | None = ...,
    **parameters: npt.ArrayLike,
) -> ManyShots: ...


def collide_many(
    template: TwoBallDrop | CueShot,
    *,
    law: RestitutionLaw = RestitutionLaw.ENERGY,
    rtol: float = 1e-13,
    threads: int | None = None,
    **parameters: npt.ArrayLike,
) -> ManyDrops | ManyShots:
    """Run one scene for arrays of parameters.

    Parameters
    ----------
    template : TwoBallDrop or CueShot
        Gives every value that is not varied.
    law, rtol
        As in `collide`.
    threads : int, optional
        How many work side by side; as many as there are processors without it.
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
    threads = PROCESSORS if threads is None else threads
    require_at_least("threads", threads, 1)
    result: ManyDrops | ManyShots
    if isinstance(template, TwoBallDrop):
        velocities, states, stuck = _solve(drop_batch(template, parameters), (law, rtol, threads))
        result = ManyDrops(velocities=velocities, states=states)
    else:
        velocities, states, stuck = _solve(shot_batch(template, parameters), (law, rtol, threads))
        result = ManyShots(
            cue_speed=velocities[:, 0],
            velocity=velocities[:, 1:4],
            angular_velocity=velocities[:, 4:7],
            states=states,
        )
    if len(stuck):
        raise ConvergenceError(f"collisions in rows {shown(stuck.tolist())} did not end", result)
    return result


def _solve(
    batch: Batch, how: tuple[RestitutionLaw, float, int]
) -> tuple[Array, Sequence[tuple[str, ...]], npt.NDArray[np.int64]]:
    """Run every row; give velocities after, names of states, and the rows that did not end."""
    law, tolerance, threads = how
    count, degrees = batch.velocity.shape
    jacobian = batch.jacobian.reshape(len(batch.jacobian), -1, degrees)
    weighted = jacobian * batch.inverse_mass[:, np.newaxis, :]
    delassus = weighted @ jacobian.transpose(0, 2, 1)
    approach = (jacobian @ batch.velocity[:, :, np.newaxis])[:, :, 0]
    room = Room(states=24, events=0, samples=0)
    while True:
        tasks = new_tasks(batch.contacts, delassus, approach, law, tolerance)
        records = new_records(count, 2, approach.shape[1], room)
        _run_in_threads(tasks, records, threads)
        needed = room_needed(records, room)
        if needed == room:
            break
        room = needed
    velocities = batch.velocity + (tasks.impulse[:, np.newaxis, :] @ weighted)[:, 0, :]
    return velocities, tuple(_name_states(records)), np.flatnonzero(tasks.status != FINISHED)


def _run_in_threads(tasks: Tasks, records: Record, threads: int) -> None:
    """Share the rows out among threads; the compiled run holds no lock."""
    count = len(tasks.status)
    share = max(ROWS_AT_LEAST, count // (8 * threads) + 1)
    if count <= share or threads == 1:
        run(tasks, records, new_core(tasks), 0, count)
        return
    with ThreadPoolExecutor(threads) as pool:
        shares = [
            pool.submit(run, tasks, records, new_core(tasks), first, min(first + share, count))
            for first in range(0, count, share)
        ]
    for done in shares:
        done.result()


def _name_states(records: Record) -> Iterator[tuple[str, ...]]:
    codes = records.states[:, :, 2] + 2 * records.states[:, :, 3]
    names = {1 * (0 in active) + 2 * (1 in active): name for active, name in TWO_CONTACT_STATES.items()}
    for row, length in zip(codes.tolist(), records.counts[:, STATES].tolist(), strict=True):
        yield tuple(names[code] for code in row[:length])
