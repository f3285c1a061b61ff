"""Balls in a line: two dropped on a table, a column on a table, a free row."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from impact._checks import Array, as_array, require_finite, require_positive
from impact.bodies import Ball
from impact.collision import Collision
from impact.contact import Contact
from impact.system import TWO_CONTACT_STATES, ImpactSystem

DROP_JACOBIAN = np.array([[[1.0, -1.0]], [[0.0, 1.0]]])
"""Normal velocities of ball-ball and ball-table contact from those of upper and lower ball (1, 2)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TwoBallDrop:
    """A ball falls onto another that rests on a table (paper, Section 2).

    Parameters
    ----------
    upper, lower : Ball
        The falling ball and the resting one.
    ball_ball, ball_table : Contact
        Contact 1, between the balls, and contact 2, between lower ball and table. Friction plays no part.
    approach_velocity : float
        Velocity of the upper ball before the impact, m/s, negative (downward).

    Raises
    ------
    ValueError
        If the upper ball does not approach.

    Examples
    --------
    Two ping-pong balls, as in Figure 5 of the paper:

    >>> from impact import collide
    >>> ball = Ball(mass=0.0027, radius=0.020)
    >>> drop = TwoBallDrop(upper=ball, lower=ball, approach_velocity=-1.0,
    ...                    ball_ball=Contact(restitution=0.807755),
    ...                    ball_table=Contact(restitution=0.846529, stiffness=10.0))
    >>> collide(drop).velocities.round(7).tolist()
    [0.7793977, 0.1866439]
    """

    upper: Ball
    lower: Ball
    ball_ball: Contact
    ball_table: Contact
    approach_velocity: float

    def __post_init__(self) -> None:
        require_finite("approach_velocity", self.approach_velocity)
        if self.approach_velocity >= 0.0:
            raise ValueError(f"approach_velocity must be negative (downward), got {self.approach_velocity}")

    def system(self) -> ImpactSystem:
        """Upper and lower velocity; contact 1 between the balls, contact 2 on the table (1, 2)."""
        return ImpactSystem(
            inverse_mass=np.diag([1.0 / self.upper.mass, 1.0 / self.lower.mass]),
            jacobian=DROP_JACOBIAN,
            velocity=[self.approach_velocity, 0.0],
            contacts=(_frictionless(self.ball_ball), _frictionless(self.ball_table)),
            state_names=TWO_CONTACT_STATES,
        )

    def outcome(self, collision: Collision) -> Collision:
        """Velocities are those of the upper, then the lower ball."""
        return collision

    def compression_lines(self) -> Array:
        """Lines ``a I₁ + b I₂ + c = 0`` on which a contact turns from compression to restitution (12).

        Returns
        -------
        (2, 3) array
            a, b, c of ℓ₁ (ball-ball) and ℓ₂ (ball-table).
        """
        upper, lower = 1.0 / self.upper.mass, 1.0 / self.lower.mass
        return np.array([[upper + lower, -lower, self.approach_velocity], [1.0, -1.0, 0.0]])

    def bounding_ellipse(self, points: int = 200) -> Array:
        """Ellipse that no impulse curve leaves (15), as a closed line.

        Returns
        -------
        (points, 2) array
            I₁ and I₂, N s, once around from the origin.
        """
        angle = np.linspace(0.0, 2.0 * np.pi, points)
        reach = -self.upper.mass * self.approach_velocity
        height = reach * np.sqrt(self.lower.mass / self.upper.mass)
        first = reach * (1.0 - np.cos(angle))
        return np.column_stack([first, first + height * np.sin(angle)])


@dataclass(frozen=True, slots=True, kw_only=True)
class BallColumn:
    """Balls one above the other on a table, moving along the vertical.

    Parameters
    ----------
    balls : sequence of Ball
        From bottom to top.
    contacts : sequence of Contact
        The table's first, then upwards: as many as balls.
    velocities : sequence of float
        Before the collision, bottom to top, m/s, up positive.

    Raises
    ------
    ValueError
        If the numbers of balls, contacts and velocities differ, or nothing approaches.

    Examples
    --------
    >>> from impact import collide
    >>> ball = Ball(mass=1.0, radius=0.02)
    >>> column = BallColumn(balls=[ball, ball], velocities=[0.0, -3.0],
    ...                     contacts=[Contact(restitution=0.4**0.5, stiffness=10.0),
    ...                               Contact(restitution=0.9**0.5)])
    >>> collide(column).velocities.round(6).tolist()
    [0.735552, 2.44136]
    """

    balls: Sequence[Ball]
    contacts: Sequence[Contact]
    velocities: Sequence[float]

    def __post_init__(self) -> None:
        if len(self.contacts) != len(self.balls):
            raise ValueError(
                f"contacts must be as many as balls ({len(self.balls)}), got {len(self.contacts)}"
            )
        velocities = as_array("velocities", self.velocities, (len(self.balls),))
        _require_approach(np.diff(velocities, prepend=0.0))

    def system(self) -> ImpactSystem:
        """One velocity a ball; contact i is below ball i."""
        count = len(self.balls)
        return ImpactSystem(
            inverse_mass=np.diag([1.0 / ball.mass for ball in self.balls]),
            jacobian=(np.eye(count) - np.eye(count, k=-1))[:, np.newaxis, :],
            velocity=self.velocities,
            contacts=[_frictionless(contact) for contact in self.contacts],
        )

    def outcome(self, collision: Collision) -> Collision:
        """Velocities are those of the balls from bottom to top."""
        return collision


@dataclass(frozen=True, slots=True, kw_only=True)
class BallChain:
    """A free row of touching balls, as in Newton's cradle, moving along the row.

    Parameters
    ----------
    masses : sequence of float
        kg, at least two.
    velocities : sequence of float
        Before the collision, m/s, positive from the first ball towards the last.
    contacts : sequence of Contact
        Contact i lies between balls i and i + 1.

    Raises
    ------
    ValueError
        If the numbers do not fit, a mass is not positive, or nothing approaches.

    Examples
    --------
    >>> from impact import collide
    >>> chain = BallChain(masses=[1, 1, 1], velocities=[1, 0, 0], contacts=[Contact(restitution=1.0)] * 2)
    >>> collide(chain).velocities.round(4).tolist()
    [-0.1303, 0.1502, 0.98]
    """

    masses: Sequence[float]
    velocities: Sequence[float]
    contacts: Sequence[Contact]

    def __post_init__(self) -> None:
        for mass in self.masses:
            require_positive("mass", mass)
        if len(self.contacts) != len(self.masses) - 1 or not self.contacts:
            raise ValueError(f"contacts must be one or more, one fewer than masses, got {len(self.contacts)}")
        velocities = as_array("velocities", self.velocities, (len(self.masses),))
        _require_approach(np.diff(velocities))

    def system(self) -> ImpactSystem:
        """One velocity a ball."""
        count = len(self.masses)
        return ImpactSystem(
            inverse_mass=np.diag([1.0 / mass for mass in self.masses]),
            jacobian=np.diff(np.eye(count), axis=0)[:, np.newaxis, :],
            velocity=self.velocities,
            contacts=[_frictionless(contact) for contact in self.contacts],
        )

    def outcome(self, collision: Collision) -> Collision:
        """Velocities are those of the balls in order."""
        return collision


def _frictionless(contact: Contact) -> Contact:
    """Balls in a line do not slide on one another, so friction does nothing."""
    if contact.friction == 0.0:
        return contact
    return Contact(restitution=contact.restitution, stiffness=contact.stiffness, exponent=contact.exponent)


def _require_approach(opening: Array) -> None:
    if not (opening < 0.0).any():
        raise ValueError(f"velocities must bring two bodies together, got gaps opening at {opening.tolist()}")
