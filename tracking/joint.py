"""Flights that meet at an impact, fitted together by least squares.

The parameters are the moment of the impact, the heights of the balls then, the velocities just before and
just after, and one factor on all accelerations (1 unless gravity itself is put to the test).
"""

from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares

from tracking.flight import Flight, position

FloatArray = npt.NDArray[np.float64]

OUTLIER = 5.0  # standard deviations from the fitted flight


class P(IntEnum):
    """Places in the vector of parameters."""

    TIME = 0
    HEIGHT = 1
    APPROACH = 2
    REBOUND = 3
    LOWER_HEIGHT = 4
    LOWER_REBOUND = 5
    GRAVITY = 6


@dataclass(frozen=True, slots=True, kw_only=True)
class Side:
    """One ball's frames on one side of the impact, (n,) arrays in s and m, and the parameters that rule them.

    `velocity` is None for a ball at rest. Besides its own error `sd` each frame has one that it shares with
    frames of like height, `shared_sd`; two frames are alike if they are not further apart than `alike`, m.
    """

    time: FloatArray
    height: FloatArray
    sd: FloatArray
    start: P
    velocity: P | None
    flight: Flight
    shared_sd: float = 0.0
    alike: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Meeting:
    """All sides of one impact; two balls touch then: their centres are `gap` ± `gap_sd` m apart."""

    sides: tuple[Side, ...]
    gap: float | None = None
    gap_sd: float = np.inf

    @property
    def frames(self) -> int:
        """How many frames take part."""
        return sum(len(side.time) for side in self.sides)


@dataclass(frozen=True, slots=True, kw_only=True)
class JointFit:
    """Fitted parameters (indexed by `P`), their covariance (NaN where held fixed), residual RMS in m.

    `gain`, (parameters, residuals), is how much each parameter follows each of the weighted distances.
    """

    parameters: FloatArray
    covariance: FloatArray
    residual: float
    gain: FloatArray


def fit_meeting(meeting: Meeting, start: FloatArray, free: list[P], *, robust: bool = False) -> JointFit:
    """Fit the `free` parameters of a meeting, the others held at `start`.

    The covariance is widened where the frames scatter more than their rims tell, where neighbours among them
    err alike, and by the errors that frames share; it is never narrowed.
    """

    def residuals(values: FloatArray) -> FloatArray:
        parameters = start.copy()
        parameters[free] = values
        return weighted_distances(meeting, parameters)

    fit = least_squares(
        residuals,
        start[free],
        loss="soft_l1" if robust else "linear",
        x_scale=np.maximum(np.abs(start[free]), 1e-3),
        xtol=1e-12,
    )
    parameters = start.copy()
    parameters[free] = fit.x
    excess = max(1.0, 2 * float(fit.cost) / max(meeting.frames - len(free), 1)) * _memory(meeting, parameters)
    inverse = np.linalg.pinv(fit.jac.T @ fit.jac)
    gain = inverse @ fit.jac.T
    covariance = np.full((len(P), len(P)), np.nan)
    covariance[np.ix_(free, free)] = inverse * excess + gain @ _shared_errors(meeting, len(fit.fun)) @ gain.T
    everything = np.zeros((len(P), len(fit.fun)))
    everything[free] = gain
    distance = np.concatenate([side.height - heights(side, parameters) for side in meeting.sides])
    return JointFit(
        parameters=parameters,
        covariance=covariance,
        residual=float(np.sqrt(np.mean(distance**2))),
        gain=everything,
    )


def _shared_errors(meeting: Meeting, size: int) -> FloatArray:
    """Covariance, in standard deviations, of what frames of like height share: background, compression.

    It is the same on the way down and up: the same ball before the same background.
    """
    height = np.concatenate([side.height for side in meeting.sides])
    ball = np.concatenate([np.full(len(side.time), side.start) for side in meeting.sides])
    share = np.concatenate([side.shared_sd / side.sd for side in meeting.sides])
    alike = np.concatenate([np.full(len(side.time), side.alike) for side in meeting.sides])
    apart = np.abs(np.subtract.outer(height, height)) / alike
    covariance = np.zeros((size, size))
    frames = len(height)
    covariance[:frames, :frames] = np.outer(share, share) * np.exp(-apart) * np.equal.outer(ball, ball)
    return covariance


def moved(fit: JointFit, meeting: Meeting, changed: Meeting) -> FloatArray:
    """How far the fitted parameters move if the meeting is `changed` a little, to first order."""
    before = weighted_distances(meeting, fit.parameters)
    return -fit.gain @ (weighted_distances(changed, fit.parameters) - before)


def _memory(meeting: Meeting, parameters: FloatArray) -> float:
    """How many times fewer independent frames there are, from the correlation of neighbours: (1+r)/(1-r)."""
    products, squares = 0.0, 0.0
    for side in meeting.sides:
        distance = (side.height - heights(side, parameters)) / side.sd
        products += float(distance[1:] @ distance[:-1])
        squares += float(distance @ distance)
    correlation = min(max(products / squares, 0.0), 0.9) if squares > 0 else 0.0
    return (1 + correlation) / (1 - correlation)


def heights(side: Side, parameters: FloatArray) -> FloatArray:
    """Heights that a side's flight predicts for its frames, m."""
    start = parameters[side.start]
    if side.velocity is None:
        return np.full_like(side.time, start)
    factor = max(float(parameters[P.GRAVITY]), 1e-6)
    flight = Flight(  # drag itself stays as it is: gravity / terminal_speed**2 does not change
        gravity=side.flight.gravity * factor, terminal_speed=side.flight.terminal_speed * factor**0.5
    )
    return np.asarray(start + position(flight, parameters[side.velocity], side.time - parameters[P.TIME]))


def weighted_distances(meeting: Meeting, parameters: FloatArray) -> FloatArray:
    """Distances of all frames from the flights, and of the balls from touching, in standard deviations."""
    parts = [(heights(side, parameters) - side.height) / side.sd for side in meeting.sides]
    if meeting.gap is not None:
        apart = parameters[P.HEIGHT] - parameters[P.LOWER_HEIGHT] - meeting.gap
        parts.append(np.array([apart / meeting.gap_sd]))
    return np.nan_to_num(np.concatenate(parts), nan=1e6)  # NaN: no ball was ever so fast so early


def without_outliers(meeting: Meeting, parameters: FloatArray) -> Meeting:
    """Drop the frames that lie further off their flight than their like."""
    return replace(meeting, sides=tuple(_inliers(side, parameters) for side in meeting.sides))


def _inliers(side: Side, parameters: FloatArray) -> Side:
    """Keep the frames near one flight."""
    distance = np.abs(side.height - heights(side, parameters)) / side.sd
    scale = max(1.0, 1.4826 * float(np.median(distance))) if distance.size else 1.0
    keep = distance < OUTLIER * scale
    return replace(side, time=side.time[keep], height=side.height[keep], sd=side.sd[keep])
