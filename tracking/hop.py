"""How fast a ball leaves the plate that hardly leaves it: a low hop, weighed by likelihood.

A hop of a third of a millimetre is over in four frames at 240 a second. Compression shows so small a motion
late, in part or not at all, and what comes after the landing, lower hops or rest, is no part of the flight.
Yet much is known: gravity, the height of rest, the moment of the impact. Each launch velocity is therefore
followed from rest to its own landing and weighed by how well the frames agree; the result is the mean and the
standard deviation under these weights. It tells something even where no frame shows the ball in the air.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tracking.flight import Flight, position
from tracking.sides import before_and_after
from tracking.track import Track

FloatArray = npt.NDArray[np.float64]

SMALL_MOTION = 2.0  # a ball that hardly moves is compressed worse than one that flies, by this factor
UNSHOWN = 3.0  # of a hop lower than this many errors of compression any part may be left out of the picture
MEMORY = 0.006  # s after which a picture errs anew
LEAST_SEEMING = 0.2  # frames may be ever closer to each other, errors do not grow with it
REST_SHARE_SD = 0.0015  # how well heights near the plate compare with that of rest, as a share of the radius
NOISE_FRAMES = 4  # the noise is known as if from so many frames
MOST_FRAMES = 80  # more are alike, and are left out evenly
VELOCITIES = 200  # tried, first widely and then around the best
FARTHEST = 5.0  # standard deviations up to which velocities are weighed


@dataclass(frozen=True, slots=True, kw_only=True)
class _Seen:
    """Frames after the impact: time since (s), height above rest (m), (n,), and its covariance, (n, n) in m².

    Of a hop not higher than `unshown` (m) the picture may show any part.
    """

    since: FloatArray
    lift: FloatArray
    noise: FloatArray
    unshown: float


def low_hop(lower: Track, impact: float, flight: Flight) -> tuple[float, float] | None:
    """Velocity with which a ball at rest starts into a low hop, and its standard deviation, m/s.

    Parameters
    ----------
    lower : Track
        In metres; its `shared_sd` is how compression errs where a ball flies.
    impact : float
        When it was struck, s.
    flight : Flight
        How it falls.

    Returns
    -------
    tuple of float, or None
        None if it is seen in no frame before or in none after the impact.
    """
    before, after = before_and_after(lower, impact)
    if not (before.size and after.size):
        return None
    since, lift = lower.time[after] - impact, lower.y[after] - float(np.median(lower.y[before]))
    compression, level = SMALL_MOTION * lower.shared_sd / _seeming(lower), REST_SHARE_SD * lower.radius
    # the highest hop that these frames allow, or that is over before the first of them
    sd = float(np.linalg.norm([np.median(lower.y_sd[after]), compression, level]))
    highest = max(float(lift.max()), 0.0) + FARTHEST * sd
    fastest = max(float(np.sqrt(2 * flight.gravity * highest)), flight.gravity * float(since[0]) / 2)
    early = np.flatnonzero(since <= 2 * fastest / flight.gravity)
    early = early[:: 1 + len(early) // MOST_FRAMES]
    alike = np.exp(-np.abs(np.subtract.outer(since[early], since[early])) / MEMORY)
    seen = _Seen(
        since=since[early],
        lift=lift[early],
        noise=np.diag(lower.y_sd[after[early]] ** 2) + (compression**2 + level**2) * alike + level**2,
        unshown=UNSHOWN * compression,
    )
    mean, spread = _weigh(seen, flight, np.linspace(0, fastest, VELOCITIES))
    reach = FARTHEST * max(spread, fastest / VELOCITIES)
    return _weigh(seen, flight, np.linspace(max(mean - reach, 0.0), mean + reach, VELOCITIES))


def _seeming(track: Track) -> float:
    """Share of an error with memory that third differences of neighbours see.

    `path_scatter` sees more of it where a ball flies; velocities of hops are as sure as stated with this.
    """
    alike = float(np.exp(-np.median(np.diff(track.time)) / MEMORY))
    return max(float(np.sqrt(np.polyval([-0.1, 0.6, -1.5, 1.0], alike))), LEAST_SEEMING)


def _weigh(seen: _Seen, flight: Flight, velocities: FloatArray) -> tuple[float, float]:
    """Mean and standard deviation of launch velocities weighed by their likelihood."""
    likelihood = _log_likelihood(seen, flight, velocities)
    weight = np.exp(likelihood - likelihood.max())
    mean = float(np.average(velocities, weights=weight))
    return mean, float(np.sqrt(np.average((velocities - mean) ** 2, weights=weight)))


def _log_likelihood(seen: _Seen, flight: Flight, velocities: FloatArray) -> FloatArray:
    """How well the frames agree with launch velocities: Student's t, as the noise is not known exactly.

    What may be lost of a low hop is uniform, from nothing to all. After its landing the ball is anywhere in a
    lower hop.
    """
    velocity = velocities[:, None]
    top = velocity**2 / (2 * flight.gravity)
    flying = seen.since < 2 * velocity / flight.gravity
    rise = np.where(flying, position(flight, velocity, seen.since), 0.0)
    lost = np.clip(2 - top / seen.unshown, 0, 1) if seen.unshown > 0 else np.zeros_like(top)
    part, later = rise * lost / np.sqrt(12), np.where(flying, 0.0, top / 3)
    spread = part[:, :, None] * part[:, None, :] + later[:, :, None] ** 2 * np.eye(len(seen.since))
    lower = np.linalg.cholesky(seen.noise + spread)
    distance = np.linalg.solve(lower, (seen.lift - rise * (1 - lost / 2) - later)[:, :, None])
    misfit = np.log1p(np.sum(distance**2, axis=(1, 2)) / NOISE_FRAMES)
    size = np.log(np.diagonal(lower, axis1=1, axis2=2)).sum(axis=1)
    return np.asarray(-size - (NOISE_FRAMES + len(seen.since)) / 2 * misfit)
