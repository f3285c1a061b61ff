"""Trial tables drawn from a known truth, to see what a design of experiment could tell."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from calibrate.model import LINEAR, rebound_ratios
from calibrate.trials import check_trials

_LOWER_MASS = 0.0027
_FEWEST = 3  # trials that can scatter in two numbers without correlation


@dataclass(frozen=True, slots=True, kw_only=True)
class Truth:
    """What nature is told to do: the parameters, and how much single trials stray from them.

    Attributes
    ----------
    stiffness_ratio : float
        Ball-table over ball-ball.
    ball_ball, ball_table : float
        Restitutions.
    exponent : float
        Of the force law.
    restitution_scatter : float
        Of the restitution of each plate and held drop, absolute.
    rebound_scatter : (float, float)
        Of the upper and the lower rebound velocity of each two-ball trial, relative.
    """

    stiffness_ratio: float
    ball_ball: float
    ball_table: float
    exponent: float = LINEAR
    restitution_scatter: float = 0.004
    rebound_scatter: tuple[float, float] = (0.004, 0.01)


@dataclass(frozen=True, slots=True, kw_only=True)
class Design:
    """How many trials of each kind; `two` maps mass ratios, upper over lower, to numbers of trials."""

    plate: int = 3
    held: int = 3
    two: Mapping[float, int] = field(default_factory=lambda: {1.0: 4, 2.0: 2})


def simulate_trials(truth: Truth, design: Design, generator: np.random.Generator) -> pd.DataFrame:
    """Draw a trial table.

    Parameters
    ----------
    truth : Truth
        Parameters and scatter.
    design : Design
        Numbers of trials; approach velocities spread evenly from -2 to -4 m/s.
    generator : numpy.random.Generator
        Source of the scatter.

    Returns
    -------
    pandas.DataFrame
        As `check_trials` returns it, without stated uncertainties.

    Examples
    --------
    >>> truth = Truth(stiffness_ratio=10.0, ball_ball=0.81, ball_table=0.85)
    >>> len(simulate_trials(truth, Design(), np.random.default_rng(1)))
    12
    """
    single = [("plate", truth.ball_table, design.plate), ("held", truth.ball_ball, design.held)]
    tables = [
        _table(kind, generator.normal(mean, truth.restitution_scatter, (count, 1)))
        for kind, mean, count in single
    ]
    tables += [
        _two_balls(truth, mass_ratio, generator.normal(0.0, truth.rebound_scatter, (count, 2)))
        for mass_ratio, count in design.two.items()
    ]
    return check_trials(pd.concat(tables, ignore_index=True))


def typical_trials(truth: Truth, two: Mapping[float, int]) -> pd.DataFrame:
    """Make a table of two-ball trials whose scatter is exactly as stated, without any luck.

    Parameters
    ----------
    truth : Truth
        Parameters and scatter.
    two : mapping of float to int
        Mass ratios, upper over lower, to numbers of trials, three or more each.

    Returns
    -------
    pandas.DataFrame
        As `check_trials` returns it; of each mass pair the errors of both rebounds have mean zero, the stated
        standard deviation, and no correlation.

    Raises
    ------
    ValueError
        If a mass ratio has fewer than three trials.
    """
    for mass_ratio, count in two.items():
        if count < _FEWEST:
            raise ValueError(f"trials must be at least {_FEWEST}, got {count} of mass ratio {mass_ratio:g}")
    generator = np.random.default_rng(0)
    tables = []
    for mass_ratio, count in two.items():
        drawn = generator.normal(size=(count, 2))
        drawn -= drawn.mean(axis=0)
        independent = np.linalg.solve(np.linalg.cholesky(np.cov(drawn.T)), drawn.T).T
        tables.append(_two_balls(truth, mass_ratio, independent * truth.rebound_scatter))
    return check_trials(pd.concat(tables, ignore_index=True))


def _two_balls(truth: Truth, mass_ratio: float, errors: NDArray[np.float64]) -> pd.DataFrame:
    """Trials with one pair of masses and relative errors (N, 2)."""
    restitutions = [[truth.ball_ball, truth.ball_table]]
    ratios = rebound_ratios([truth.stiffness_ratio], restitutions, [mass_ratio], exponent=truth.exponent)
    masses = {"upper_mass": mass_ratio * _LOWER_MASS, "lower_mass": _LOWER_MASS}
    return _table("two", ratios * (1 + errors)).assign(**masses)


def _table(kind: str, ratios: NDArray[np.float64]) -> pd.DataFrame:
    approach = -np.linspace(2.0, 4.0, len(ratios))
    columns = ("upper_rebound_velocity", "lower_rebound_velocity")
    rebounds = {column: -approach * ratio for column, ratio in zip(columns, ratios.T, strict=False)}
    names = [f"{kind}-{number:02d}" for number in range(len(ratios))]
    return pd.DataFrame({"trial": names, "kind": kind, "approach_velocity": approach, **rebounds})
