"""The bodies that collide: ball and cue."""

from __future__ import annotations

from dataclasses import dataclass

from impact._checks import require_positive, require_within


@dataclass(frozen=True, slots=True, kw_only=True)
class Ball:
    """A ball.

    Parameters
    ----------
    mass : float
        kg.
    radius : float
        m.
    inertia_factor : float
        Moment of inertia over ``mass * radius**2``: 2/5 for a solid ball, 2/3 for a thin shell (ping-pong).

    Raises
    ------
    ValueError
        If a value breaks its rule.

    Examples
    --------
    >>> Ball(mass=0.1673, radius=0.0286).inertia
    5.4737...e-05
    """

    mass: float
    radius: float
    inertia_factor: float = 0.4

    def __post_init__(self) -> None:
        require_positive("mass", self.mass)
        require_positive("radius", self.radius)
        require_within("inertia_factor", self.inertia_factor, 0.0, 2.0 / 3.0)
        require_positive("inertia_factor", self.inertia_factor)

    @property
    def inertia(self) -> float:
        """Moment of inertia about any axis through the centre, kg m²."""
        return self.inertia_factor * self.mass * self.radius**2


@dataclass(frozen=True, slots=True, kw_only=True)
class Cue:
    """A cue stick, which moves along its own axis only (paper, footnote 5).

    Parameters
    ----------
    mass : float
        kg.

    Raises
    ------
    ValueError
        If the mass is not positive.
    """

    mass: float

    def __post_init__(self) -> None:
        require_positive("mass", self.mass)
