"""Trial tables drawn from a known truth, to see what a design of experiment could tell."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from calibrate.model import LINEAR, rebound_ratios
from calibrate.trials import check_trials

_LOWER_MASS = 0.0027


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
    for mass_ratio, count in design.two.items():
        restitutions = [[truth.ball_ball, truth.ball_table]]
        ratios = rebound_ratios([truth.stiffness_ratio], restitutions, [mass_ratio], exponent=truth.exponent)
        rebounds = ratios * (1 + generator.normal(0.0, truth.rebound_scatter, (count, 2)))
        masses = {"upper_mass": mass_ratio * _LOWER_MASS, "lower_mass": _LOWER_MASS}
        tables.append(_table("two", rebounds).assign(**masses))
    return check_trials(pd.concat(tables, ignore_index=True))


def _table(kind: str, ratios: NDArray[np.float64]) -> pd.DataFrame:
    approach = -np.linspace(2.0, 4.0, len(ratios))
    columns = ("upper_rebound_velocity", "lower_rebound_velocity")
    rebounds = {column: -approach * ratio for column, ratio in zip(columns, ratios.T, strict=False)}
    names = [f"{kind}-{number:02d}" for number in range(len(ratios))]
    return pd.DataFrame({"trial": names, "kind": kind, "approach_velocity": approach, **rebounds})
