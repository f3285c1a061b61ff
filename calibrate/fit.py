"""Fit restitution and stiffness ratio to a table of trials."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from calibrate.estimate import Calibration, Curve, Estimate
from calibrate.misfit import Misfit
from calibrate.model import LINEAR
from calibrate.notes import OwnDrops, notes_on_fit, notes_on_trials
from calibrate.observed import Found, Observed, found_in, observed_restitution
from calibrate.outcome import (
    UNKNOWN_RATIO,
    UNKNOWN_RESTITUTION,
    curve_of,
    estimate_from_own_drops,
    mass_pairs,
    restitution_estimates,
    stiffness_estimate,
    valleys_of,
)
from calibrate.profile import trace_profile
from calibrate.repeats import Repeats, known
from calibrate.rows import TrialTableError

Known = tuple[float, float]


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
    return estimate_from_own_drops(found.repeats)


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
    ValueError
        If a known restitution is outside [0, 1] or its sd not above zero.
    """
    found = found_in(trials)
    own = (_own("ball_ball", ball_ball, found.held), _own("ball_table", ball_table, found.plate))
    if found.two is None:
        return _without_two_balls(trials, found, own, exponent, provenance or {})
    misfit = _misfit(own, found.two, exponent)
    profile = trace_profile(misfit)
    pairs = mass_pairs(misfit, profile, found.two)
    most = pairs[int(np.argmax(found.two.trials))]
    ratio = stiffness_estimate(profile)
    ball_ball_estimate, ball_table_estimate = restitution_estimates(misfit, profile)
    return Calibration(
        restitution_ball_ball=ball_ball_estimate,
        restitution_ball_table=ball_table_estimate,
        stiffness_ratio=ratio,
        states=most.states,
        pairs=pairs,
        chi_square=profile.basins[0].chi_square,
        degrees_of_freedom=misfit.degrees_of_freedom,
        exponent=exponent,
        notes=(*notes_on_trials(trials, found, own), *notes_on_fit(misfit, profile, ratio)),
        profile=curve_of(misfit, profile, most.mass_ratio),
        valleys=valleys_of(profile),
        provenance=provenance or {},
    )


def misfit_of(
    trials: pd.DataFrame,
    *,
    exponent: float = LINEAR,
    ball_ball: Known | None = None,
    ball_table: Known | None = None,
) -> Misfit:
    """Collect everything measured about one pair of contacts; arguments as for `fit_stiffness_ratio`.

    Raises
    ------
    TrialTableError
        If there is no usable two-ball trial.
    """
    found = found_in(trials)
    if found.two is None:
        raise TrialTableError("no usable two-ball trial")
    own = (_own("ball_ball", ball_ball, found.held), _own("ball_table", ball_table, found.plate))
    return _misfit(own, found.two, exponent)


def _misfit(own: OwnDrops, two: Observed, exponent: float) -> Misfit:
    return Misfit(
        ball_ball=own[0],
        ball_table=own[1],
        rebounds=two.repeats,
        mass_ratios=two.mass_ratios,
        exponent=exponent,
    )


def _own(name: str, known_value: Known | None, drops: Observed | None) -> Repeats | None:
    if known_value is None:
        return None if drops is None else drops.repeats
    value, sd = known_value
    if not 0 <= value <= 1:
        raise ValueError(f"{name} must be within [0, 1], got {value:g}")
    if not sd > 0:
        raise ValueError(f"sd of {name} must be above zero, got {sd:g}")
    return known(value, sd)


def _without_two_balls(
    trials: pd.DataFrame, found: Found, own: OwnDrops, exponent: float, provenance: Mapping[str, Any]
) -> Calibration:
    ball_ball, ball_table = (
        UNKNOWN_RESTITUTION if drops is None else estimate_from_own_drops(drops) for drops in own
    )
    return Calibration(
        restitution_ball_ball=ball_ball,
        restitution_ball_table=ball_table,
        stiffness_ratio=UNKNOWN_RATIO,
        states=(),
        pairs=(),
        chi_square=0.0,
        degrees_of_freedom=0,
        exponent=exponent,
        notes=notes_on_trials(trials, found, own),
        profile=Curve(),
        provenance=provenance,
    )
