"""Cue shots as the fit needs them: what was measured, and what the model says of them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impact import Ball, Contact, ConvergenceError, Cue, CueShot, collide_many

Array = NDArray[np.float64]

MEASURED = ("velocity_x", "velocity_y", "angular_velocity_x", "angular_velocity_y")
AIM = ("approach_velocity", "approach_direction", "cue_elevation", "contact_offset", "contact_height")
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
    correlation : ndarray (S, 4, 4)
        Of the errors of `MEASURED`.
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
    correlation: Array
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
        missing = np.isnan(self.measured)
        sd = np.where(missing, 1e6, self.measured_sd)
        apart = (missing[:, :, None] | missing[:, None, :]) & ~np.eye(4, dtype=bool)
        own = np.where(apart, 0.0, self.correlation) * sd[:, :, None] * sd[:, None, :]
        return np.asarray(added + own)


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
