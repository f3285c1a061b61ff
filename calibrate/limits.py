"""How large chi-square may be before a stiffness ratio counts as excluded.

The usual rule excludes a value when chi-square rises above its minimum by the quantile of one degree of
freedom. It presumes one smooth valley and well-known scatter. Here several valleys compete, and one of
them may by chance fit a little better than the true one; and few repeats know their scatter badly.
Simulated experiments show that the rule then excludes the truth two or three times too often. So a value
is excluded only if it also fits badly by itself: if its chi-square exceeds the quantile for the numbers
measured less those that refitting the restitutions takes up.
"""

from scipy import stats

_FEW = 4.0  # repeats with which refitting takes up half of what it does with many; found by simulation


def numbers_left(measured: int, fewest_repeats: float) -> float:
    """Count the numbers measured less those taken up by the two restitutions, refitted at a given ratio.

    With well-known scatter that is two. The fewer repeats, the slower chi-square grows with distance and the
    less a refit can lower it.

    Parameters
    ----------
    measured : int
        Independent numbers measured.
    fewest_repeats : float
        Smallest number of degrees of freedom any scatter was estimated with; may be infinite.

    Examples
    --------
    >>> numbers_left(6, 4.0), numbers_left(6, float("inf"))
    (5.0, 4.0)
    """
    taken = 2.0 / (1.0 + _FEW / fewest_repeats)
    return max(measured - taken, 1.0)


def limit(smallest: float, numbers: float, level: float) -> float:
    """Largest chi-square not excluded at a confidence level.

    Parameters
    ----------
    smallest : float
        Chi-square of the best fit.
    numbers : float
        As `numbers_left` counts them.
    level : float
        Of confidence.

    Examples
    --------
    >>> round(limit(1.0, 2.0, 0.95), 2), round(limit(9.0, 2.0, 0.95), 2)
    (5.99, 12.84)
    """
    rise, by_itself = stats.chi2.ppf(level, [1.0, numbers])
    return float(max(smallest + rise, by_itself))
