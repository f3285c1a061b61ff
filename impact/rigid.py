"""Bodies of any shape, for systems of your own (paper, Section 4)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from impact._checks import Array, as_array, require_positive
from impact.contact import Contact
from impact.frames import tangent_frame
from impact.system import ImpactSystem

ZERO = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RigidBody:
    """A rigid body of any shape.

    Parameters
    ----------
    mass : float
        kg.
    inertia : (3, 3) array
        Inertia matrix Q about the centre of mass, kg m².
    velocity, angular_velocity : (3,) vectors
        Before the collision, m/s and rad/s.

    Raises
    ------
    ValueError
        If the mass is not positive or the inertia is not symmetric and positive definite.
    """

    mass: float
    inertia: npt.ArrayLike
    velocity: npt.ArrayLike = field(default=ZERO)
    angular_velocity: npt.ArrayLike = field(default=ZERO)

    def __post_init__(self) -> None:
        require_positive("mass", self.mass)
        inertia = as_array("inertia", self.inertia, (3, 3))
        if not np.allclose(inertia, inertia.T) or np.linalg.eigvalsh(inertia).min() <= 0.0:
            raise ValueError(f"inertia must be symmetric and positive definite, got {inertia.tolist()}")
        as_array("velocity", self.velocity, (3,))
        as_array("angular_velocity", self.angular_velocity, (3,))

    def inverse_mass(self) -> Array:
        """Block ``diag(1/m, 1/m, 1/m, Q⁻¹)`` of M⁻¹, shape (6, 6)."""
        block = np.eye(6) / self.mass
        block[3:, 3:] = np.linalg.inv(np.asarray(self.inertia, dtype=np.float64))
        return block


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Touch:
    """A point where one body touches another, or the fixed world.

    Parameters
    ----------
    contact : Contact
        What the touching surfaces are like.
    normal : (3,) vector of any length
        Points from `other` (or the world) into `body`.
    body : int
        Index of the body.
    point : (3,) vector
        The contact point seen from the centre of mass of `body`, m.
    other : int or None
        Index of the other body, None for the world.
    other_point : (3,) vector
        The same point seen from the centre of mass of `other`, m.
    """

    contact: Contact
    normal: npt.ArrayLike
    body: int
    point: npt.ArrayLike
    other: int | None = None
    other_point: npt.ArrayLike = field(default=ZERO)

    def __post_init__(self) -> None:
        if not as_array("normal", self.normal, (3,)).any():
            raise ValueError(f"normal must not be zero, got {np.asarray(self.normal).tolist()}")
        as_array("point", self.point, (3,))
        as_array("other_point", self.other_point, (3,))


def assemble(bodies: Sequence[RigidBody], touches: Sequence[Touch]) -> ImpactSystem:
    """Put bodies and their contacts together into a system that `collide` can run.

    Parameters
    ----------
    bodies : sequence of RigidBody
        The bodies; each takes six numbers of the generalized velocity: velocity, then angular velocity.
    touches : sequence of Touch
        Where they touch.

    Returns
    -------
    ImpactSystem
        With three rows per contact.

    Examples
    --------
    A rod of 1 kg and 1 m falls level on two supports, of which the right one is dead. The rod leaves both,
    turning towards it:

    >>> from impact import collide
    >>> rod = RigidBody(mass=1.0, inertia=np.diag([1e-4, 1 / 12, 1 / 12]), velocity=(0, 0, -1))
    >>> ends = [Touch(contact=Contact(restitution=e, friction=0.3), normal=(0, 0, 1), body=0, point=(x, 0, 0))
    ...         for x, e in ((-0.5, 0.8), (0.5, 0.0))]
    >>> outcome = collide(assemble([rod], ends))
    >>> outcome.states
    ('{1,2}', '{1,2}', '{2}')
    >>> outcome.velocities[[2, 4]].round(4).tolist()
    [0.4279, 0.8558]
    """
    count = len(bodies)
    inverse_mass = np.zeros((6 * count, 6 * count))
    for index, body in enumerate(bodies):
        inverse_mass[6 * index : 6 * index + 6, 6 * index : 6 * index + 6] = body.inverse_mass()
    jacobian = np.zeros((len(touches), 3, 6 * count))
    for block, touch in zip(jacobian, touches, strict=True):
        _require_body("body", touch.body, count)
        block[:, 6 * touch.body : 6 * touch.body + 6] += _rows(touch.normal, touch.point)
        if touch.other is not None:
            _require_body("other", touch.other, count)
            block[:, 6 * touch.other : 6 * touch.other + 6] -= _rows(touch.normal, touch.other_point)
    return ImpactSystem(
        inverse_mass=inverse_mass,
        jacobian=jacobian,
        velocity=np.concatenate([np.r_[body.velocity, body.angular_velocity] for body in bodies]),
        contacts=[touch.contact for touch in touches],
    )


def _rows(normal: npt.ArrayLike, point: npt.ArrayLike) -> Array:
    """Velocity of a body's point along the contact frame: ``a · (v + ω × r) = a · v + (r × a) · ω``."""
    vector = np.asarray(normal, dtype=np.float64)
    frame = np.stack(tangent_frame(vector / np.linalg.norm(vector)))
    return np.hstack([frame, np.cross(np.asarray(point, dtype=np.float64), frame)])


def _require_body(name: str, index: int, count: int) -> None:
    if not 0 <= index < count:
        raise ValueError(f"{name} must be an index of bodies, 0 to {count - 1}, got {index}")
