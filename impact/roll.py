"""After the shot: a ball flies, bounces, slides along a parabola, rolls and comes to rest.

Every phase has constant accelerations, so it is known in closed form. Sliding: W. C. Marlow, "The Physics of
Pocket Billiards" (1994), reference 11 of the paper; for a solid ball it lasts ``2 |u| / (7 μ g)``, where u is
the velocity of the lowest point of the ball.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from impact._checks import Array, as_array, require_nonnegative, require_positive, require_within
from impact.bodies import Ball
from impact.path import Motion, Path, Stretch

UP = np.array([0.0, 0.0, 1.0])
STILL = 1e-12
"""Speed that counts as none, m/s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Cloth:
    """The table a ball moves on.

    Parameters
    ----------
    friction : float
        Coefficient of sliding friction, positive.
    restitution : float
        Coefficient of restitution of a bounce, within [0, 1].
    rolling_resistance : float
        Deceleration of a rolling ball over gravity, positive; 0.005 to 0.015 on pool cloth.
    spin_resistance : float
        Deceleration of the spin about the vertical times ``r / g``, positive; about 0.02 on pool cloth.
    gravity : float
        m/s².
    smallest_bounce : float
        A rebound slower than this stays on the table, m/s.

    Raises
    ------
    ValueError
        If a value breaks its rule.
    """

    friction: float
    restitution: float
    rolling_resistance: float = 0.01
    spin_resistance: float = 0.022
    gravity: float = 9.80665
    smallest_bounce: float = 0.02

    def __post_init__(self) -> None:
        for name in ("friction", "rolling_resistance", "spin_resistance", "gravity", "smallest_bounce"):
            require_positive(name, getattr(self, name))
        require_within("restitution", self.restitution, 0.0, 1.0)


def roll(
    ball: Ball,
    velocity: npt.ArrayLike,
    angular_velocity: npt.ArrayLike,
    cloth: Cloth,
    position: npt.ArrayLike = (0.0, 0.0, 0.0),
) -> Path:
    """Follow a ball on the table until it rests.

    Parameters
    ----------
    ball : Ball
        The ball.
    velocity, angular_velocity : (3,) vectors
        After the shot, m/s and rad/s.
    cloth : Cloth
        The table.
    position : (3,) vector
        Where the centre starts, m; z = 0 is a ball on the table.

    Returns
    -------
    Path
        With the time and place of each change.

    Raises
    ------
    ValueError
        If a vector has another shape, the ball starts below the table, or it would bounce for ever.

    Examples
    --------
    A ball struck through its centre slides, and rolls at 5/7 of its speed:

    >>> ball = Ball(mass=0.17, radius=0.0286)
    >>> path = roll(ball, (1, 0, 0), (0, 0, 0), Cloth(friction=0.2, restitution=0.5, gravity=9.8))
    >>> for stretch in path.stretches:
    ...     print(stretch)
    <sliding from 0 s at (0, 0) m to 0.1458 s>
    <rolling from 0.1458 s at (0.1249, 0) m to 7.434 s>
    >>> path.stretches[1].velocity.round(4).tolist()
    [0.7143, 0.0, 0.0]
    """
    state = (
        as_array("position", position, (3,)),
        as_array("velocity", velocity, (3,)),
        as_array("angular_velocity", angular_velocity, (3,)),
    )
    require_nonnegative("height", float(state[0][2]))
    landing = math.sqrt(float(state[1][2]) ** 2 + 2.0 * cloth.gravity * float(state[0][2]))
    if landing > cloth.smallest_bounce and cloth.restitution == 1.0:
        raise ValueError("restitution must be below 1 where the ball leaves the table: it would never rest")
    stretches: list[Stretch] = []
    while True:
        time = stretches[-1].end if stretches else 0.0
        if state[0][2] <= STILL and state[1][2] < -STILL:
            state = (state[0] * (1.0, 1.0, 0.0), *_bounce(ball, cloth, state[1], state[2]))
        stretch = _next_stretch(ball, cloth, time, state)
        if stretch is None:
            return Path(stretches=tuple(stretches))
        stretches.append(stretch)
        state = _land(ball, stretch)


State = tuple[Array, Array, Array]


def slip_velocity(ball: Ball, velocity: Array, angular_velocity: Array) -> Array:
    """Horizontal velocity of the ball's lowest point, ``v - ω × r z``."""
    slip: Array = velocity - np.cross(angular_velocity, ball.radius * UP)
    slip[2] = 0.0
    return slip


def _next_stretch(ball: Ball, cloth: Cloth, time: float, state: State) -> Stretch | None:
    position, velocity, spin = state
    if position[2] > STILL or velocity[2] > STILL:
        rise = float(velocity[2])
        lasts = (rise + math.sqrt(rise**2 + 2.0 * cloth.gravity * float(position[2]))) / cloth.gravity
        return _stretch(Motion.FLYING, time, lasts, state, acceleration=-cloth.gravity * UP)
    slip = slip_velocity(ball, velocity, spin)
    slip_speed = float(np.linalg.norm(slip))
    deceleration = cloth.spin_resistance * cloth.gravity / ball.radius
    if slip_speed > 1e-9:
        pull = cloth.friction * cloth.gravity
        return _stretch(
            Motion.SLIDING,
            time,
            slip_speed / (pull * (1.0 + 1.0 / ball.inertia_factor)),
            state,
            acceleration=-pull / slip_speed * slip,
            angular_acceleration=pull / (ball.inertia_factor * ball.radius * slip_speed) * np.cross(UP, slip),
            spin_deceleration=deceleration,
        )
    speed = float(np.linalg.norm(velocity))
    if speed > STILL:
        slowing = cloth.rolling_resistance * cloth.gravity / speed * velocity
        return _stretch(
            Motion.ROLLING,
            time,
            speed / (cloth.rolling_resistance * cloth.gravity),
            state,
            acceleration=-slowing,
            angular_acceleration=-np.cross(UP, slowing) / ball.radius,
            spin_deceleration=deceleration,
        )
    if abs(spin[2]) > STILL:
        return _stretch(
            Motion.SPINNING, time, abs(float(spin[2])) / deceleration, state, spin_deceleration=deceleration
        )
    return None


def _stretch(
    motion: Motion,
    start: float,
    lasts: float,
    state: State,
    *,
    acceleration: Array | None = None,
    angular_acceleration: Array | None = None,
    spin_deceleration: float = 0.0,
) -> Stretch:
    return Stretch(
        motion=motion,
        start=start,
        end=start + lasts,
        position=state[0],
        velocity=state[1],
        angular_velocity=state[2],
        acceleration=np.zeros(3) if acceleration is None else acceleration,
        angular_acceleration=np.zeros(3) if angular_acceleration is None else angular_acceleration,
        spin_deceleration=spin_deceleration,
    )


def _land(ball: Ball, stretch: Stretch) -> State:
    """State at the end of a stretch, with what has just ended at exactly zero."""
    position, velocity, spin = stretch.state_at(stretch.end)
    if stretch.motion is Motion.FLYING:
        position[2] = 0.0
        return position, velocity, spin
    if stretch.motion is Motion.SLIDING:
        rolling = np.cross(UP, velocity) / ball.radius
        return position, velocity, np.array([rolling[0], rolling[1], spin[2]])
    return position, np.zeros(3), np.array([0.0, 0.0, spin[2]])


def _bounce(ball: Ball, cloth: Cloth, velocity: Array, spin: Array) -> tuple[Array, Array]:
    """One impact on the table: friction slides all through it, or stops the slip (paper, state S₂)."""
    rebound = -cloth.restitution * float(velocity[2])
    rebound = rebound if rebound > cloth.smallest_bounce else 0.0
    slip = slip_velocity(ball, velocity, spin)
    slip_speed = float(np.linalg.norm(slip))
    if slip_speed <= STILL:
        return velocity * (1.0, 1.0, 0.0) + rebound * UP, spin
    sliding = cloth.friction * (rebound - float(velocity[2]))
    sticking = slip_speed / (1.0 + 1.0 / ball.inertia_factor)
    change = -min(sliding, sticking) / slip_speed * slip
    turned = spin - np.cross(UP, change) / (ball.inertia_factor * ball.radius)
    return velocity * (1.0, 1.0, 0.0) + change + rebound * UP, turned
