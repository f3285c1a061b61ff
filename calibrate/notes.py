"""What the reader of a fit has to know, in sentences: what was left out, assumed, or does not fit."""

import pandas as pd
from scipy import stats

from calibrate.basins import Basin
from calibrate.estimate import Estimate
from calibrate.intervals import ONE_VALUE
from calibrate.misfit import Misfit
from calibrate.observed import Found, Observed, usable_trials
from calibrate.profile import RATIO_LIMITS, Profile
from calibrate.repeats import ASSUMED_SCATTER, Repeats
from calibrate.rows import MASSES, VELOCITIES
from calibrate.speed import fit_speed_law, tells_about_speed

OwnDrops = tuple[Repeats | None, Repeats | None]

_AT_BOUND = 1e-3  # distance from a bound, relative, that is none
_BAD_FIT = 0.01  # probability of a larger chi-square below which the model is said to miss the data
_KINDS = {"held": "drops on a held ball", "plate": "drops on the plate", "two": "two-ball trials"}


def notes_on_trials(trials: pd.DataFrame, found: Found, own: OwnDrops) -> tuple[str, ...]:
    """Say what was missing, left out and assumed before any fit.

    Parameters
    ----------
    trials : pandas.DataFrame
        All rows.
    found : Found
        What was used of them.
    own : (Repeats or None, Repeats or None)
        Ball-ball and ball-table restitution from their own drops or from elsewhere.
    """
    notes = [*_missing(found, own), *_left_out(trials), *_exact(trials), *_copied(trials)]
    for kind, observed in (("held", found.held), ("plate", found.plate), ("two", found.two)):
        if observed is not None:
            notes += _about_repeats(_KINDS[kind], observed)
            notes += _about_speed(kind, trials, observed)
    return tuple(notes)


def notes_on_fit(misfit: Misfit, profile: Profile, ratio: Estimate) -> tuple[str, ...]:
    """Say whether the model fits at all, and what would help where the ratio is not one value."""
    notes = []
    best, freedom = profile.basins[0].chi_square, misfit.degrees_of_freedom
    chance = float(stats.chi2.sf(best, freedom)) if freedom > 0 else 1.0
    if chance < _BAD_FIT:
        notes.append(
            f"the model misses the measurements by more than their scatter (probability {chance:.1g}):"
            " do not trust the intervals"
        )
    notes += _at_bounds(profile.basins[0])
    if ratio.verdict != ONE_VALUE and len(misfit.mass_ratios) == 1:
        notes.append(
            "all two-ball trials have one mass ratio, and drop heights carry no information on the stiffness"
            " ratio: trials with a second mass pair would"
        )
    return tuple(notes)


def _missing(found: Found, own: OwnDrops) -> list[str]:
    notes = []
    for kind, contact, drops in (("held", "ball-ball", own[0]), ("plate", "ball-table", own[1])):
        if drops is None:
            notes.append(f"no {_KINDS[kind]}: {contact} restitution has no measurement of its own")
    if found.two is None:
        notes.append("no two-ball trials: the stiffness ratio cannot be fitted")
    return notes


def _left_out(trials: pd.DataFrame) -> list[str]:
    counts = {status: int((trials["status"] == status).sum()) for status in ("failed", "suspect")}
    return [f"{count} {status} of {len(trials)} trials left out" for status, count in counts.items() if count]


def _exact(trials: pd.DataFrame) -> list[str]:
    columns = ("upper_rebound_velocity_sd", "lower_rebound_velocity_sd")
    count = int((trials.loc[trials["status"] == "ok", list(columns)] == 0).sum().sum())
    if not count:
        return []
    return [f"standard deviations of zero are taken as not stated: {count} of them"]


def _copied(trials: pd.DataFrame) -> list[str]:
    usable = trials[(trials["status"] == "ok") & trials["kind"].isin(_KINDS)]
    count = int(usable.duplicated(["kind", *VELOCITIES, *MASSES]).sum())
    if not count:
        return []
    words = "1 trial repeats another" if count == 1 else f"{count} trials repeat others"
    return [f"{words} digit for digit: a row that was only copied makes the intervals too narrow"]


def _at_bounds(best: Basin) -> list[str]:
    """Name the parameters whose best value lies where the search ends."""
    ends = [
        (name, value, low, high)
        for name, value, (low, high) in (
            ("stiffness ratio", best.stiffness_ratio, RATIO_LIMITS),
            ("ball-ball restitution", best.restitutions[0], (0.0, 1.0)),
            ("ball-table restitution", best.restitutions[1], (0.0, 1.0)),
        )
    ]
    return [
        f"the best fit has the {name} at its bound, {bound:g}: look for an error in what was measured, or"
        " take it as a bound on one side"
        for name, value, low, high in ends
        for bound in (low, high)
        if abs(value - bound) <= _AT_BOUND * bound or value == bound
    ]


def _about_repeats(kind: str, observed: Observed) -> list[str]:
    notes = [f"{name} stands apart from the other {kind} and was left out" for name in observed.outliers]
    if not observed.repeats.degrees_of_freedom < float("inf"):
        notes.append(f"too few {kind} to see their scatter: {ASSUMED_SCATTER:.0%} assumed")
    elif observed.repeats.too_alike:
        notes.append(
            f"the {kind} agree better than trials can: taken to scatter at least as much as they state"
        )
    return notes


def _about_speed(kind: str, trials: pd.DataFrame, observed: Observed) -> list[str]:
    """One restitution for all speeds is what the fit assumes; say so where the drops show that it is not."""
    if kind == "two":
        return []
    rows = usable_trials(trials, kind)
    rows = rows[~rows["trial"].isin(observed.outliers)]
    speed = -rows["approach_velocity"]
    if not tells_about_speed(speed):
        return []
    law = fit_speed_law(speed, rows["upper_rebound_velocity"] / speed)
    if not law.depends_on_speed:
        return []
    return [f"restitution of the {_KINDS[kind]} {law}; the fit takes one value for all speeds"]
