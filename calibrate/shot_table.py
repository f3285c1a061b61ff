"""From rows of the trial table to cue shots.

Columns of a shot, beside those of every trial (SI, radians; x and y in the plane of the table):

========================================  ==============================================================
`velocity_x`, `velocity_y`                of the ball just after the strike, each with ``_sd``
`angular_velocity_x`, `..._y`             the same of its spin; may be missing
`approach_velocity`                       speed of the tip along the cue, above zero
`approach_direction`                      of the cue seen from above, from x to y
`cue_elevation`                           of the butt above the table; 0 is a level cue
`contact_offset`, `contact_height`        where the tip strikes, in radii right of and above the middle
`friction`, `friction_sd`                 of the cloth, as the path after the strike tells it; may be missing
`velocity_x_velocity_y_correlation`, …    of the errors of each two of the four velocities; none if missing
========================================  ==============================================================

Tracking tells all of these but `cue_elevation` and `contact_height`, which no camera above the table sees.
"""

import itertools

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from calibrate.rows import TrialTableError, correlation_column
from calibrate.sentences import Note
from calibrate.shots import AIM, MEASURED, Shots
from impact import Ball, Cue

Array = NDArray[np.float64]

ASSUMED_SD = 0.02
"""Of a velocity without a stated one, relative to the speed of the ball (of its surface, for spins)."""

_ASKED = {
    "approach_direction": "the cue's direction seen from above, rad from x to y",
    "cue_elevation": "the butt's angle above the table, rad",
    "contact_offset": "where the tip strikes, radii to the right of the middle",
    "contact_height": "where the tip strikes, radii above the middle",
}
_PAIRS = tuple(itertools.combinations(range(len(MEASURED)), 2))
_HIGHEST_CORRELATION = 0.9999


def observed_shots(trials: pd.DataFrame, ball: Ball, cue: Cue) -> Shots:
    """Collect the usable shots of a table.

    Parameters
    ----------
    trials : pandas.DataFrame
        As `read_trials` or `check_trials` returns it.
    ball, cue : Ball, Cue
        The ball and the stick.

    Raises
    ------
    TrialTableError
        If no shot is usable; the message says why the first one is not.
    """
    shots = trials[(trials["kind"] == "shot") & (trials["status"] == "ok")]
    if shots.empty:
        raise TrialTableError("no usable trial of kind shot")
    table = _table(shots)
    untold = {name: int(table[name].isna().sum()) for name in AIM[1:]}
    table = table.fillna(dict.fromkeys(AIM[1:], 0.0))
    reasons = [_reason(row) for row in table.to_dict("records")]
    in_pixels = shots.get("unit", pd.Series("m", index=shots.index)).astype(str).str.strip() == "px"
    reasons = ["its lengths are in pixels" if px else why for px, why in zip(in_pixels, reasons, strict=True)]
    left_out = zip(shots["trial"], reasons, strict=True)
    notes = [Note.SHOT_LEFT_OUT.format(trial=name, reason=why) for name, why in left_out if why]
    kept = table[[not why for why in reasons]]
    if kept.empty:
        raise TrialTableError(f"no usable trial of kind shot; {notes[0]}")
    notes += [
        Note.SHOT_NOT_AIMED.format(column=name, meaning=_ASKED[name], shots=_shots(count))
        for name, count in untold.items()
        if count
    ]
    measured, sd = kept[list(MEASURED)].to_numpy(), kept[[f"{name}_sd" for name in MEASURED]].to_numpy()
    speed = np.hypot(measured[:, 0], measured[:, 1])[:, None]
    assumed = ASSUMED_SD * speed / np.array([1.0, 1.0, ball.radius, ball.radius])
    missing = ~(sd > 0)
    if (missing & np.isfinite(measured)).any():
        notes.append(Note.SHOT_UNSTATED.format(share=f"{ASSUMED_SD:.0%}"))
    return Shots(
        names=tuple(str(name) for name, why in zip(shots["trial"], reasons, strict=True) if not why),
        measured=measured,
        measured_sd=np.where(missing, assumed, sd),
        correlation=_correlation(kept),
        aim=kept[list(AIM)].to_numpy(),
        aim_sd=kept[[f"{name}_sd" for name in AIM]].fillna(0.0).to_numpy(),
        cloth=_cloth(kept),
        ball=ball,
        cue=cue,
        notes=tuple(notes),
    )


def _table(shots: pd.DataFrame) -> pd.DataFrame:
    """All columns of shots as numbers, NaN where missing."""
    values = [*MEASURED, *AIM, "friction"]
    correlations = [correlation_column(MEASURED[one], MEASURED[other]) for one, other in _PAIRS]
    names = [*values, *(f"{name}_sd" for name in values), *correlations]
    return pd.DataFrame({name: _numbers(shots, name) for name in names})


def _correlation(table: pd.DataFrame) -> Array:
    """Correlations (S, 4, 4) of what was measured; what contradicts itself is drawn towards none."""
    matrices = np.tile(np.eye(len(MEASURED)), (len(table), 1, 1))
    for one, other in _PAIRS:
        told = table[correlation_column(MEASURED[one], MEASURED[other])].fillna(0.0).to_numpy()
        matrices[:, one, other] = matrices[:, other, one] = np.clip(told, -1.0, 1.0)
    lowest = np.linalg.eigvalsh(matrices)[:, 0]
    least = 1 - _HIGHEST_CORRELATION
    share = np.where(lowest < least, (1 - least) / (1 - lowest + 1e-15), 1.0)[:, None, None]
    return np.asarray(share * matrices + (1 - share) * np.eye(len(MEASURED)))


def _shots(count: int) -> str:
    return "1 shot" if count == 1 else f"{count} shots"


def _numbers(shots: pd.DataFrame, column: str) -> pd.Series:
    if column not in shots:
        return pd.Series(np.nan, index=shots.index)
    return pd.to_numeric(shots[column], errors="coerce").replace([np.inf, -np.inf], np.nan).astype(float)


def _reason(row: dict[str, float]) -> str:
    """Say why a shot cannot be used; empty if it can."""
    for name in MEASURED[:2]:
        if np.isnan(row[name]):
            return f"{name} is no finite number"
    if not row["approach_velocity"] > 0:
        return "approach_velocity must be above zero, the speed of the tip along the cue"
    if not row["contact_offset"] ** 2 + row["contact_height"] ** 2 < 1:
        return "contact_offset and contact_height lie outside the ball"
    if not abs(row["cue_elevation"]) < np.pi / 2 + 1e-9:
        return f"cue_elevation must be at most pi/2 (it is in radians), got {row['cue_elevation']:g}"
    return ""


def _cloth(table: pd.DataFrame) -> tuple[float, float] | None:
    """Average the friction that the paths tell; scatter counts where it exceeds what is stated."""
    told = table[(table["friction"] > 0) & (table["friction_sd"] > 0)]
    if told.empty:
        return None
    weight = 1 / told["friction_sd"].to_numpy() ** 2
    mean = float(np.average(told["friction"], weights=weight))
    off = weight * (told["friction"].to_numpy() - mean) ** 2
    scatter = max(1.0, float(off.sum()) / max(len(told) - 1, 1))
    return mean, float(np.sqrt(scatter / weight.sum()))
