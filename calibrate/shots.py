"""Cue shots as the fit needs them: what was measured, and how far the model is from it.

Columns of a shot, beside those of every trial (SI, radians; x and y in the plane of the table):

========================================  ==============================================================
`velocity_x`, `velocity_y`                of the ball just after the strike, each with ``_sd``
`angular_velocity_x`, `..._y`             the same of its spin; may be missing
`approach_velocity`                       speed of the tip along the cue, above zero
`approach_direction`                      of the cue seen from above, from x to y; 0 if missing
`cue_elevation`                           of the butt above the table; 0, a level cue, if missing
`contact_offset`, `contact_height`        where the tip strikes, in radii right of and above the middle
`friction`, `friction_sd`                 of the cloth, as the path after the strike tells it; may be missing
========================================  ==============================================================
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from calibrate.rows import TrialTableError
from impact import Ball, Contact, ConvergenceError, Cue, CueShot, collide_many

Array = NDArray[np.float64]

MEASURED = ("velocity_x", "velocity_y", "angular_velocity_x", "angular_velocity_y")
AIM = ("approach_velocity", "approach_direction", "cue_elevation", "contact_offset", "contact_height")
ASSUMED_SD = 0.02
"""Of a velocity without a stated one, relative to the speed of the ball (of its surface, for spins)."""

_TOLERANCE = 1e-9  # of a collision: far finer than any camera, and twice as fast as the finest
_AIM_STEP = 1e-3  # for the slope of the outcome over where the cue was aimed


@dataclass(frozen=True, slots=True, kw_only=True)
class Shots:
    """S shots at one ball with one cue.

    Attributes
    ----------
    names : tuple of S str
        As in the table.
    measured, measured_sd : ndarray (S, 4)
        Values of `MEASURED`, NaN where missing.
    aim, aim_sd : ndarray (S, 5)
        Values of `AIM`; standard deviations are zero where none is stated.
    cloth : (mean, sd) or None
        Friction of the cloth by the paths after the strikes.
    ball, cue : Ball, Cue
        The ball and the stick.
    notes : tuple of str
        What was left out or assumed.
    """

    names: tuple[str, ...]
    measured: Array
    measured_sd: Array
    aim: Array
    aim_sd: Array
    cloth: tuple[float, float] | None
    ball: Ball
    cue: Cue
    notes: tuple[str, ...]

    def predicted(self, parameters: Array, aim: Array | None = None) -> Array:
        """Run the model.

        Parameters
        ----------
        parameters : ndarray (N, 5)
            Tip-ball restitution and friction, natural logarithm of the stiffness ratio k_bt/k_cb, ball-table
            restitution and friction.
        aim : ndarray (S, 5), optional
            Instead of what was measured.

        Returns
        -------
        ndarray (N, S, 4)
            Values of `MEASURED`.
        """
        aim = self.aim if aim is None else aim
        count, shots = len(parameters), len(aim)
        rows = np.repeat(parameters, shots, axis=0)
        normal, velocity = (np.tile(vectors, (count, 1)) for vectors in strike(aim))
        template = CueShot(
            ball=self.ball,
            cue=self.cue,
            normal=normal[0],
            cue_velocity=velocity[0],
            tip_ball=Contact(restitution=0.5),
            ball_table=Contact(restitution=0.5),
        )
        try:
            outcome = collide_many(
                template,
                normal=normal,
                cue_velocity=velocity,
                tip_ball_restitution=rows[:, 0],
                tip_ball_friction=rows[:, 1],
                stiffness_ratio=np.exp(rows[:, 2]),
                ball_table_restitution=rows[:, 3],
                ball_table_friction=rows[:, 4],
                rtol=_TOLERANCE,
            )
        except ConvergenceError as error:  # what is left to happen is negligible
            outcome = error.partial
        values = np.concatenate([outcome.velocity[:, :2], outcome.angular_velocity[:, :2]], axis=1)
        return values.reshape(count, shots, 4)

    def covariance(self, parameters: Array) -> Array:
        """Covariance (S, 4, 4) of what was measured, with what the aim's uncertainty (5 parameters) adds."""
        added = np.zeros((len(self.aim), 4, 4))
        at = self.predicted(parameters[None])[0]
        for column in np.flatnonzero(self.aim_sd.any(axis=0)):
            moved = self.aim.copy()
            moved[:, column] -= _AIM_STEP * np.where(moved[:, column] >= 0, 1, -1)
            change = self.predicted(parameters[None], moved)[0] - at
            shift = change / _AIM_STEP * self.aim_sd[:, [column]]
            added += shift[:, :, None] * shift[:, None, :]
        own = np.where(np.isnan(self.measured), 1e6, self.measured_sd) ** 2
        return np.asarray(added + own[:, :, None] * np.eye(4))


def strike(aim: Array) -> tuple[Array, Array]:
    """Outward normals at the tip and cue velocities, both (S, 3), from values of `AIM`, (S, 5).

    Examples
    --------
    >>> normal, velocity = strike(np.array([[2.0, 0.0, 0.0, 0.6, 0.0]]))
    >>> normal.round(3).tolist(), velocity.tolist()
    ([[-0.8, -0.6, 0.0]], [[2.0, 0.0, -0.0]])
    """
    speed, direction, elevation, right, above = aim.T
    zero = np.zeros_like(speed)
    level, drop = np.cos(elevation), -np.sin(elevation)
    along = np.stack([level * np.cos(direction), level * np.sin(direction), drop], axis=1)
    sideways = np.stack([np.sin(direction), -np.cos(direction), zero], axis=1)
    upward = np.cross(sideways, along)
    behind = np.sqrt(1 - right**2 - above**2)
    normal = right[:, None] * sideways + above[:, None] * upward - behind[:, None] * along
    return normal, speed[:, None] * along


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
    columns = [*MEASURED, *AIM, "friction"]
    table = pd.DataFrame({name: _numbers(shots, name) for name in (*columns, *(f"{c}_sd" for c in columns))})
    table = table.fillna(dict.fromkeys(AIM[1:], 0.0))
    reasons = [_reason(row) for row in table.to_dict("records")]
    in_pixels = shots.get("unit", pd.Series("m", index=shots.index)).astype(str).str.strip() == "px"
    reasons = ["its lengths are in pixels" if px else why for px, why in zip(in_pixels, reasons, strict=True)]
    notes = [f"{name} left out: {why}" for name, why in zip(shots["trial"], reasons, strict=True) if why]
    kept = table[[not why for why in reasons]]
    if kept.empty:
        raise TrialTableError(f"no usable trial of kind shot; {notes[0]}")
    measured, sd = kept[list(MEASURED)].to_numpy(), kept[[f"{name}_sd" for name in MEASURED]].to_numpy()
    speed = np.hypot(measured[:, 0], measured[:, 1])[:, None]
    assumed = ASSUMED_SD * speed / np.array([1.0, 1.0, ball.radius, ball.radius])
    missing = ~(sd > 0)
    if (missing & np.isfinite(measured)).any():
        notes.append(f"velocities without a standard deviation above zero: {ASSUMED_SD:.0%} of speed assumed")
    return Shots(
        names=tuple(str(name) for name, why in zip(shots["trial"], reasons, strict=True) if not why),
        measured=measured,
        measured_sd=np.where(missing, assumed, sd),
        aim=kept[list(AIM)].to_numpy(),
        aim_sd=kept[[f"{name}_sd" for name in AIM]].fillna(0.0).to_numpy(),
        cloth=_cloth(kept),
        ball=ball,
        cue=cue,
        notes=tuple(notes),
    )


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
