"""How large chi-square may be before a stiffness ratio counts as excluded.

The usual rule excludes a value when chi-square rises above its minimum by the quantile of one degree of
freedom. It presumes one smooth valley. Here several valleys compete, and one of them may by chance fit a
little better than the true one: simulated experiments show that the rule then excludes the truth two or
three times too often. So a value is excluded only if it also fits badly by itself: if its chi-square exceeds
the quantile for all the independent numbers measured less the two restitutions that are free at a given
ratio. However many valleys compete, the truth fails that second test no oftener than its quantile says.

Both tests seldom fail together, so both may be a little stricter than the confidence asked for: as strict as
lets half of the allowed misses happen where there is but one valley, and leaves the other half to competing
valleys.
"""

from functools import lru_cache

import numpy as np
from scipy import optimize, stats

_SLICES = 500  # of an integral over the chance of a rise


def limit(smallest: float, degrees_of_freedom: int, level: float) -> float:
    """Largest chi-square not excluded at a confidence level.

    Parameters
    ----------
    smallest : float
        Chi-square of the best fit.
    degrees_of_freedom : int
        Of the best fit: numbers measured less three.
    level : float
        Of confidence.

    Examples
    --------
    >>> round(limit(1.0, 1, 0.95), 2), round(limit(9.0, 1, 0.95), 2)
    (5.98, 12.83)
    >>> round(limit(1.0, 3, 0.95), 2), round(limit(9.0, 3, 0.95), 2)
    (8.54, 12.2)
    """
    freedom = max(degrees_of_freedom, 0)
    chance = _chance_of_each(freedom, 1 - level)
    return float(max(smallest + stats.chi2.isf(chance, 1), stats.chi2.isf(chance, freedom + 1)))


@lru_cache(maxsize=64)
def _chance_of_each(freedom: int, misses: float) -> float:
    """Chance with which each test may exclude the truth so that both do so in half of the misses allowed."""
    if freedom == 0 or _chance_of_both(misses, freedom) >= misses / 2:
        return misses
    return float(
        optimize.brentq(lambda chance: _chance_of_both(chance, freedom) - misses / 2, misses, 1 - 1e-6)
    )


def _chance_of_both(chance: float, freedom: int) -> float:
    """Chance that both tests exclude the truth, if the rise is independent of the smallest chi-square."""
    tails = chance * (np.arange(_SLICES) + 0.5) / _SLICES
    missing = stats.chi2.isf(chance, freedom + 1) - stats.chi2.isf(tails, 1)
    return float(chance * np.mean(stats.chi2.sf(np.maximum(missing, 0.0), freedom)))
