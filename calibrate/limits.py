"""How large chi-square may be before a stiffness ratio counts as excluded.

The usual rule excludes a value when chi-square rises above its minimum by the quantile of one degree of
freedom. It presumes one smooth valley and well-known scatter. Here several valleys compete, and one of
them may by chance fit a little better than the true one; and few repeats know their scatter badly.
Simulated experiments show that the rule then excludes the truth two or three times too often. So a value
is excluded only if it also fits badly by itself: if its chi-square exceeds the quantile for all the
independent numbers measured less the two restitutions that are free at a given ratio.
"""

from scipy import stats


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
    (5.99, 12.84)
    """
    rise = stats.chi2.ppf(level, 1)
    by_itself = stats.chi2.ppf(level, max(degrees_of_freedom, 0) + 1)
    return float(max(smallest + rise, by_itself))
