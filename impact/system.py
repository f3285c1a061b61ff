"""Any set of bodies and contacts, reduced to what the state transition diagram needs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from impact._checks import Array, as_array
from impact.contact import Contact

if TYPE_CHECKING:
    from impact.collision import Collision

TWO_CONTACT_STATES: Mapping[frozenset[int], str] = {
    frozenset({0, 1}): "S1",
    frozenset({1}): "S2",
    frozenset({0}): "S3",
}
"""The paper's names: both impacts active, only the lower (table), only the upper (ball-ball, tip-ball)."""


@dataclass(frozen=True, slots=True, init=False, eq=False)
class ImpactSystem:
    """Bodies and contacts in generalized coordinates.

    With generalized velocity v the contact velocities are ``u = J v``, and contact impulses p change the
    velocity by ``M⁻¹ Jᵀ p``. Every scene of this package is such a system; build your own to collide others.

    Parameters
    ----------
    inverse_mass : (d, d) array
        M⁻¹, symmetric, in 1/kg (and 1/(kg m²) for rotations).
    jacobian : (n, r, d) array
        J. Row 0 of a contact gives its normal velocity, positive while the two bodies part. With friction
        r = 3 and rows 1 and 2 give the velocity along two unit tangents; without friction r = 1.
    velocity : (d,) array
        Generalized velocity v before the collision.
    contacts : sequence of n Contact
        The contacts, in the order of `jacobian`.
    state_names : mapping from frozenset of contact indices (from 0) to str
        What to call a set of active contacts. A set without a name prints as ``{1,2}``, counting from 1.

    Raises
    ------
    ValueError
        If shapes do not fit, a value is not finite, or a contact has friction but no tangents.

    Examples
    --------
    A ball of 2 kg falls on the ground at 3 m/s:

    >>> from impact import Contact, collide
    >>> ball = ImpactSystem(inverse_mass=[[0.5]], jacobian=[[[1.0]]], velocity=[-3.0],
    ...                     contacts=[Contact(restitution=0.5)])
    >>> print(collide(ball))
    velocities 1.5 in state {1}; energy loss 6.75 J
    """

    inverse_mass: Array
    jacobian: Array
    velocity: Array
    contacts: Sequence[Contact]
    state_names: Mapping[frozenset[int], str]

    def __init__(
        self,
        *,
        inverse_mass: npt.ArrayLike,
        jacobian: npt.ArrayLike,
        velocity: npt.ArrayLike,
        contacts: Sequence[Contact],
        state_names: Mapping[frozenset[int], str] | None = None,
    ) -> None:
        degrees = np.size(velocity)
        rows = _rows_per_contact(jacobian)
        set_field = object.__setattr__
        set_field(self, "velocity", as_array("velocity", velocity, (degrees,)))
        set_field(self, "inverse_mass", as_array("inverse_mass", inverse_mass, (degrees, degrees)))
        set_field(self, "jacobian", as_array("jacobian", jacobian, (len(contacts), rows, degrees)))
        set_field(self, "contacts", tuple(contacts))
        set_field(self, "state_names", dict(state_names or {}))
        if rows == 1 and any(contact.friction > 0.0 for contact in contacts):
            raise ValueError("jacobian must have 3 rows per contact where a contact has friction, got 1")

    def system(self) -> ImpactSystem:
        """Return itself: a system is the simplest scene."""
        return self

    def outcome(self, collision: Collision) -> Collision:
        """Return the collision as it is."""
        return collision


def _rows_per_contact(jacobian: npt.ArrayLike) -> int:
    shape = np.shape(jacobian)
    if len(shape) != 3 or shape[1] not in (1, 3):
        raise ValueError(f"jacobian must have shape (contacts, 1 or 3, degrees of freedom), got {shape}")
    return int(shape[1])
