"""Fit the contacts of cue shots: tip and cloth, restitution, friction and stiffness ratio."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy import stats

from calibrate.box import Box, descend, profile
from calibrate.estimate import Estimate
from calibrate.evolution import evolve
from calibrate.files import write_whole
from calibrate.intervals import NOT_DETERMINED, ONE_VALUE, SEVERAL_VALUES, Interval, verdict
from calibrate.notebook import shots_html
from calibrate.sentences import Note
from calibrate.shot_table import observed_shots
from calibrate.shots import Shots
from impact import Ball, Cue

Array = NDArray[np.float64]

PARAMETERS: dict[str, Interval] = {
    "tip_ball_restitution": (0.0, 1.0),
    "tip_ball_friction": (0.01, 1.5),
    "stiffness_ratio": (0.1, 1e3),
    "ball_table_restitution": (0.0, 1.0),
    "ball_table_friction": (0.01, 1.0),
}
"""What is fitted, and how far it is searched: e_cb, mu_cb, k_bt/k_cb, e_bt, mu_bt."""

_NAMES = tuple(PARAMETERS)
_RATIO = _NAMES.index("stiffness_ratio")
_CLOTH = _NAMES.index("ball_table_friction")
_WIDEST = {"stiffness_ratio": float(np.log(4.0)), "tip_ball_friction": 0.5, "ball_table_friction": 0.3}
_WIDEST_RESTITUTION = 0.5
_BAD_FIT = 0.01
_MOST_TRIES = 3
_POLISHED = 16  # best of a population, from which it is descended


@dataclass(frozen=True, slots=True, kw_only=True)
class ShotCalibration:
    """Everything one fit to shots found; prints a line a parameter.

    Attributes
    ----------
    estimates : mapping of str to Estimate
        Of the parameters fitted, by the names in `PARAMETERS`; the ratio is k_bt/k_cb.
    fixed : mapping of str to float
        Those that were not fitted.
    shots : int
        How many were used.
    chi_square : float
        At the best fit.
    degrees_of_freedom : int
        Numbers measured less parameters fitted.
    notes : tuple of str
        What the reader has to know, in sentences.
    """

    estimates: Mapping[str, Estimate]
    fixed: Mapping[str, float]
    shots: int
    chi_square: float
    degrees_of_freedom: int
    notes: tuple[str, ...]

    def __str__(self) -> str:
        lines = [f"{name.replace('_', ' ')}: {estimate}" for name, estimate in self.estimates.items()]
        lines += [f"{name.replace('_', ' ')}: fixed at {value:g}" for name, value in self.fixed.items()]
        freedom = f"{self.degrees_of_freedom} degrees of freedom"
        lines.append(f"{self.shots} shots, chi-square {self.chi_square:.1f} for {freedom}")
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes)])

    def _repr_html_(self) -> str:
        return shots_html(self)

    def save(self, path: str | Path) -> Path:
        """Write as JSON, whole or not at all."""
        return write_whole(path, json.dumps(asdict(self), indent=1, ensure_ascii=False) + "\n")


def fit_shot(
    trials: pd.DataFrame, *, ball: Ball, cue: Cue, fixed: Mapping[str, float] | None = None
) -> ShotCalibration:
    """Fit e_cb, mu_cb, k_bt/k_cb, e_bt and mu_bt to the shots of a table.

    Each parameter has its own profile likelihood: chi-square with all others refitted. Where that is flat
    the verdict is ``not determined``: level strokes at or below the middle, for instance, never press the
    ball into the cloth and tell nothing about it.

    Parameters
    ----------
    trials : pandas.DataFrame
        As `read_trials` or `check_trials` returns it; for columns see `calibrate.shot_table`.
    ball, cue : Ball, Cue
        The ball and the stick.
    fixed : mapping of str to float, optional
        Parameters not to be fitted, by the names in `PARAMETERS`.

    Raises
    ------
    TrialTableError
        If no shot is usable.
    ValueError
        If a fixed parameter has no such name or lies outside its range, or all are fixed.
    """
    fixed = dict(fixed or {})
    _check(fixed)
    shots = observed_shots(trials, ball, cue)
    free = [column for column, name in enumerate(_NAMES) if name not in fixed]
    low, high = np.array([_scaled(name, PARAMETERS[name]) for name in _NAMES]).T
    start = (low + high) / 2
    for name, value in fixed.items():
        start[_NAMES.index(name)] = _scaled(name, (value, value))[0]
    box = Box(low=low, high=high, free=tuple(free), residuals=_residuals(shots, shots.covariance(start)))
    measured = int(np.isfinite(shots.measured).sum()) + (shots.cloth is not None)
    freedom = measured - len(free)
    box, best, seen = _best_of_tries(shots, box, start, freedom)
    smallest = float(box.chi_square(best[None])[0])
    estimates = {_NAMES[column]: _estimate(box, column, best, seen, freedom) for column in free}
    return ShotCalibration(
        estimates=estimates,
        fixed=fixed,
        shots=len(shots.names),
        chi_square=smallest,
        degrees_of_freedom=freedom,
        notes=(*shots.notes, *_notes(smallest, freedom, estimates)),
    )


def _check(fixed: Mapping[str, float]) -> None:
    for name, value in fixed.items():
        if name not in PARAMETERS:
            raise ValueError(f"fixed parameter must be one of {', '.join(_NAMES)}, got {name!r}")
        low, high = PARAMETERS[name]
        if not low <= value <= high:
            raise ValueError(f"{name} must be within [{low:g}, {high:g}], got {value:g}")
    if len(fixed) == len(PARAMETERS):
        raise ValueError("all parameters are fixed: nothing is left to fit")


def _scaled(name: str, pair: Interval) -> Interval:
    """Put the ends of an interval on the scale of the fit: the logarithm, for the ratio."""
    return (float(np.log(pair[0])), float(np.log(pair[1]))) if name == "stiffness_ratio" else pair


def _residuals(shots: Shots, covariance: Array) -> Callable[[Array], Array]:
    """Standardized residuals (N, R) of all shots, and of the cloth's friction, at parameters (N, 5)."""
    whiten = np.linalg.inv(np.linalg.cholesky(covariance))

    def residuals(parameters: Array) -> Array:
        off = np.nan_to_num(shots.predicted(parameters) - shots.measured)
        rows: Array = np.einsum("sij,nsj->nsi", whiten, off).reshape(len(parameters), -1)
        if shots.cloth is None:
            return rows
        mean, sd = shots.cloth
        return np.concatenate([rows, (parameters[:, [_CLOTH]] - mean) / sd], axis=1)

    return residuals


def _best_of_tries(shots: Shots, box: Box, start: Array, freedom: int) -> tuple[Box, Array, Array]:
    """Search until the fit is good, a few times at most.

    Gives the box with the aim's share in it, the best fit (P,), and all places seen (N, P), best first.
    """
    tries = []
    for seed in range(_MOST_TRIES):
        evolved, mine = evolve(box, start, seed), box
        ends = evolved.population[:_POLISHED]
        for _ in range(2):  # the aim's share of the covariance is taken at the best fit so far
            mine = replace(box, residuals=_residuals(shots, shots.covariance(ends[0])))
            ends, chi_square = descend(mine, ends)
            ends = ends[np.argsort(chi_square, kind="stable")[: (len(ends) + 1) // 2]]
        tries.append((float(chi_square.min()), mine, ends[0], evolved.tried))
        if freedom <= 0 or stats.chi2.sf(tries[-1][0], freedom) > _BAD_FIT:
            break
    _, box, best, seen = min(tries, key=lambda each: each[0])
    return box, best, seen


def _estimate(box: Box, column: int, best: Array, seen: Array, freedom: int) -> Estimate:
    name = _NAMES[column]
    smallest = float(box.chi_square(best[None])[0])
    excess = max(1.0, smallest / freedom) if freedom > 0 else 1.0
    rises = [excess * float(stats.chi2.ppf(level, 1)) for level in (0.68, 0.95)]
    curve = profile(box, column, best, seen, rises)
    inner, outer = (curve.below(float(curve.chi_square.min()) + rise) for rise in rises)
    limits = (float(box.low[column]) + 1e-6, float(box.high[column]) - 1e-6)
    word = verdict(outer, limits, _WIDEST.get(name, _WIDEST_RESTITUTION))
    back = np.exp if column == _RATIO else np.asarray
    value = float(back(curve.value[int(np.argmin(curve.chi_square))]))
    sets = [tuple((float(back(low)), float(back(high))) for low, high in level) for level in (inner, outer)]
    around = [(low, high) for low, high in sets[0] if low <= value <= high]
    return Estimate(
        value=value if word in (ONE_VALUE, SEVERAL_VALUES) else None,
        sd=(around[0][1] - around[0][0]) / 2 if word == ONE_VALUE and around else None,
        intervals_68=sets[0],
        intervals_95=sets[1],
        verdict=word,
    )


def _notes(smallest: float, freedom: int, estimates: Mapping[str, Estimate]) -> Sequence[str]:
    notes = []
    if freedom <= 0:
        notes.append(str(Note.SHOTS_TOO_FEW))
    elif (chance := float(stats.chi2.sf(smallest, freedom))) < _BAD_FIT:
        notes.append(Note.SHOTS_MISFIT.format(chance=f"{chance:.1g}"))
    flat = [name.replace("_", " ") for name, each in estimates.items() if each.verdict == NOT_DETERMINED]
    if flat:
        notes.append(Note.SHOTS_UNDETERMINED.format(names=", ".join(flat)))
    return notes
