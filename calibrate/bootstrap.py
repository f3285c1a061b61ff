"""A second opinion on the stiffness ratio: how the best value moves when the trials are drawn again.

By trial, the trials of each kind and mass pair are drawn with replacement; parametric, new ones are drawn
from the best fit with the scatter seen. The profile's sets remain the answer: a bootstrap of few trials is
too narrow, and where several values compete it shows how often each would win. The model linearized once
around the best fit tells in which valleys an experiment may end; there it is refitted without linearizing.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from calibrate.box import Box, descend
from calibrate.estimate import Calibration
from calibrate.expectation import linear_profile
from calibrate.fit import Known, misfit_of
from calibrate.landscape import Landscape, landscape
from calibrate.misfit import Misfit
from calibrate.observed import mass_ratio_groups, usable_trials, usable_two_ball_trials
from calibrate.profile import RATIO_LIMITS
from calibrate.report import interval_text

Array = NDArray[np.float64]

_REBOUNDS = ["upper_rebound_velocity", "lower_rebound_velocity"]
_VALLEYS = 3  # lowest of the linearized model that are refitted


@dataclass(frozen=True, slots=True, kw_only=True)
class Bootstrap:
    """Best ratios of many experiments drawn again.

    Attributes
    ----------
    how : str
        ``by trial`` or ``parametric``.
    stiffness_ratio : tuple of float
        Best value of each, sorted.
    shares : tuple of (low, high, share)
        How many fall into each interval of the fit's 95 % set.

    Examples
    --------
    >>> print(Bootstrap(how="by trial", stiffness_ratio=(4.3, 9.9, 10.0, 10.1), shares=((9.5, 10.5, 0.75),)))
    bootstrap by trial, 4 times: best value 75% in 9.50 to 10.50, 25% elsewhere
    """

    how: str
    stiffness_ratio: tuple[float, ...]
    shares: tuple[tuple[float, float, float], ...]

    @property
    def elsewhere(self) -> float:
        """Share of best values outside the fit's 95 % set."""
        return max(0.0, 1.0 - sum(share for _, _, share in self.shares))

    def __str__(self) -> str:
        parts = [f"{share:.0%} in {interval_text((low, high))}" for low, high, share in self.shares]
        times = f"{len(self.stiffness_ratio)} times"
        return f"bootstrap {self.how}, {times}: best value {', '.join(parts)}, {self.elsewhere:.0%} elsewhere"


def bootstrap(
    trials: pd.DataFrame,
    calibration: Calibration,
    generator: np.random.Generator,
    times: int = 200,
    *,
    ball_ball: Known | None = None,
    ball_table: Known | None = None,
) -> tuple[Bootstrap, Bootstrap]:
    """Draw a fitted experiment again and again, by trial and from the fit.

    Parameters
    ----------
    trials : pandas.DataFrame
        What was fitted.
    calibration : Calibration
        The fit to it.
    generator : numpy.random.Generator
        Source of the draws.
    times : int
        How many of each kind.
    ball_ball, ball_table : (value, sd) or None
        As for the fit.

    Returns
    -------
    by_trial, parametric : Bootstrap

    Raises
    ------
    ValueError
        If `times` is below 1, or the fit rests on no two-ball trial.
    """
    if times < 1:
        raise ValueError(f"times must be at least 1, got {times}")

    def measured(table: pd.DataFrame) -> Misfit:
        return misfit_of(table, exponent=calibration.exponent, ball_ball=ball_ball, ball_table=ball_table)

    misfit, best = measured(trials), calibration.valleys[0]
    view = landscape(
        tuple(misfit.mass_ratios.tolist()), best.restitutions, (best.stiffness_ratio,), misfit.exponent
    )
    groups = _groups(trials)

    draws: dict[str, Callable[[], pd.DataFrame]] = {
        "by trial": lambda: _again(groups, generator),
        "parametric": lambda: _from_fit(groups, misfit, calibration, generator),
    }
    by_trial, parametric = (
        _counted(how, sorted(_best_ratio(measured(draw()), view) for _ in range(times)), calibration)
        for how, draw in draws.items()
    )
    return by_trial, parametric


def _best_ratio(misfit: Misfit, view: Landscape) -> float:
    """Refit from the lowest valleys of the linearized model, all three parameters at once."""
    pairs = range(len(misfit.mass_ratios))
    chi_square = linear_profile(view, pairs, misfit.rebounds, (misfit.ball_ball, misfit.ball_table))
    walled = np.concatenate([[np.inf], chi_square, [np.inf]])
    valleys = np.flatnonzero((chi_square <= walled[:-2]) & (chi_square <= walled[2:]))
    lowest = view.log_ratio[valleys[np.argsort(chi_square[valleys])[:_VALLEYS]]]
    low, high = np.log(RATIO_LIMITS)
    box = Box(
        low=np.array([low, 0.0, 0.0]),
        high=np.array([high, 1.0, 1.0]),
        free=(0, 1, 2),
        residuals=lambda points: misfit.residuals(points[:, 0], points[:, 1:]),
    )
    ends, heights = descend(box, np.insert(np.tile(view.restitutions, (len(lowest), 1)), 0, lowest, axis=1))
    return float(np.exp(ends[int(np.argmin(heights)), 0]))


def _groups(trials: pd.DataFrame) -> dict[str, list[pd.DataFrame]]:
    """Usable trials, by kind and mass pair."""
    two = usable_two_ball_trials(trials)
    numbers = mass_ratio_groups(two)
    return {
        "held": [usable_trials(trials, "held")],
        "plate": [usable_trials(trials, "plate")],
        "two": [two[numbers == number] for number in range(numbers.max() + 1)],
    }


def _again(groups: dict[str, list[pd.DataFrame]], generator: np.random.Generator) -> pd.DataFrame:
    """Draw the trials of each group with replacement."""
    tables = [
        table.iloc[generator.integers(len(table), size=len(table))]
        for kind in groups.values()
        for table in kind
        if len(table)
    ]
    return pd.concat(tables, ignore_index=True)


def _from_fit(
    groups: dict[str, list[pd.DataFrame]],
    misfit: Misfit,
    calibration: Calibration,
    generator: np.random.Generator,
) -> pd.DataFrame:
    """Draw new rebounds around what the best fit predicts."""
    best = calibration.valleys[0]
    tables = [
        _redrawn(table, np.array([restitution]), drops.covariance(), generator)
        for restitution, kind, drops in zip(
            best.restitutions, ("held", "plate"), (misfit.ball_ball, misfit.ball_table), strict=True
        )
        for table in groups[kind]
        if len(table) and drops is not None
    ]
    tables += [
        _redrawn(table, np.array(pair.fitted), misfit.rebounds.covariance(number), generator)
        for number, (table, pair) in enumerate(zip(groups["two"], calibration.pairs, strict=True))
    ]
    return pd.concat(tables, ignore_index=True)


def _redrawn(
    table: pd.DataFrame, fitted: Array, covariance: Array, generator: np.random.Generator
) -> pd.DataFrame:
    ratios = generator.multivariate_normal(fitted, covariance, size=len(table))
    speed = -table["approach_velocity"].to_numpy()[:, None]
    columns = _REBOUNDS[: len(fitted)]
    return table.assign(**dict(zip(columns, (ratios * speed).T, strict=True)))


def _counted(how: str, ratios: list[float], calibration: Calibration) -> Bootstrap:
    found = np.array(ratios)
    shares = tuple(
        (low, high, float(np.mean((found >= low) & (found <= high))))
        for low, high in calibration.stiffness_ratio.intervals_95
    )
    return Bootstrap(how=how, stiffness_ratio=tuple(ratios), shares=shares)
