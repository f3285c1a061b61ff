"""A cue strikes a ball that lies on the table (paper, Section 3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from impact._checks import Array, as_array
from impact.bodies import Ball, Cue
from impact.collision import Collision, Segment
from impact.contact import Contact
from impact.frames import tangent_frame
from impact.system import TWO_CONTACT_STATES, ImpactSystem

Vector = Sequence[float] | Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class ShotOutcome:
    """What the cue ball does after a shot.

    Attributes
    ----------
    velocity : (3,) array
        Of the ball's centre, m/s; z is up.
    angular_velocity : (3,) array
        Of the ball, rad/s.
    cue_speed : float
        Velocity of the cue along its original direction, m/s; negative if the cue was thrown back.
    collision : Collision
        The impact itself: impulses, segments, energies.
    """

    velocity: Array
    angular_velocity: Array
    cue_speed: float
    collision: Collision

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states in order: S1 both contacts, S2 only the table, S3 only the tip."""
        return self.collision.states

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The stretch inside each state; contact 1 is the tip, contact 2 the table."""
        return self.collision.segments

    @property
    def impulses(self) -> Array:
        """Normal impulses of tip and table, N s, shape (2,)."""
        return self.collision.impulses

    @property
    def energy_loss(self) -> float:
        """Kinetic energy before minus after, J."""
        return self.collision.energy_loss

    def __repr__(self) -> str:
        velocity, spin = format_vector(self.velocity), format_vector(self.angular_velocity)
        shown = " ".join(self.states[:12]) + (" ..." if len(self.states) > 12 else "")
        return (
            f"ball velocity {velocity} m/s, angular velocity {spin} rad/s, "
            f"cue {self.cue_speed:.4g} m/s, states {shown}"
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CueShot:
    """A shot at a ball at rest on the table; the cue moves along its own direction only.

    The table lies in the x-y plane, z is up.

    Parameters
    ----------
    ball, cue : Ball, Cue
        The ball and the stick.
    normal : (3,) vector of any length
        Outward normal of the ball at the point the tip strikes.
    cue_velocity : (3,) vector
        Velocity of the cue before the shot, m/s.
    tip_ball, ball_table : Contact
        Contact 1, between tip and ball, and contact 2, between ball and table.

    Raises
    ------
    ValueError
        If a vector is zero or the cue does not move towards the ball.

    Examples
    --------
    >>> from impact import collide
    >>> shot = CueShot(ball=Ball(mass=0.1673, radius=0.0286), cue=Cue(mass=0.5018),
    ...                normal=(-1, -2, 1), cue_velocity=(0, 0, -2),
    ...                tip_ball=Contact(restitution=0.656532, friction=0.4, stiffness=1.5),
    ...                ball_table=Contact(restitution=0.51625, friction=0.152479))
    >>> outcome = collide(shot)
    >>> print(outcome)
    ball velocity (0.4291, 0.8582, 0.2831) m/s, angular velocity (31.63, -15.82, 0) rad/s, cue 1.591 m/s, ...
    >>> outcome.states
    ('S1', 'S2', 'S1', 'S3')
    """

    ball: Ball
    cue: Cue
    normal: Vector
    cue_velocity: Vector
    tip_ball: Contact
    ball_table: Contact

    def __post_init__(self) -> None:
        normal = as_array("normal", self.normal, (3,))
        cue_velocity = as_array("cue_velocity", self.cue_velocity, (3,))
        for name, vector in (("normal", normal), ("cue_velocity", cue_velocity)):
            if not vector.any():
                raise ValueError(f"{name} must not be zero, got {vector.tolist()}")
        if normal @ cue_velocity >= 0.0:
            raise ValueError(
                "cue_velocity must point into the ball, against normal, got "
                f"normal · cue_velocity = {normal @ cue_velocity:g}"
            )

    def system(self) -> ImpactSystem:
        """Velocities: of the cue along its direction, of the ball, angular of the ball (7 numbers)."""
        speed = float(np.linalg.norm(self.cue_velocity))
        normal = np.asarray(self.normal, dtype=np.float64)
        direction = np.asarray(self.cue_velocity, dtype=np.float64) / speed
        return ImpactSystem(
            inverse_mass=np.diag(shot_inverse_mass(self.ball.mass, self.cue.mass, self.ball.inertia)),
            jacobian=shot_jacobian(normal / np.linalg.norm(normal), direction, self.ball.radius),
            velocity=[speed, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            contacts=(self.tip_ball, self.ball_table),
            state_names=TWO_CONTACT_STATES,
        )

    def outcome(self, collision: Collision) -> ShotOutcome:
        """Split the generalized velocity into those of ball and cue."""
        return ShotOutcome(
            velocity=collision.velocities[1:4],
            angular_velocity=collision.velocities[4:7],
            cue_speed=float(collision.velocities[0]),
            collision=collision,
        )


def format_vector(vector: Array) -> str:
    """Write a vector to four digits, with rounding errors as plain zeros."""
    smallest = 1e-9 * float(np.abs(vector).max())
    return "(" + ", ".join(f"{part:.4g}" if abs(part) > smallest else "0" for part in vector) + ")"


def shot_inverse_mass(ball_mass: float | Array, cue_mass: float | Array, inertia: float | Array) -> Array:
    """Diagonal of M⁻¹, shape (..., 7), in the order of `CueShot.system`."""
    parts = [1.0 / np.asarray(cue_mass), *[1.0 / np.asarray(ball_mass)] * 3, *[1.0 / np.asarray(inertia)] * 3]
    return np.stack(np.broadcast_arrays(*parts), axis=-1)


def shot_jacobian(normal: Array, direction: Array, radius: float) -> Array:
    """Contact velocities of tip and table from cue speed, ball velocity and angular velocity (18).

    Parameters
    ----------
    normal, direction : (..., 3) arrays
        Unit normal at the tip and unit direction of the cue.
    radius : float
        Of the ball, m.

    Returns
    -------
    (..., 2, 3, 7) array
        Tip then table, each along its normal and two tangents (`tangent_frame`). At the tip it is the
        velocity of the cue relative to the ball, at the table that of the ball.
    """
    shape = normal.shape[:-1]
    up = np.broadcast_to(np.array([0.0, 0.0, 1.0]), normal.shape)
    jacobian = np.zeros((*shape, 2, 3, 7))
    for index, axis in enumerate(tangent_frame(normal)):
        jacobian[..., 0, index, 0] = (axis * direction).sum(axis=-1)
        jacobian[..., 0, index, 1:4] = -axis
        jacobian[..., 0, index, 4:7] = -radius * np.cross(normal, axis)
    for index, axis in enumerate(tangent_frame(up)):
        jacobian[..., 1, index, 1:4] = axis
        jacobian[..., 1, index, 4:7] = -radius * np.cross(up, axis)
    return jacobian
