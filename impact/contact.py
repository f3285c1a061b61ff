"""A contact and the vocabulary of what can happen at it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntEnum

from impact._checks import require_at_least, require_nonnegative, require_positive, require_within


class Phase(IntEnum):
    """What the normal direction of a contact is doing."""

    INACTIVE = 0
    COMPRESSION = 1
    RESTITUTION = 2


class ContactMode(IntEnum):
    """What the tangent plane of a contact is doing.

    `STARTING` is a slide that begins out of rest: its direction is that of the tangential acceleration,
    because there is no slip velocity yet to take a direction from.
    """

    FRICTIONLESS = 0
    STICKING = 1
    STARTING = 2
    SLIDING = 3


class Event(Enum):
    """What ends a phase; the value is the letter used in `Segment.events`."""

    COMPRESSION_ENDS = "C"
    RESTITUTION_ENDS = "R"
    REACTIVATION = "A"


class RestitutionLaw(Enum):
    """When an active contact ends.

    `ENERGY` (the paper's law) ends restitution when the elastic energy has fallen to ``(1 - e²) E_max``.
    `POISSON` ends it when the normal impulse has reached ``(1 + e)`` times that of compression. With several
    contacts this may ask for more energy than the contact has stored; what is missing is then reported in
    `Collision.energy_borrowed`.
    """

    ENERGY = "energy"
    POISSON = "poisson"


@dataclass(frozen=True, slots=True, kw_only=True)
class Contact:
    """A point where two bodies touch, or a body touches the ground.

    Parameters
    ----------
    restitution : float
        Coefficient of restitution e, within [0, 1].
    friction : float
        Coefficient of Coulomb friction μ, at least 0.
    stiffness : float
        Stiffness k of the virtual spring. As long as all contacts share one exponent only the ratios of
        stiffnesses matter (Theorem 1), so any unit will do; otherwise N/m**exponent.
    exponent : float
        η in the normal force ``k δ**η`` at compression depth δ: 1 is the paper's linear spring, 1.5 is Hertz.

    Raises
    ------
    ValueError
        If a value breaks its rule.

    Examples
    --------
    >>> Contact(restitution=0.9, stiffness=10.0)
    Contact(restitution=0.9, friction=0.0, stiffness=10.0, exponent=1.0)
    >>> Contact(restitution=1.2)
    Traceback (most recent call last):
    ValueError: restitution must be within [0, 1], got 1.2
    """

    restitution: float
    friction: float = 0.0
    stiffness: float = 1.0
    exponent: float = 1.0

    def __post_init__(self) -> None:
        require_within("restitution", self.restitution, 0.0, 1.0)
        require_nonnegative("friction", self.friction)
        require_positive("stiffness", self.stiffness)
        require_at_least("exponent", self.exponent, 1.0)
