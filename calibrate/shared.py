"""Errors that all trials have in common: no number of repeats averages them away, no scatter shows them.

A trial table may say what one standard deviation of such an error does to each velocity, in columns named
``approach_velocity_scale`` and so on for every one of `SOURCES` (m/s, signed; `_sd` includes them). A wrong
scale moves approach and rebound alike and hardly a ratio of the two; wrong drag moves a ratio, and that of
all trials by about as much.
"""

import numpy as np
import pandas as pd
from numpy.typing import NDArray

Array = NDArray[np.float64]

SOURCES = ("drag", "air", "scale", "rate", "gravity", "readout")


def shared_effects(rows: pd.DataFrame, velocity: str) -> Array:
    """Read what one standard deviation of each of the K sources does to a velocity of N trials, (N, K), m/s.

    Zero where the table does not tell.
    """
    effects = np.zeros((len(rows), len(SOURCES)))
    for index, source in enumerate(SOURCES):
        if (column := f"{velocity}_{source}") in rows:
            effects[:, index] = pd.to_numeric(rows[column], errors="coerce")
    return np.asarray(np.nan_to_num(effects))


def own_variance(rows: pd.DataFrame, velocity: str) -> Array:
    """Variance of a velocity of N trials that is a trial's own, (N,), (m/s)²; NaN where none is stated."""
    total = rows[f"{velocity}_sd"].to_numpy() ** 2
    shared = np.sum(shared_effects(rows, velocity) ** 2, axis=1)
    return np.asarray(np.maximum(total - shared, 0.0))


def softened(distances: Array, directions: Array) -> Array:
    """Let the common errors take their part of what separates predictions from measurements.

    Parameters
    ----------
    distances : ndarray (..., n)
        In standard deviations, independent.
    directions : ndarray (K, n)
        What one standard deviation of each common error does to them.

    Returns
    -------
    ndarray (..., n)
        Independent again: the sum of their squares is the smallest that any size of the common errors
        leaves, their own improbability included.

    Examples
    --------
    >>> softened(np.array([3.0, 4.0]), np.array([[0.0, 1.0]])).round(4).tolist()
    [3.0, 2.8284]
    """
    axes, sizes, _ = np.linalg.svd(directions.T, full_matrices=False)
    shrunk = 1 - 1 / np.sqrt(1 + sizes**2)
    return np.asarray(distances - (distances @ axes * shrunk) @ axes.T)
