"""From rows of the trial table to the ratios the model predicts, repeats condensed and outliers set aside."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy import stats

from calibrate.repeats import Repeats, repeats_of
from calibrate.rows import TrialTableError
from calibrate.shared import own_variance, shared_effects

Array = NDArray[np.float64]

_SAME_MASS_RATIO = 0.01  # mass ratios this close (relative) count as one mass pair
_OUTLIER = 0.01  # chance that a harmless set of repeats loses a trial
_SPARE_REPEATS = 4  # of three trials two often agree by chance: that does not make the third an outlier


@dataclass(frozen=True, slots=True, kw_only=True)
class Observed:
    """Repeats of one kind of trial and the names of those that do not belong to them.

    Attributes
    ----------
    repeats : Repeats
        Without the outliers.
    trials : ndarray (J,)
        Number of trials in each group, outliers left out.
    outliers : tuple of str
        Names of trials that stand apart from their repeats.
    mass_ratios : ndarray (J,)
        Upper over lower mass of each group; empty for restitutions.
    """

    repeats: Repeats
    trials: NDArray[np.int64]
    outliers: tuple[str, ...]
    mass_ratios: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Found:
    """What a table of trials holds: drops on a held ball, on the plate, and of two balls; None where none."""

    held: Observed | None
    plate: Observed | None
    two: Observed | None


def found_in(trials: pd.DataFrame) -> Found:
    """Condense every kind of trial a table holds.

    Parameters
    ----------
    trials : pandas.DataFrame
        As `check_trials` returns it.

    Raises
    ------
    TrialTableError
        If no trial of kind plate, held or two is usable.
    """
    found = Found(
        held=observed_restitution(trials, "held"),
        plate=observed_restitution(trials, "plate"),
        two=observed_rebounds(trials),
    )
    if found.held is None and found.plate is None and found.two is None:
        if set(trials["kind"]) == {"pair"}:
            raise TrialTableError(
                "all trials are of kind pair, which needs no fit: each row has its own restitution; fit "
                "takes plate, held, two and shot"
            )
        raise TrialTableError(
            "no usable trial of kind plate, held or two; mend what the reasons in the table name, and run "
            "process again with --resume"
        )
    return found


def observed_restitution(trials: pd.DataFrame, kind: str) -> Observed | None:
    """Restitution from drops on the plate or on a held ball; None if there are none.

    Parameters
    ----------
    trials : pandas.DataFrame
        As `check_trials` returns it.
    kind : str
        ``plate`` or ``held``.
    """
    rows = usable_trials(trials, kind)
    if rows.empty:
        return None
    return _condensed(rows, ["upper_rebound_velocity"], np.zeros(len(rows), dtype=np.int64))


def observed_rebounds(trials: pd.DataFrame) -> Observed | None:
    """Rebound velocities over approach speed of each mass pair's first impacts; None if there are none.

    Parameters
    ----------
    trials : pandas.DataFrame
        As `check_trials` returns it.
    """
    rows = usable_two_ball_trials(trials)
    if rows.empty:
        return None
    return _condensed(rows, ["upper_rebound_velocity", "lower_rebound_velocity"], mass_ratio_groups(rows))


def usable_two_ball_trials(trials: pd.DataFrame) -> pd.DataFrame:
    """First impacts of the two-ball trials that are ok; later impacts are no simultaneous collisions."""
    return usable_trials(trials, "two").query("impact == 1")


def usable_trials(trials: pd.DataFrame, kind: str) -> pd.DataFrame:
    """Rows of one kind that are neither failed nor suspect."""
    return trials[(trials["kind"] == kind) & (trials["status"] == "ok")]


def _speed_ratios(rows: pd.DataFrame, columns: list[str]) -> tuple[Array, Array, Array]:
    """Rebound velocities over approach speed (N, p), their stated covariance (N, p, p), effects (N, K, p).

    The approach speed's own uncertainty moves all ratios of a trial together; a missing one counts as zero.
    What is common to all trials is no part of the covariance: the effects are. A rebound's uncertainty of
    zero counts as missing: nobody measures exactly.
    """
    speed = -rows["approach_velocity"].to_numpy()
    ratios = rows[columns].to_numpy() / speed[:, None]
    own = np.stack([own_variance(rows, column) for column in columns], axis=1) / speed[:, None] ** 2
    own[rows[[f"{column}_sd" for column in columns]].to_numpy() == 0.0] = np.nan
    common = np.sqrt(np.nan_to_num(own_variance(rows, "approach_velocity"))) / speed
    together = ratios * common[:, None]
    stated = np.stack([np.diag(variance) for variance in own])
    rebounds = np.stack([shared_effects(rows, column) for column in columns], axis=2)
    approach = shared_effects(rows, "approach_velocity")
    effects = (rebounds + approach[:, :, None] * ratios[:, None, :]) / speed[:, None, None]
    return ratios, stated + together[:, :, None] * together[:, None, :], effects


def mass_ratio_groups(rows: pd.DataFrame) -> NDArray[np.int64]:
    """Give each row the number of its mass pair, 0 … J-1 in rising order of upper over lower mass."""
    ratio = _mass_ratio(rows)
    order = np.argsort(ratio)
    steps = np.diff(np.log(ratio[order]), prepend=np.log(ratio[order[0]]))
    groups = np.empty(len(rows), dtype=np.int64)
    groups[order] = np.cumsum(steps > _SAME_MASS_RATIO)
    return groups


def _mass_ratio(rows: pd.DataFrame) -> Array:
    return np.asarray(rows["upper_mass"] / rows["lower_mass"], dtype=float)


def _condensed(rows: pd.DataFrame, columns: list[str], groups: NDArray[np.int64]) -> Observed:
    ratios, stated, effects = _speed_ratios(rows, columns)
    names = rows["trial"].to_numpy()
    kept = np.arange(len(rows))
    outliers: list[str] = []
    while True:
        repeats = repeats_of(ratios[kept], stated[kept], groups[kept], effects[kept])
        worst = _outlier(repeats)
        if worst is None:
            break
        outliers.append(str(names[kept[worst]]))
        kept = np.delete(kept, worst)
    counts = np.bincount(groups[kept])
    masses = np.bincount(groups[kept], weights=_mass_ratio(rows)[kept]) / counts
    return Observed(repeats=repeats, trials=counts, outliers=tuple(outliers), mass_ratios=masses)


def _outlier(repeats: Repeats) -> int | None:
    """Find the trial farthest from its repeats if chance hardly puts any so far (Wilks' outlier test)."""
    freedom, channels = repeats.degrees_of_freedom, repeats.means.shape[1]
    if not np.isfinite(freedom) or freedom < _SPARE_REPEATS + channels:
        return None
    share = np.minimum(repeats.deviations**2 / freedom, 1 - 1e-12)
    farness = share / (1 - share) * (freedom - channels) / channels
    chance = stats.f.sf(farness.max(), channels, freedom - channels) * len(farness)
    return int(np.argmax(farness)) if chance < _OUTLIER else None
