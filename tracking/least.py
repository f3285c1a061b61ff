"""How far to trust a least-squares fit of a path in the plane."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
Function = Callable[[FloatArray], FloatArray]

STEP = 1e-6
NO_CORRELATION = 0.1  # the first lag with less ends the sum


def slopes(function: Function, values: FloatArray) -> FloatArray:
    """Change of a vector with each of its arguments by central differences, shape (results, arguments).

    Examples
    --------
    >>> slopes(lambda v: v**2, np.array([1.0, 3.0])).round(6).tolist()
    [[2.0, 0.0], [0.0, 6.0]]
    """
    columns = []
    for place, value in enumerate(values):
        step = np.zeros(len(values))
        step[place] = STEP * max(abs(float(value)), 1e-3)
        columns.append((function(values + step) - function(values - step)) / (2 * step[place]))
    return np.column_stack(columns)


def honest_covariance(
    function: Function, values: FloatArray, places: int, *, shared: FloatArray | None = None
) -> FloatArray:
    """Covariance of fitted values, widened where the residuals say so and never narrowed.

    They say so where frames scatter more than their rims tell, and where neighbouring frames err alike.

    Parameters
    ----------
    function : callable
        Values → residuals in standard deviations: first x and y of ``places`` frames in turn, then others.
    values : (n,) array
        Where the fit ended.
    places : int
        Number of frames.
    shared : (places, places) array, optional
        Covariance, in standard deviations, of errors that frames of like places share and no scatter shows.

    Returns
    -------
    (n, n) array
    """
    residuals = function(values)
    excess = max(1.0, float(residuals @ residuals) / max(len(residuals) - len(values), 1))
    slope = slopes(function, values)
    size = np.maximum(np.linalg.norm(slope, axis=0), 1e-300)
    inverse = np.linalg.pinv((slope / size).T @ (slope / size), rcond=1e-12) / np.outer(size, size)
    covariance = inverse * excess * _memory(residuals[: 2 * places].reshape(-1, 2))
    if shared is not None:
        gain = inverse @ slope[: 2 * places].T
        for axis in (gain[:, 0::2], gain[:, 1::2]):
            covariance += axis @ shared @ axis.T
    return np.asarray(covariance)


def _memory(apart: FloatArray) -> float:
    """How many times fewer independent frames there are: one and twice the correlations over all lags."""
    squares = float(np.sum(apart**2))
    total = 1.0
    for lag in range(1, len(apart) // 4):
        correlation = float(np.sum(apart[lag:] * apart[:-lag])) / squares if squares > 0 else 0.0
        if correlation < NO_CORRELATION:
            break
        total += 2 * correlation
    return total
