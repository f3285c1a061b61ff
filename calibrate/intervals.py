"""Confidence sets that may be unions of intervals, and what they amount to in words."""

from collections.abc import Iterable

from scipy.special import chdtrc

Interval = tuple[float, float]

ONE_VALUE = "one value"
SEVERAL_VALUES = "several values"
BOUNDED_ON_ONE_SIDE = "bounded on one side"
NOT_DETERMINED = "not determined"

BAD_FIT = 0.01
"""Chance of a larger chi-square below which a model is said to miss the data."""


def joined(intervals: Iterable[Interval], gap: float) -> tuple[Interval, ...]:
    """Unite intervals that overlap or are closer together than a gap.

    Examples
    --------
    >>> joined([(4.0, 5.0), (1.0, 2.0), (2.01, 3.0)], gap=0.1)
    ((1.0, 3.0), (4.0, 5.0))
    """
    united: list[Interval] = []
    for low, high in sorted(intervals):
        if united and low <= united[-1][1] + gap:
            before = united.pop()
            low, high = before[0], max(before[1], high)
        united.append((low, high))
    return tuple(united)


def verdict(intervals: tuple[Interval, ...], limits: Interval, widest: float) -> str:
    """Say in words what a confidence set amounts to.

    Parameters
    ----------
    intervals : tuple of (low, high)
        The set, on a scale on which differences are meaningful (the logarithm, for a ratio).
    limits : (low, high)
        What is searched; an interval that reaches a limit is open on that side.
    widest : float
        An interval wider than this is no value.

    Returns
    -------
    str
        ``one value``, ``several values``, ``bounded on one side`` or ``not determined``.

    Examples
    --------
    >>> verdict(((0.8, 0.9),), limits=(0.0, 1.0), widest=0.3)
    'one value'
    >>> verdict(((0.7, 1.0),), limits=(0.0, 1.0), widest=0.2)
    'bounded on one side'
    """
    open_below, open_above = intervals[0][0] <= limits[0], intervals[-1][1] >= limits[1]
    if any(high - low > widest and low > limits[0] and high < limits[1] for low, high in intervals):
        return NOT_DETERMINED
    if open_below and open_above:
        return NOT_DETERMINED
    if len(intervals) > 1:
        return SEVERAL_VALUES
    return BOUNDED_ON_ONE_SIDE if open_below or open_above else ONE_VALUE


def chance_of(chi_square: float, degrees_of_freedom: int) -> float:
    """Probability that the true model is farther from the data than this; 1 with nothing to judge it by.

    Examples
    --------
    >>> round(chance_of(11.34, 3), 4)
    0.01
    """
    return float(chdtrc(degrees_of_freedom, chi_square)) if degrees_of_freedom > 0 else 1.0
