"""How large chi-square may be before a stiffness ratio counts as excluded.

Near the best fit the usual rule holds: a value is excluded when chi-square rises by the quantile of one
degree of freedom. That rule presumes one smooth valley. Here other valleys compete, and one of them may by
chance fit a little better than the true one; measured against such a winner, the truth would be excluded too
often. A valley other than the best is therefore excluded only if it fits badly by itself: if its chi-square
exceeds the quantile for all the independent numbers measured less the two restitutions.
"""

import numpy as np
from numpy.typing import NDArray
from scipy import stats

Array = NDArray[np.float64]

_RIPPLE = 0.05  # a fall of chi-square smaller than this is no new valley, only an imperfect search


def rise_allowed(level: float) -> float:
    """Rise of chi-square in the best valley that excludes a value at a confidence level.

    Examples
    --------
    >>> round(rise_allowed(0.95), 3)
    3.841
    """
    return float(stats.chi2.ppf(level, 1))


def limits(chi_square: Array, degrees_of_freedom: int, level: float) -> Array:
    """Largest chi-square not excluded, at each point of a profile.

    Parameters
    ----------
    chi_square : ndarray (G,)
        Profile, in order of the ratio.
    degrees_of_freedom : int
        Of the best fit with all parameters free.
    level : float
        Of confidence.

    Returns
    -------
    ndarray (G,)
        Lower in the valley of the best fit than elsewhere.

    Examples
    --------
    >>> limits(np.array([9.0, 4.5, 9.0, 1.0, 4.5, 9.0]), degrees_of_freedom=1, level=0.95).round(1).tolist()
    [6.0, 6.0, 4.8, 4.8, 4.8, 4.8]
    """
    near = chi_square.min() + rise_allowed(level)
    by_itself = float(stats.chi2.ppf(level, max(degrees_of_freedom, 0) + 1))
    return np.asarray(np.where(_best_valley(chi_square), near, max(near, by_itself)))


def _best_valley(chi_square: Array) -> NDArray[np.bool_]:
    """Mark the stretch around the smallest chi-square on which it rises away from there."""
    best = int(np.argmin(chi_square))
    valley = np.zeros(len(chi_square), dtype=np.bool_)
    valley[best - _rising(chi_square[best::-1]) + 1 : best + _rising(chi_square[best:])] = True
    return valley


def _rising(outward: Array) -> int:
    """Count the points before chi-square first falls clearly below its largest value so far."""
    falls = np.flatnonzero(outward < np.maximum.accumulate(outward) - _RIPPLE)
    return int(falls[0]) if falls.size else len(outward)
