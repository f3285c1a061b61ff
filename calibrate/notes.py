"""What the reader of a fit has to know, in sentences: what was left out, assumed, or does not fit."""

import pandas as pd

from calibrate.basins import Basin
from calibrate.estimate import Estimate
from calibrate.intervals import BAD_FIT, ONE_VALUE, chance_of
from calibrate.misfit import Misfit
from calibrate.observed import Found, Observed, mass_ratio_groups, usable_trials
from calibrate.profile import RATIO_LIMITS, Profile
from calibrate.repeats import ASSUMED_SCATTER, Repeats
from calibrate.rows import MASSES, VELOCITIES
from calibrate.sentences import Note
from calibrate.speed import fit_speed_law, tells_about_speed

OwnDrops = tuple[Repeats | None, Repeats | None]

_AT_BOUND = 1e-3  # distance from a bound, relative, that is none
_MOST_NAMES = 5  # of trials, in one note
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
    notes = [*_missing(trials, found, own), *_left_out(trials), *_unusable_pairs(trials, found)]
    notes += [*_exact(trials), *_copied(trials)]
    for kind, observed in (("held", found.held), ("plate", found.plate), ("two", found.two)):
        if observed is not None:
            notes += _about_repeats(_KINDS[kind], observed)
            notes += _about_speed(kind, trials, observed)
    return tuple(notes)


def notes_on_fit(misfit: Misfit, profile: Profile, ratio: Estimate) -> tuple[str, ...]:
    """Say whether the model fits at all, and what would help where the ratio is not one value."""
    notes = []
    chance = chance_of(profile.basins[0].chi_square, misfit.degrees_of_freedom)
    if chance < BAD_FIT:
        notes.append(Note.MISFIT.format(chance=f"{chance:.1g}"))
    notes += _at_bounds(profile.basins[0])
    if ratio.verdict != ONE_VALUE and len(misfit.mass_ratios) == 1:
        notes.append(str(Note.ONE_MASS_PAIR))
    return tuple(notes)


def _missing(trials: pd.DataFrame, found: Found, own: OwnDrops) -> list[str]:
    notes = []
    for kind, contact, drops in (("held", "ball-ball", own[0]), ("plate", "ball-table", own[1])):
        if drops is None:
            notes += _unusable(_KINDS[kind], trials[trials["kind"] == kind])
            notes.append(Note.NO_OWN_DROPS.format(drops=_KINDS[kind], contact=contact))
    if found.two is None:
        notes += _unusable(_KINDS["two"], trials[trials["kind"] == "two"])
        notes.append(str(Note.NO_TWO_BALL_TRIALS))
    return notes


def _unusable_pairs(trials: pd.DataFrame, found: Found) -> list[str]:
    """Name each mass pair that was filmed, but of which no trial is left while others are."""
    if found.two is None:
        return []
    filmed = trials[(trials["kind"] == "two") & (trials["impact"] == 1)]
    filmed = filmed[(filmed[list(MASSES)] > 0).all(axis=1)]  # of what failed nothing can be taken for granted
    notes = []
    for _, pair in filmed.groupby(mass_ratio_groups(filmed)):
        ratio = float((pair["upper_mass"] / pair["lower_mass"]).mean())
        notes += _unusable(f"{_KINDS['two']} of mass ratio {ratio:.3g}", pair)
    return notes


def _unusable(what: str, rows: pd.DataFrame) -> list[str]:
    """Say of trials that were all left out, if they were, how they may be saved."""
    if rows.empty or (rows["status"] == "ok").any():
        return []
    names = list(dict.fromkeys(rows["trial"].astype(str)))
    shown = [*names[:_MOST_NAMES], *(["…"] if len(names) > _MOST_NAMES else [])]
    return [Note.NONE_USABLE.format(count=len(names), trials=what, names=", ".join(shown))]


def _left_out(trials: pd.DataFrame) -> list[str]:
    counts = {status: int((trials["status"] == status).sum()) for status in ("failed", "suspect")}
    return [
        Note.LEFT_OUT.format(count=count, status=status, all=len(trials))
        for status, count in counts.items()
        if count
    ]


def _exact(trials: pd.DataFrame) -> list[str]:
    columns = ("upper_rebound_velocity_sd", "lower_rebound_velocity_sd")
    count = int((trials.loc[trials["status"] == "ok", list(columns)] == 0).sum().sum())
    if not count:
        return []
    return [Note.EXACT.format(count=count)]


def _copied(trials: pd.DataFrame) -> list[str]:
    usable = trials[(trials["status"] == "ok") & trials["kind"].isin(_KINDS)]
    count = int(usable.duplicated(["kind", *VELOCITIES, *MASSES]).sum())
    if not count:
        return []
    words = "1 trial repeats another" if count == 1 else f"{count} trials repeat others"
    return [Note.COPIED.format(trials=words)]


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
        Note.AT_BOUND.format(name=name, bound=f"{bound:g}")
        for name, value, low, high in ends
        for bound in (low, high)
        if abs(value - bound) <= _AT_BOUND * bound or value == bound
    ]


def _about_repeats(kind: str, observed: Observed) -> list[str]:
    notes = [Note.OUTLIER.format(trial=name, trials=kind) for name in observed.outliers]
    if not observed.repeats.degrees_of_freedom < float("inf"):
        notes.append(Note.TOO_FEW.format(trials=kind, scatter=f"{ASSUMED_SCATTER:.0%}"))
    elif observed.repeats.too_alike:
        notes.append(Note.TOO_ALIKE.format(trials=kind))
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
    return [Note.DEPENDS_ON_SPEED.format(trials=_KINDS[kind], law=law)]
