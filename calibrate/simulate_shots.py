"""Tables of cue shots drawn from a known truth."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from calibrate.rows import correlation_column
from calibrate.shots import AIM, MEASURED, Shots
from calibrate.trials import check_trials
from impact import Ball, Cue


def simulate_shots(
    truth: Mapping[str, float],
    aim: NDArray[np.float64],
    bodies: tuple[Ball, Cue],
    generator: np.random.Generator,
    *,
    scatter: float = 0.005,
    correlation: NDArray[np.float64] | None = None,
) -> pd.DataFrame:
    """Draw a table of shots.

    Parameters
    ----------
    truth : mapping of str to float
        Every parameter of `calibrate.shot_fit.PARAMETERS`.
    aim : ndarray (S, 5)
        Values of `calibrate.shots.AIM`, one row a shot.
    bodies : (Ball, Cue)
        The ball and the stick.
    generator : numpy.random.Generator
        Source of the scatter.
    scatter : float
        Of velocities, relative to the speed of the ball; of spins, of its surface.
    correlation : ndarray (4, 4), optional
        Of the errors of `calibrate.shots.MEASURED`; none without it.

    Returns
    -------
    pandas.DataFrame
        As `check_trials` returns it, with the scatter stated as standard deviations.
    """
    ball, cue = bodies
    nothing = np.full((len(aim), 4), np.nan)
    shots = Shots(
        names=tuple(str(number) for number in range(len(aim))),
        measured=nothing,
        measured_sd=nothing,
        correlation=np.empty((len(aim), 4, 4)),
        aim=aim,
        aim_sd=np.zeros_like(aim),
        cloth=None,
        ball=ball,
        cue=cue,
        notes=(),
    )
    parameters = [np.log(value) if name == "stiffness_ratio" else value for name, value in truth.items()]
    exact = shots.predicted(np.array([parameters]))[0]
    speed = np.hypot(exact[:, 0], exact[:, 1])[:, None]
    sd = scatter * speed / np.array([1.0, 1.0, ball.radius, ball.radius])
    table = pd.DataFrame({"kind": "shot", **dict(zip(AIM, aim.T, strict=True))})
    together = np.eye(len(MEASURED)) if correlation is None else correlation
    errors = generator.normal(size=sd.T.shape).T @ np.linalg.cholesky(together).T * sd
    for column, name in enumerate(MEASURED):
        table[name] = exact[:, column] + errors[:, column]
        table[f"{name}_sd"] = sd[:, column]
        for other, beside in enumerate(MEASURED[:column]):
            table[correlation_column(beside, name)] = together[other, column]
    return check_trials(table)
