"""Motion towards the camera or away from it: told by the size of the ball, and undone.

A ball that drifts off sideways mostly does so in depth as well, unseen, and what is farther away looks
smaller and slower; and before a camera that looks down, or up, a ball is farther away in one place than in
another. The trend of its radius over a whole recording is known far better than one radius.
"""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tracking.track import Track

FloatArray = npt.NDArray[np.float64]

WORTH_SAYING = 0.02  # change of size along the path
CERTAIN = 4.0  # standard deviations of it
SURE = 5.0  # the same for a size that follows the height, as it also does where light or background change
FEWEST_FRAMES = 20
SLOW = 1.0  # radii a frame: faster balls are smeared too far to tell their size
HUBER = 1.345
ROUNDS = 10
TINY = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Depth:
    """How far away a ball is, told by its size.

    Attributes
    ----------
    size : ndarray of float, shape (n,)
        Without noise and blur, over the radius of its track.
    drift, drift_sd : float
        Change of size from the first frame to the last, and its sd; negative for a ball that goes away.
    tilt, tilt_sd : float
        Change of size from the top of its path to the bottom, and its sd; 0 unless it is sure.
    """

    size: FloatArray
    drift: float = 0.0
    drift_sd: float = np.inf
    tilt: float = 0.0
    tilt_sd: float = np.inf

    @property
    def drifts(self) -> bool:
        """Whether the ball surely comes or goes, so far that it matters."""
        return abs(self.drift) > max(WORTH_SAYING, CERTAIN * self.drift_sd)

    @property
    def tilts(self) -> bool:
        """Whether the ball is surely farther away in one height than in another."""
        return self.tilt != 0


def motion_in_depth(track: Track) -> Depth:
    """Find the trend of a ball's size.

    Parameters
    ----------
    track : Track
        In px, with the radius seen in each frame.

    Returns
    -------
    Depth
        Straight in time, for what flies keeps its speed along the view, and straight in height before a
        camera that is not level. What motion blur adds to a radius is found beside it and left out.
    """
    count = len(track.time)
    known = np.isfinite(track.sizes) if len(track.sizes) == count else np.zeros(count, dtype=bool)
    if not track.shows_size or known.sum() < FEWEST_FRAMES:
        return Depth(size=np.ones(count))
    step = np.abs(np.gradient(track.y, track.frame))
    slow = known & (step < SLOW * track.radius)
    used = slow if slow.sum() >= FEWEST_FRAMES else known
    blur, time, height = step / max(step.max(), TINY), _scaled(track.time), _scaled(track.y)
    design = np.column_stack((blur, np.ones(count), time, height))
    sizes = track.sizes[used] / track.radius
    trend, sd, again = _robust(design[used], sizes)
    tilt, tilt_sd = 2 * trend[3], 2 * sd[3] * again
    if abs(tilt) < max(WORTH_SAYING, SURE * tilt_sd):
        design, tilt, tilt_sd = design[:, :3], 0.0, np.inf
        trend, sd, _ = _robust(design[used], sizes)
    size = design[:, 1:] @ trend[1:]
    return Depth(size=size, drift=2 * trend[2], drift_sd=2 * sd[2], tilt=tilt, tilt_sd=tilt_sd)


def undone(track: Track, depth: Depth, centre: tuple[float, float]) -> Track:
    """Give the places (px) at which the ball would be seen were it always so far away that its size is 1.

    Parameters
    ----------
    track : Track
        In px.
    depth : Depth
    centre : (x, y)
        Middle of the picture, px: what is seen there stays there.
    """
    x, y = centre
    return replace(track, x=x + (track.x - x) / depth.size, y=y + (track.y - y) / depth.size)


def _scaled(values: FloatArray) -> FloatArray:
    """Values from -1 at the least to 1 at the greatest."""
    least, greatest = float(values.min()), float(values.max())
    return np.asarray(2 * (values - least) / max(greatest - least, TINY) - 1)


def _robust(design: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Least squares with Huber's weights: solution, its sd, and how many times that is if errors last."""
    weights = np.ones(len(values))
    for _ in range(ROUNDS):
        root = np.sqrt(weights)
        solution, *_ = np.linalg.lstsq(design * root[:, None], values * root, rcond=None)
        errors = values - design @ solution
        scale = max(1.4826 * float(np.median(np.abs(errors))), 1e-6)
        weights = 1 / np.maximum(np.abs(errors) / (HUBER * scale), 1.0)
    inverse = np.linalg.pinv((design * weights[:, None]).T @ design)
    sd = scale * np.sqrt(np.diag(inverse))
    return np.asarray(solution), np.asarray(sd), _lasting(np.clip(errors, -3 * scale, 3 * scale))


def _lasting(errors: FloatArray) -> float:
    """How many times as large the sd of a mean is as if errors were independent, by what neighbours share."""
    shared = float(errors[1:] @ errors[:-1]) / max(float(errors @ errors), TINY)
    return float(np.sqrt((1 + shared) / (1 - shared))) if 0 < shared < 1 else 1.0
