"""Fit restitution and stiffness ratio to a table of trials."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from calibrate.estimate import Calibration, Curve, Estimate, MassPair
from calibrate.intervals import NOT_DETERMINED, ONE_VALUE, SEVERAL_VALUES, Interval, joined, verdict
from calibrate.misfit import Misfit
from calibrate.model import LINEAR, state_sequence
from calibrate.notes import OwnDrops, notes_on_fit, notes_on_trials
from calibrate.observed import Found, Observed, found_in, observed_restitution
from calibrate.profile import LEVELS, RATIO_LIMITS, Profile, propagate, trace_profile
from calibrate.repeats import Repeats, known

Array = NDArray[np.float64]
Known = tuple[float, float]

_RESTITUTION_LIMITS = (0.0, 1.0)
_WIDEST_RESTITUTION = 0.5
_SAME_RESTITUTION = 0.005  # intervals closer together than this are one
_WIDEST_RATIO = 4.0  # a 95 % interval that spans a larger factor does not name a value
_UNKNOWN_RESTITUTION = Estimate(
    value=None,
    sd=None,
    intervals_68=(_RESTITUTION_LIMITS,),
    intervals_95=(_RESTITUTION_LIMITS,),
    verdict=NOT_DETERMINED,
)
_UNKNOWN_RATIO = Estimate(
    value=None, sd=None, intervals_68=(RATIO_LIMITS,), intervals_95=(RATIO_LIMITS,), verdict=NOT_DETERMINED
)


def fit_restitution(trials: pd.DataFrame, kind: str) -> Estimate:
    """Estimate a restitution from its own drops, weighted and with their scatter seen.

    Parameters
    ----------
    trials : pandas.DataFrame
        As `read_trials` or `check_trials` returns it; rows of other kinds and rows not ``ok`` are left out.
    kind : str
        ``plate`` for ball on plate, ``held`` for ball on a held ball.

    Returns
    -------
    Estimate
        Weighted mean, its standard deviation, and Student's intervals.

    Raises
    ------
    ValueError
        If the kind is another one, or there is no usable trial of it.

    Examples
    --------
    >>> from calibrate.trials import check_trials
    >>> drops = pd.DataFrame({"kind": "plate", "approach_velocity": [-2.0, -2.0, -4.0],
    ...                       "upper_rebound_velocity": [1.68, 1.70, 3.44]})
    >>> print(fit_restitution(check_trials(drops), "plate"))
    one value: 0.8500 ± 0.0058 (95 %: 0.825 to 0.875)
    """
    if kind not in ("plate", "held"):
        raise ValueError(f"kind must be plate or held, got {kind!r}")
    found = observed_restitution(trials, kind)
    if found is None:
        raise ValueError(f"no usable trial of kind {kind!r}")
    return _from_own_drops(found.repeats)


def fit_stiffness_ratio(
    trials: pd.DataFrame,
    *,
    exponent: float = LINEAR,
    ball_ball: Known | None = None,
    ball_table: Known | None = None,
    provenance: Mapping[str, Any] | None = None,
) -> Calibration:
    """Fit both restitutions and the stiffness ratio to all trials together.

    The ratio's confidence set comes from the profile likelihood and may be several intervals; see
    `calibrate.profile`. How much trials scatter is estimated from the trials; see `calibrate.repeats`.

    Parameters
    ----------
    trials : pandas.DataFrame
        As `read_trials` or `check_trials` returns it. Failed and suspect rows are left out, and of two-ball
        recordings all impacts after the first.
    exponent : float
        Of the force law at both contacts: 1 for the paper's linear spring, 1.5 for Hertz.
    ball_ball, ball_table : (value, sd) or None
        A restitution known from elsewhere, used instead of the drops in the table.
    provenance : mapping, optional
        Kept in the result.

    Returns
    -------
    Calibration
        Without two-ball trials its stiffness ratio is ``not determined``, with the restitutions still there.

    Raises
    ------
    TrialTableError
        If no trial of kind plate, held or two is usable.
    """
    found = found_in(trials)
    own = (_own(ball_ball, found.held), _own(ball_table, found.plate))
    if found.two is None:
        return _without_two_balls(trials, found, own, exponent, provenance or {})
    misfit = Misfit(
        ball_ball=own[0],
        ball_table=own[1],
        rebounds=found.two.repeats,
        mass_ratios=found.two.mass_ratios,
        exponent=exponent,
    )
    profile = trace_profile(misfit)
    pairs = _pairs(misfit, profile, found.two)
    ratio = _stiffness_estimate(profile)
    ball_ball_estimate, ball_table_estimate = _restitution_estimates(misfit, profile)
    return Calibration(
        restitution_ball_ball=ball_ball_estimate,
        restitution_ball_table=ball_table_estimate,
        stiffness_ratio=ratio,
        states=pairs[int(np.argmax(found.two.trials))].states,
        pairs=pairs,
        chi_square=profile.basins[0].chi_square,
        degrees_of_freedom=misfit.degrees_of_freedom,
        exponent=exponent,
        notes=(*notes_on_trials(trials, found, own), *notes_on_fit(misfit, profile, ratio)),
        profile=_curve(profile),
        provenance=provenance or {},
    )


def _own(known_value: Known | None, drops: Observed | None) -> Repeats | None:
    if known_value is not None:
        return known(*known_value)
    return None if drops is None else drops.repeats


def _without_two_balls(
    trials: pd.DataFrame, found: Found, own: OwnDrops, exponent: float, provenance: Mapping[str, Any]
) -> Calibration:
    ball_ball, ball_table = (
        _UNKNOWN_RESTITUTION if drops is None else _from_own_drops(drops) for drops in own
    )
    return Calibration(
        restitution_ball_ball=ball_ball,
        restitution_ball_table=ball_table,
        stiffness_ratio=_UNKNOWN_RATIO,
        states=(),
        pairs=(),
        chi_square=0.0,
        degrees_of_freedom=0,
        exponent=exponent,
        notes=notes_on_trials(trials, found, own),
        profile=Curve(),
        provenance=provenance,
    )


def _from_own_drops(drops: Repeats) -> Estimate:
    intervals = [[_clipped(drops.interval(level))] for level in LEVELS]
    return _restitution_estimate(float(drops.means[0, 0]), intervals, drops.mean_sd())


def _restitution_estimates(misfit: Misfit, profile: Profile) -> tuple[Estimate, Estimate]:
    """Restitutions of the joint fit, with the sets every accepted stiffness ratio allows them."""
    reach = [
        propagate(misfit, profile, level, lambda log_ratio, restitutions: restitutions) for level in LEVELS
    ]
    ball_ball, ball_table = (
        _restitution_estimate(
            profile.basins[0].restitutions[column],
            [
                [_clipped(pair) for pair in zip(low[:, column], high[:, column], strict=True)]
                for low, high in reach
            ],
        )
        for column in range(2)
    )
    return ball_ball, ball_table


def _restitution_estimate(value: float, intervals: list[list[Interval]], sd: float | None = None) -> Estimate:
    inner, outer = (joined(level, gap=_SAME_RESTITUTION) for level in intervals)
    word = verdict(outer, _RESTITUTION_LIMITS, _WIDEST_RESTITUTION)
    return _estimate(value, inner, outer, word, sd)


def _stiffness_estimate(profile: Profile) -> Estimate:
    inner, outer = (profile.intervals(level) for level in LEVELS)
    logs = tuple((float(np.log(low)), float(np.log(high))) for low, high in outer)
    limits = (float(np.log(RATIO_LIMITS[0])) + 1e-9, float(np.log(RATIO_LIMITS[1])) - 1e-9)
    word = verdict(logs, limits, float(np.log(_WIDEST_RATIO)))
    return _estimate(profile.basins[0].stiffness_ratio, inner, outer, word)


def _estimate(
    value: float, inner: tuple[Interval, ...], outer: tuple[Interval, ...], word: str, sd: float | None = None
) -> Estimate:
    around = [(low, high) for low, high in inner if low <= value <= high]
    return Estimate(
        value=value if word in (ONE_VALUE, SEVERAL_VALUES) else None,
        sd=(sd or (around[0][1] - around[0][0]) / 2) if word == ONE_VALUE and around else None,
        intervals_68=inner,
        intervals_95=outer,
        verdict=word,
    )


def _pairs(misfit: Misfit, profile: Profile, two: Observed) -> tuple[MassPair, ...]:
    best = profile.basins[0]
    fitted = _predictions(misfit)(np.log([best.stiffness_ratio]), np.array([best.restitutions]))[0].reshape(
        -1, 2
    )
    bands = [_bands(misfit, profile, level) for level in LEVELS]
    return tuple(
        MassPair(
            mass_ratio=float(ratio),
            trials=int(two.trials[pair]),
            measured=_two(two.repeats.means[pair]),
            measured_sd=(two.repeats.mean_sd(pair, 0), two.repeats.mean_sd(pair, 1)),
            fitted=_two(fitted[pair]),
            fitted_68=bands[0][pair],
            fitted_95=bands[1][pair],
            states=state_sequence(
                best.stiffness_ratio, best.restitutions, float(ratio), exponent=misfit.exponent
            ),
        )
        for pair, ratio in enumerate(misfit.mass_ratios)
    )


def _bands(misfit: Misfit, profile: Profile, level: float) -> list[tuple[Interval, Interval]]:
    """Range of both velocity ratios of each mass pair over all parameters inside the confidence set."""
    low, high = propagate(misfit, profile, level, _predictions(misfit))
    ends = np.stack([low.min(axis=0), high.max(axis=0)], axis=1).reshape(-1, 2, 2)
    return [(_two(upper), _two(lower)) for upper, lower in ends]


def _predictions(misfit: Misfit) -> Callable[[Array, Array], Array]:
    """Velocity ratios of all mass pairs, (N, 2 J), as a function of the parameters."""
    return lambda log_ratio, restitutions: misfit.predicted(log_ratio, restitutions).reshape(
        len(log_ratio), -1
    )


def _curve(profile: Profile) -> Curve:
    return Curve(
        stiffness_ratio=tuple(np.exp(profile.trace.log_ratio).tolist()),
        chi_square=tuple(profile.trace.chi_square.tolist()),
        limit_68=tuple(profile.limits(0.68).tolist()),
        limit_95=tuple(profile.limits(0.95).tolist()),
    )


def _two(values: Array) -> tuple[float, float]:
    first, second = values.tolist()
    return first, second


def _clipped(interval: Interval) -> Interval:
    low, high = np.clip(interval, *_RESTITUTION_LIMITS)
    return float(low), float(high)
