"""Differential evolution over a few bounded parameters: it finds its way across jumps, as no descent does."""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import differential_evolution

from calibrate.box import Box

Array = NDArray[np.float64]

_GENERATIONS = 60
_MUTATION = (0.4, 0.9)
_SAME = 1e-3  # spread of chi-square over the population, relative, at which all have met


def evolve(box: Box, start: Array, seed: int = 0) -> Array:
    """Let a population of parameters evolve towards small chi-square.

    Parameters
    ----------
    box : Box
        What to make small.
    start : ndarray (N, P)
        The population, five or more within the bounds; fixed columns keep what the first of them holds.
    seed : int
        The same seed gives the same end.

    Returns
    -------
    ndarray (N, P)
        The last generation, best first.
    """
    free = list(box.free)

    def whole(points: Array) -> Array:
        rows = np.tile(start[0], (len(points), 1))
        rows[:, free] = points
        return rows

    found = differential_evolution(
        lambda points: box.chi_square(whole(points.T)),
        list(zip(box.low[free], box.high[free], strict=True)),
        init=start[:, free],
        maxiter=_GENERATIONS,
        mutation=_MUTATION,
        tol=_SAME,
        seed=np.random.default_rng(seed),
        polish=False,
        updating="deferred",
        vectorized=True,
    )
    order = np.argsort(found.population_energies, kind="stable")
    return whole(found.population[order])
