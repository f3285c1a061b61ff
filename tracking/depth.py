"""Motion towards the camera or away from it: told by the size of the ball, and undone.

A ball that drifts off sideways mostly does so in depth as well, unseen, and what is farther away looks
smaller and slower. The trend of its radius over a whole recording is known far better than one radius.
"""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tracking.track import Track

FloatArray = npt.NDArray[np.float64]

WORTH_SAYING = 0.02  # change of size along the path
CERTAIN = 4.0  # standard deviations of it
FEWEST_FRAMES = 20
SLOW = 0.5  # radii a frame: faster balls are smeared, and look larger or smaller by their shading
HUBER = 1.345
ROUNDS = 10


@dataclass(frozen=True, slots=True, kw_only=True)
class Depth:
    """Size of the ball over the one of its track, (n,) without noise; change along the path and its sd."""

    size: FloatArray
    change: float
    change_sd: float

    @property
    def is_certain(self) -> bool:
        """Whether the ball surely moves in depth, so far that it matters."""
        return abs(self.change) > max(WORTH_SAYING, CERTAIN * self.change_sd)


def motion_in_depth(track: Track) -> Depth:
    """Find the trend of a ball's size.

    Parameters
    ----------
    track : Track
        In px, with the radius seen in each frame.

    Returns
    -------
    Depth
        A parabola in time; what motion blur adds to a radius is found beside it and left out.
    """
    count = len(track.time)
    if len(track.sizes) != count or count < FEWEST_FRAMES:
        return Depth(size=np.ones(count), change=0.0, change_sd=np.inf)
    since = _scaled(track.time)
    step = np.abs(np.gradient(track.y, track.frame))
    design = np.column_stack((np.ones(count), since, since**2, step / max(float(step.max()), 1e-9)))
    slow = step < SLOW * track.radius
    used = slow if slow.sum() >= FEWEST_FRAMES else np.ones(count, dtype=bool)
    solution, covariance = _robust(design[used], track.sizes[used] / track.radius)
    trend = design[:, :3] @ solution[:3]
    return Depth(
        size=trend,
        change=float(trend[-1] / trend[0]) - 1,
        change_sd=float(2 * np.sqrt(covariance[1, 1])),
    )


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


def _scaled(time: FloatArray) -> FloatArray:
    """Time from -1 at the first frame to 1 at the last."""
    return np.asarray(2 * (time - time[0]) / (time[-1] - time[0]) - 1)


def _robust(design: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Least squares with Huber's weights: solution and covariance."""
    weights = np.ones(len(values))
    for _ in range(ROUNDS):
        root = np.sqrt(weights)
        solution, *_ = np.linalg.lstsq(design * root[:, None], values * root, rcond=None)
        apart = np.abs(values - design @ solution)
        scale = max(1.4826 * float(np.median(apart)), 1e-6)
        weights = 1 / np.maximum(apart / (HUBER * scale), 1.0)
    inverse = np.linalg.pinv((design * weights[:, None]).T @ design)
    return np.asarray(solution), np.asarray(inverse * scale**2)
