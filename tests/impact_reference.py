"""Second engines for the impact model, slow and plain, that share no line with the first.

`follow` integrates any system with scipy. Friction is smoothed, ``û = u_t / sqrt(|u_t|² + ε²)``, so it knows
nothing of sticking; it differs from Coulomb's law by about ε. `follow_linear` has no friction and needs no
integrator at all: between two events linear springs move in eigenmodes.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from impact import ImpactSystem


@dataclass
class Reference:
    """One run of a reference engine."""

    delassus: np.ndarray
    velocity: np.ndarray  # u before the collision
    stiffness: np.ndarray
    exponent: np.ndarray
    friction: np.ndarray
    restitution: np.ndarray
    rows: int
    states: list[frozenset[int]] = field(default_factory=list)
    dropped: float = 0.0

    def __post_init__(self) -> None:
        count = len(self.stiffness)
        self.impulse = np.zeros(len(self.velocity))
        self.depth = np.zeros(count)
        self.rest = np.zeros(count)
        self.active = np.zeros(count, bool)
        self.restoring = np.zeros(count, bool)

    def normal_velocity(self) -> np.ndarray:
        return (self.velocity + self.delassus @ self.impulse)[:: self.rows]

    def drop(self, contact: int) -> None:
        power = self.exponent[contact] + 1.0
        self.dropped += self.stiffness[contact] * max(self.depth[contact], 0.0) ** power / power
        self.depth[contact] = 0.0
        self.active[contact] = self.restoring[contact] = False

    def turn(self, contact: int) -> None:
        self.restoring[contact] = True
        kept = 1.0 - self.restitution[contact] ** 2
        self.rest[contact] = kept ** (1.0 / (self.exponent[contact] + 1.0)) * self.depth[contact]
        if self.restitution[contact] == 0.0:
            self.drop(contact)


def of(system: ImpactSystem) -> Reference:
    """Reference run of a system, before its start."""
    rows = system.jacobian.reshape(-1, len(system.velocity))
    contacts = system.contacts
    return Reference(
        rows @ system.inverse_mass @ rows.T,
        rows @ system.velocity,
        np.array([c.stiffness for c in contacts]),
        np.array([c.exponent for c in contacts]),
        np.array([c.friction for c in contacts]),
        np.array([c.restitution for c in contacts]),
        system.jacobian.shape[1],
    )


def follow(system: ImpactSystem, smoothing: float = 1e-7, most_states: int = 60) -> np.ndarray:
    """Velocity after the collision, by scipy's integrators and smoothed friction."""
    run = of(system)
    scale = -run.normal_velocity().min()
    count = len(run.stiffness)

    def rates(_: float, point: np.ndarray) -> np.ndarray:
        depth, impulse = point[:count], point[count:]
        velocity = run.velocity + run.delassus @ impulse
        force = np.zeros((count, run.rows))
        force[:, 0] = np.where(run.active, run.stiffness * np.maximum(depth, 0.0) ** run.exponent, 0.0)
        if run.rows > 1:
            slip = velocity.reshape(count, run.rows)[:, 1:]
            size = np.sqrt((slip**2).sum(axis=1) + (smoothing * scale) ** 2)
            force[:, 1:] = -(run.friction * force[:, 0] / size)[:, None] * slip
        return np.concatenate([np.where(run.active, -velocity[:: run.rows], 0.0), force.ravel()])

    def event(contact: int, kind: str):
        def margin(_: float, point: np.ndarray) -> float:
            normal = (run.velocity + run.delassus @ point[count:])[contact * run.rows]
            if kind == "velocity":
                rising = run.active[contact] and not run.restoring[contact]
                return (-normal if rising else normal) + 1e-12 * scale
            return point[contact] - run.rest[contact] if run.restoring[contact] else 1.0

        margin.terminal, margin.direction = True, -1.0
        return margin

    events = [event(contact, kind) for contact in range(count) for kind in ("velocity", "rest")]
    for _ in range(40 * most_states):
        _engage(run, rates, scale)
        if not run.active.any():
            break
        start = np.concatenate([run.depth, run.impulse])
        method = "Radau" if run.friction.any() else "DOP853"
        done = solve_ivp(rates, (0.0, 1e6), start, method, events=events, rtol=1e-10, atol=1e-13 * scale)
        fired = [index for index, times in enumerate(done.t_events) if len(times)]
        run.depth, run.impulse = done.y[:count, -1], done.y[count:, -1]
        _advance(run, fired)
    rows = system.jacobian.reshape(-1, len(system.velocity))
    return system.velocity + system.inverse_mass @ (rows.T @ run.impulse)


def _engage(run: Reference, rates, scale: float) -> None:
    """Start closing contacts, and resting ones that the forces a moment later push."""
    normal = run.normal_velocity()
    run.active |= normal < -1e-11 * scale
    for _ in range(len(normal)):
        soon = np.concatenate([run.depth + np.where(run.active & (run.depth == 0), 1e-4, 0.0), run.impulse])
        push = run.delassus @ rates(0.0, soon)[len(normal) :]
        resting = ~run.active & (np.abs(normal) <= 2e-11 * scale)
        run.active |= resting & (push[:: run.rows] < -1e-9 * np.abs(push).max())
    state = frozenset(np.flatnonzero(run.active).tolist())
    if state and (not run.states or run.states[-1] != state):
        run.states.append(state)


def _advance(run: Reference, fired: list[int]) -> None:
    for index in fired:
        contact, at_rest = divmod(index, 2)
        if at_rest:
            run.drop(contact)
        elif not run.active[contact]:
            run.active[contact] = True
        elif run.restoring[contact]:
            run.restoring[contact] = False
        else:
            run.turn(contact)


def follow_linear(
    system: ImpactSystem, most_states: int = 400
) -> tuple[np.ndarray, list[frozenset[int]], float]:
    """Velocity after a frictionless collision of linear springs, its states and the energy dropped.

    Between events the active compressions obey ``δ'' = -A K δ``, which eigenmodes solve exactly.
    """
    run = of(system)
    scale = -run.normal_velocity().min()
    for _ in range(40 * most_states):
        _engage(run, _linear_rates(run), scale)
        stored = 0.5 * run.stiffness @ run.depth**2
        if not run.active.any() or (
            run.normal_velocity().min() > -1e-10 * scale and stored < 1e-20 * scale**2
        ):
            break
        _advance(run, _to_next_event(run, scale))
    rows = system.jacobian.reshape(-1, len(system.velocity))
    return system.velocity + system.inverse_mass @ (rows.T @ run.impulse), run.states, run.dropped


def _linear_rates(run: Reference):
    def rates(_: float, point: np.ndarray) -> np.ndarray:
        depth = point[: len(run.depth)]
        return np.concatenate([0.0 * depth, np.where(run.active, run.stiffness * depth, 0.0)])

    return rates


def _to_next_event(run: Reference, scale: float) -> list[int]:
    """Move to the first event and say which it was, numbered as in `follow`."""
    active = np.flatnonzero(run.active)
    root = np.sqrt(run.stiffness[active])
    squared, modes = np.linalg.eigh(root[:, None] * run.delassus[np.ix_(active, active)] * root)
    omega = np.sqrt(np.maximum(squared, 1e-300))
    start = modes.T @ (root * run.depth[active])
    speed = modes.T @ (root * -run.normal_velocity()[active])
    impulse = run.impulse.copy()

    def depth(time: float) -> np.ndarray:
        return modes @ (start * np.cos(omega * time) + speed * np.sin(omega * time) / omega) / root

    def normal(time: float) -> np.ndarray:
        integral = modes @ (
            start * np.sin(omega * time) / omega + speed * (1.0 - np.cos(omega * time)) / squared
        )
        run.impulse = impulse.copy()
        run.impulse[active] += root * integral
        return run.normal_velocity()

    def margins(time: float) -> np.ndarray:
        velocity, depths = normal(time), run.depth.copy()
        depths[active] = depth(time)
        rising = run.active & ~run.restoring
        rest = np.where(run.restoring, depths - run.rest, np.inf)
        return np.ravel(np.column_stack([np.where(rising, -velocity, velocity) + 1e-12 * scale, rest]))

    step = 0.05 / omega.max()
    before, time = 0.0, step
    while margins(time).min() > 0.0:
        before, time = time, time + step
    crossing = np.flatnonzero(margins(time) <= 0.0).tolist()
    times = [brentq(lambda t, i=index: margins(t)[i], before, time, xtol=1e-15) for index in crossing]
    fired, when = crossing[int(np.argmin(times))], min(times)
    run.depth[active] = depth(when)
    normal(when)
    return [fired]
