"""Two sliding discs before and after they meet, fitted as one.

Each disc slows at a constant rate (dry friction) until it rests; both change their velocity at one moment, in
which their centres are the sum of their radii apart.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares

from tracking.joint import OUTLIER
from tracking.least import honest_covariance

FloatArray = npt.NDArray[np.float64]

TIME = 0
DISC_SIZE = 7  # place (2), velocity before (2), velocity after (2), deceleration
COUNT = 1 + 2 * DISC_SIZE


def place_of(disc: int) -> slice:
    """Where in the vector of parameters the place of disc 0 or 1 at the impact stands."""
    return slice(1 + disc * DISC_SIZE, 3 + disc * DISC_SIZE)


def velocity_of(disc: int, *, after: bool) -> slice:
    """Where its velocity before or after the impact stands."""
    start = 3 + disc * DISC_SIZE + 2 * after
    return slice(start, start + 2)


def deceleration_of(disc: int) -> int:
    """Where its deceleration stands."""
    return 7 + disc * DISC_SIZE


@dataclass(frozen=True, slots=True, kw_only=True)
class Leg:
    """Frames of one disc on one side of the impact: (n,) times, (n, 2) places and standard deviations."""

    disc: int
    after: bool
    time: FloatArray
    place: FloatArray
    sd: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Encounter:
    """Four legs, the distance of the centres at the impact and how well it is known, who rests before."""

    legs: tuple[Leg, ...]
    gap: float
    gap_sd: float
    rests: tuple[bool, ...]

    @property
    def frames(self) -> int:
        """How many frames take part."""
        return sum(len(leg.time) for leg in self.legs)

    @property
    def free(self) -> list[int]:
        """Places of the parameters to be fitted: a disc that rests has no velocity before."""
        fixed = {
            place
            for disc in (0, 1)
            if self.rests[disc]
            for place in range(COUNT)[velocity_of(disc, after=False)]
        }
        return [place for place in range(COUNT) if place not in fixed]


@dataclass(frozen=True, slots=True, kw_only=True)
class EncounterFit:
    """Fitted parameters, their covariance (0 where held), root mean square distance, frames used.

    `paths` are the fitted legs: (n, 3) arrays of time and place (t, x, y).
    """

    parameters: FloatArray
    covariance: FloatArray
    residual: float
    frames: int
    paths: tuple[FloatArray, ...]


def fit_encounter(encounter: Encounter, start: FloatArray) -> EncounterFit:
    """Fit robustly, drop the frames that lie off, and fit again; a disc that never slows has no friction."""
    rough = _solve(encounter, start, robust=True)
    encounter = replace(encounter, legs=tuple(_inliers(leg, rough) for leg in encounter.legs))
    parameters = _solve(encounter, rough, robust=False)
    unslowed = [place for place in map(deceleration_of, (0, 1)) if parameters[place] <= 0]
    parameters[unslowed] = 0.0
    free = [place for place in encounter.free if place not in unslowed]

    def residuals(values: FloatArray) -> FloatArray:
        return _residuals(encounter, _with(parameters, free, values))

    covariance = np.zeros((COUNT, COUNT))
    covariance[np.ix_(free, free)] = honest_covariance(residuals, parameters[free], encounter.frames)
    apart = np.vstack([leg.place - _path(leg, parameters) for leg in encounter.legs])
    return EncounterFit(
        parameters=parameters,
        covariance=covariance,
        residual=float(np.sqrt(np.mean(np.sum(apart**2, axis=1)))),
        frames=encounter.frames,
        paths=tuple(np.column_stack((leg.time, _path(leg, parameters))) for leg in encounter.legs),
    )


def _path(leg: Leg, parameters: FloatArray) -> FloatArray:
    """Places that the parameters predict: constant deceleration, until the disc rests."""
    velocity = parameters[velocity_of(leg.disc, after=leg.after)]
    deceleration = max(float(parameters[deceleration_of(leg.disc)]), 0.0)
    speed = float(np.hypot(*velocity))
    since = leg.time - parameters[TIME]
    if speed == 0:
        return np.broadcast_to(parameters[place_of(leg.disc)], leg.place.shape)
    until_rest = speed / deceleration if deceleration > 0 else np.inf
    since = np.minimum(since, until_rest)
    way = since - deceleration / (2 * speed) * since**2
    return np.asarray(parameters[place_of(leg.disc)] + velocity * way[:, None])


def _residuals(encounter: Encounter, parameters: FloatArray) -> FloatArray:
    """Distances of the frames from the paths, and of the discs from touching, in standard deviations."""
    apart = [((leg.place - _path(leg, parameters)) / leg.sd).ravel() for leg in encounter.legs]
    distance = float(np.hypot(*(parameters[place_of(1)] - parameters[place_of(0)])))
    return np.concatenate([*apart, [(distance - encounter.gap) / encounter.gap_sd]])


def _solve(encounter: Encounter, start: FloatArray, *, robust: bool) -> FloatArray:
    """Least squares over what is free."""
    free = encounter.free
    speed = max(float(np.abs(start[1:]).max()), 1e-6)
    size = np.full(COUNT, speed)
    size[TIME] = 1e-2
    fit = least_squares(
        lambda values: _residuals(encounter, _with(start, free, values)),
        start[free],
        loss="soft_l1" if robust else "linear",
        x_scale=size[free],
        xtol=1e-11,
    )
    return _with(start, free, fit.x)


def _with(start: FloatArray, free: Sequence[int], values: FloatArray) -> FloatArray:
    """Put values into a copy of the parameters."""
    parameters = start.copy()
    parameters[list(free)] = values
    return parameters


def _inliers(leg: Leg, parameters: FloatArray) -> Leg:
    """Keep the frames near the path."""
    distance = np.hypot(*((leg.place - _path(leg, parameters)) / leg.sd).T)
    near = distance < OUTLIER * max(1.0, float(np.median(distance)))
    return replace(leg, time=leg.time[near], place=leg.place[near], sd=leg.sd[near])
