"""The way of a ball in stretches of constant acceleration."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np
import numpy.typing as npt

from impact._checks import Array


class Motion(Enum):
    """What a ball on a table is doing."""

    FLYING = "flying"
    SLIDING = "sliding"
    ROLLING = "rolling"
    SPINNING = "spinning"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class Stretch:
    """The part of a path inside one phase, with constant accelerations.

    Attributes
    ----------
    motion : Motion
        The phase.
    start, end : float
        Times, s.
    position, velocity, angular_velocity : (3,) arrays
        At `start`; the position is that of the centre, with z = 0 for a ball on the table.
    acceleration, angular_acceleration : (3,) arrays
        m/s² and rad/s².
    spin_deceleration : float
        At which the spin about the vertical dies away, rad/s².
    """

    motion: Motion
    start: float
    end: float
    position: Array
    velocity: Array
    angular_velocity: Array
    acceleration: Array
    angular_acceleration: Array
    spin_deceleration: float

    def state_at(self, time: float) -> tuple[Array, Array, Array]:
        """Position, velocity and angular velocity at a time within the stretch."""
        elapsed = time - self.start
        spin = self.angular_velocity + self.angular_acceleration * elapsed
        upright = float(self.angular_velocity[2])
        spin[2] = math.copysign(max(abs(upright) - self.spin_deceleration * elapsed, 0.0), upright)
        position = self.position + self.velocity * elapsed + 0.5 * self.acceleration * elapsed**2
        return position, self.velocity + self.acceleration * elapsed, spin

    def __repr__(self) -> str:
        x, y, _ = self.position
        return f"<{self.motion.value} from {self.start:.4g} s at ({x:.4g}, {y:.4g}) m to {self.end:.4g} s>"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Path:
    """The whole way of a ball until it rests.

    Attributes
    ----------
    stretches : tuple of Stretch
        In order; each begins where the one before ended.
    """

    stretches: tuple[Stretch, ...]

    @property
    def duration(self) -> float:
        """Time until the ball rests, s."""
        return self.stretches[-1].end if self.stretches else 0.0

    def position(self, times: npt.ArrayLike) -> Array:
        """Position of the centre at the given times, m, shape (N, 3); after the end the ball stays."""
        if not self.stretches:
            raise ValueError("a ball that never moved has no path")
        within = np.clip(np.atleast_1d(times), self.stretches[0].start, self.duration)
        indices = np.searchsorted([stretch.end for stretch in self.stretches], within)
        return np.array(
            [
                self.stretches[index].state_at(time)[0]
                for index, time in zip(indices.tolist(), within.tolist(), strict=True)
            ]
        )
