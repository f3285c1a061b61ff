"""The impact model as the fit needs it: velocity ratios of a two-ball drop for many parameters at once."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from impact import Ball, Contact, ConvergenceError, ManyDrops, TwoBallDrop, collide, collide_many

LINEAR, HERTZ = 1.0, 1.5
"""Exponents of the force law: the paper's linear spring and Hertz' contact of two spheres."""

_WORTH_THREADS = 200  # collisions: to start a thread takes as long as fifty


def rebound_ratios(
    stiffness_ratio: ArrayLike,
    restitutions: ArrayLike,
    mass_ratio: ArrayLike,
    *,
    exponent: float = LINEAR,
) -> NDArray[np.float64]:
    """Rebound velocities over the approach speed, which is all a drop can tell (Theorem 4).

    Parameters
    ----------
    stiffness_ratio : array_like (N,)
        Ball-table stiffness over ball-ball stiffness, k2/k1.
    restitutions : array_like (N, 2)
        Ball-ball and ball-table restitution.
    mass_ratio : array_like (N,)
        Upper mass over lower mass.
    exponent : float
        Of the force law at both contacts.

    Returns
    -------
    ndarray (N, 2)
        v1 / |v0| and v2 / |v0|, up positive.

    Examples
    --------
    The paper's Fig. 5:

    >>> rebound_ratios([10.0], [[0.807755, 0.846529]], [1.0]).round(5).tolist()
    [[0.7794, 0.18664]]
    """
    many = _outcomes(np.asarray(stiffness_ratio, dtype=float), restitutions, mass_ratio, exponent)
    return np.asarray(many.velocities)


def state_sequences(
    log_ratio: ArrayLike, restitutions: ArrayLike, mass_ratio: ArrayLike, *, exponent: float = LINEAR
) -> Sequence[tuple[str, ...]]:
    """Give the states of many collisions; arguments as for `rebound_ratios`, the ratio as its logarithm."""
    return _outcomes(np.exp(log_ratio), restitutions, mass_ratio, exponent).states


def _outcomes(
    stiffness_ratio: NDArray[np.float64], restitutions: ArrayLike, mass_ratio: ArrayLike, exponent: float
) -> ManyDrops:
    ball_ball, ball_table = np.asarray(restitutions, dtype=float).T
    try:
        return collide_many(
            two_ball_drop(1.0, (1.0, 1.0), 1.0, exponent=exponent),
            stiffness_ratio=stiffness_ratio,
            ball_ball_restitution=ball_ball,
            ball_table_restitution=ball_table,
            upper_mass=np.asarray(mass_ratio, dtype=float),
            threads=None if len(ball_ball) >= _WORTH_THREADS else 1,
        )
    except ConvergenceError as error:  # endless collapse (Theorem 3): what is left to happen is negligible
        partial: ManyDrops = error.partial
        return partial


def state_sequence(
    stiffness_ratio: float, restitutions: tuple[float, float], mass_ratio: float, *, exponent: float = LINEAR
) -> tuple[str, ...]:
    """States a single collision goes through, such as ``("S1", "S3", "S1", "S2")``."""
    try:
        collision = collide(two_ball_drop(stiffness_ratio, restitutions, mass_ratio, exponent=exponent))
    except ConvergenceError as error:
        collision = error.partial
    return tuple(collision.states)


def two_ball_drop(
    stiffness_ratio: float, restitutions: tuple[float, float], mass_ratio: float, *, exponent: float = LINEAR
) -> TwoBallDrop:
    """Build the drop with unit lower mass, unit ball-ball stiffness and unit approach speed."""
    ball_ball, ball_table = restitutions
    return TwoBallDrop(
        upper=Ball(mass=mass_ratio, radius=0.020),
        lower=Ball(mass=1.0, radius=0.020),
        ball_ball=Contact(restitution=ball_ball, stiffness=1.0, exponent=exponent),
        ball_table=Contact(restitution=ball_table, stiffness=stiffness_ratio, exponent=exponent),
        approach_velocity=-1.0,
    )
