"""What few repeats are worth: how far their spread is believed, and how improbable distances by it are."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import stats

Array = NDArray[np.float64]

_HIGHEST_CORRELATION = (
    0.999  # of two numbers; two different trials, each seen twice, would show a perfect one
)


def equivalent_chi_square(white: Array, freedom: float) -> Array:
    """Give the chi-square, of J p degrees of freedom, that is as improbable as some distances.

    Parameters
    ----------
    white : ndarray (..., J, p)
        Distances of J groups of p numbers from a prediction, in standard deviations that were estimated.
    freedom : float
        Degrees of freedom of that estimate.

    Examples
    --------
    Four standard deviations by eleven repeats are hardly three by their true scatter:

    >>> equivalent_chi_square(np.array([[4.0]]), 10.0).round(2).item()
    9.13
    """
    groups, channels = white.shape[-2:]
    hypothesis = np.swapaxes(white, -1, -2) @ white / freedom
    log_lambda = np.log(np.linalg.det(np.eye(channels) + hypothesis))
    abscissa, ordinate = _law(groups, channels, freedom)
    beyond = np.maximum(log_lambda - abscissa[-1], 0.0)
    slope = (ordinate[-1] - ordinate[-2]) / (abscissa[-1] - abscissa[-2])
    return np.asarray(np.interp(log_lambda, abscissa, ordinate) + slope * beyond)


def at_least(spread: Array, floor: Array) -> Array:
    """Raise the variances of a spread (p, p) to a floor (p,); from so little no correlation is believed."""
    variances = np.diagonal(spread)
    if np.all(variances >= floor):
        strict = _HIGHEST_CORRELATION * spread
        np.fill_diagonal(strict, variances)
        perfect = np.linalg.det(spread) < (1 - _HIGHEST_CORRELATION**2) * np.prod(variances)
        return strict if perfect else spread
    scale = np.sqrt(np.maximum(floor / np.maximum(variances, 1e-300), 1.0))
    raised = spread * np.outer(scale, scale)
    return np.diag(np.maximum(np.diagonal(raised), floor))


@lru_cache(maxsize=64)
def _law(groups: int, channels: int, freedom: float) -> tuple[Array, Array]:
    """Tabulate the chi-square as improbable as each -log(Wilks' lambda): Rao's F, exact for p = 1 and 2."""
    abscissa = np.linspace(0.0, 8.0, 800) ** 2
    root = np.expm1(abscissa / channels)
    errors = freedom - channels + 1
    tail = stats.f.sf(root * errors / groups, channels * groups, channels * errors)
    believable = tail > 1e-250
    return abscissa[believable], stats.chi2.isf(tail[believable], channels * groups)
