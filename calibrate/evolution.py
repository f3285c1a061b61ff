"""Differential evolution over a few bounded parameters: it finds its way across jumps, as no descent does."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import differential_evolution

from calibrate.box import Box

Array = NDArray[np.float64]

_POPULATION = 12  # for each free parameter
_GENERATIONS = 60
_MUTATION = (0.4, 0.9)
_FAR = 5.0  # standard deviations from which on a residual counts less: beyond a jump all are far


@dataclass(frozen=True, slots=True, kw_only=True)
class Evolved:
    """What a population saw: its last generation (N, P) and every point tried (M, P), both best first."""

    population: Array
    tried: Array


def evolve(box: Box, start: Array, seed: int = 0) -> Evolved:
    """Let a population of parameters evolve towards small residuals.

    Parameters
    ----------
    box : Box
        What to make small.
    start : ndarray (P,)
        Values of the columns that are not free.
    seed : int
        The same seed gives the same end.
    """
    free = list(box.free)
    tried: list[Array] = []
    costs: list[Array] = []

    def whole(points: Array) -> Array:
        rows = np.tile(start, (len(points), 1))
        rows[:, free] = points
        return rows

    def cost(points: Array) -> Array:
        tried.append(whole(points.T))
        costs.append(np.sum(np.log1p((box.residuals(tried[-1]) / _FAR) ** 2), axis=1))
        return np.asarray(costs[-1])

    found = differential_evolution(
        cost,
        list(zip(box.low[free], box.high[free], strict=True)),
        init="sobol",
        maxiter=_GENERATIONS,
        mutation=_MUTATION,
        polish=False,
        popsize=_POPULATION,
        seed=np.random.default_rng(seed),
        updating="deferred",
        vectorized=True,
    )
    order, orders = (
        np.argsort(cost, kind="stable") for cost in (found.population_energies, np.concatenate(costs))
    )
    return Evolved(population=whole(found.population[order]), tried=np.concatenate(tried)[orders])
