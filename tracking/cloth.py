"""How a struck ball moves over cloth: first it slides, then it rolls, in closed form.

The lowest point of the ball moves over the cloth with the slip ``u = v + r z x w`` (z up). Friction slows
the ball by ``mu g`` against u. A solid ball changes its spin at the same time, so that u shrinks 7/2 times as
fast as v changes and keeps its direction: the path is a parabola until ``2 |u| / (7 mu g)``, then straight.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tracking.flight import STANDARD_GRAVITY, Floats


@dataclass(frozen=True, slots=True, kw_only=True)
class Cloth:
    """What a ball slides and rolls on.

    Attributes
    ----------
    friction : float
        Sliding friction coefficient.
    rolling_resistance : float
        Deceleration while rolling over gravity.
    gravity : float
        m/s².

    Raises
    ------
    ValueError
        If friction or gravity is not positive, or the rolling resistance is negative.
    """

    friction: float
    rolling_resistance: float = 0.0
    gravity: float = STANDARD_GRAVITY

    def __post_init__(self) -> None:
        for name in ("friction", "gravity"):
            if not 0 < getattr(self, name) < math.inf:
                raise ValueError(f"{name} must be positive and finite, got {getattr(self, name)}")
        if not 0 <= self.rolling_resistance < math.inf:
            raise ValueError(f"rolling_resistance must be at least 0, got {self.rolling_resistance}")


def cloth_position(cloth: Cloth, velocity: ArrayLike, slip: ArrayLike, time: ArrayLike) -> Floats:
    """Displacement of a ball struck at time 0: a sliding parabola, then a straight roll that slows and stops.

    Friction acts against the slip, whose direction never changes, until it is gone at `sliding_time`; the
    velocity has then lost two sevenths of it (solid ball).

    Parameters
    ----------
    cloth : Cloth
        What the ball is on.
    velocity : array_like, shape (2,)
        Velocity of the centre at time 0, m/s.
    slip : array_like, shape (2,)
        Velocity of the lowest point of the ball at time 0, m/s: ``(v_x - r w_y, v_y + r w_x)``.
    time : array_like, shape (n,)
        Times since the strike, s, at least 0.

    Returns
    -------
    ndarray, shape (n, 2)
        Displacement in m.

    Examples
    --------
    >>> cloth_position(Cloth(friction=0.2, gravity=10), [2.0, 0.0], [2.0, 0.0], [0.0, 0.1]).tolist()
    [[0.0, 0.0], [0.19, 0.0]]
    """
    start, slip = np.asarray(velocity, float), np.asarray(slip, float)
    time = np.asarray(time, float)[..., np.newaxis]
    end, slip_speed = sliding_time(cloth, slip), np.hypot(*slip)
    deceleration = cloth.friction * cloth.gravity * (slip / slip_speed if slip_speed > 0 else slip)
    sliding = np.minimum(time, end)
    roll = start - 2 / 7 * slip
    resistance = cloth.rolling_resistance * cloth.gravity
    roll_speed = np.hypot(*roll)
    rest = roll_speed / resistance if resistance > 0 else math.inf
    rolling = np.clip(time - end, 0.0, rest)
    shortfall = resistance / 2 / roll_speed * rolling**2 if roll_speed > 0 else rolling
    return np.asarray(start * sliding - deceleration / 2 * sliding**2 + roll * (rolling - shortfall))


def sliding_time(cloth: Cloth, slip: ArrayLike) -> float:
    """Time until a ball struck with this `slip` (m/s, see `cloth_position`) rolls, in s."""
    return float(2 * np.hypot(*np.asarray(slip, float)) / (7 * cloth.friction * cloth.gravity))
