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

SMALL_MOTION = 3.0  # a ball that hardly moves is compressed worse than one that flies, by this factor
MEMORY = 0.004  # s after which compression errs anew
UNSHOWN = 8.0  # a hop lower than this, in errors of compression, may be left out of the picture in part
REST_SHARE_SD = 0.001  # how well heights near the plate compare with that of rest, as a share of the radius
NOISE_FRAMES = 4  # the noise is known as if from so many frames
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

    def until(self, time: float) -> "_Seen":
        """Leave out what is seen later than some time after the impact."""
        kept = self.since <= time
        return _Seen(
            since=self.since[kept],
            lift=self.lift[kept],
            noise=self.noise[np.ix_(kept, kept)],
            unshown=self.unshown,
        )


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
    since, frame_sd = lower.time[after] - impact, lower.y_sd[after]
    compression, level = SMALL_MOTION * lower.shared_sd, REST_SHARE_SD * lower.radius
    alike = np.exp(-np.abs(np.subtract.outer(since, since)) / MEMORY)
    seen = _Seen(
        since=since,
        lift=lower.y[after] - float(np.median(lower.y[before])),
        noise=np.diag(frame_sd**2) + compression**2 * alike + level**2,
        unshown=UNSHOWN * lower.shared_sd,
    )
    # the highest hop that these frames allow, or that is over before the first of them
    highest = max(float(seen.lift.max()), 0.0) + FARTHEST * float(np.sqrt(np.median(np.diag(seen.noise))))
    fastest = max(float(np.sqrt(2 * flight.gravity * highest)), flight.gravity * float(since[0]) / 2)
    seen = seen.until(2 * fastest / flight.gravity)
    mean, spread = _weigh(seen, flight, np.linspace(0, fastest, VELOCITIES))
    reach = FARTHEST * max(spread, fastest / VELOCITIES)
    return _weigh(seen, flight, np.linspace(max(mean - reach, 0.0), mean + reach, VELOCITIES))


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
