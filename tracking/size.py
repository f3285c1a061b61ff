"""How large a ball of unknown size is in the picture."""

from collections.abc import Iterable, Mapping

import numpy as np

from tracking.circle import MARGIN_PX, Circle, Image, locate_circle
from tracking.detect import Blob
from tracking.video import Frame

RADIUS_FRAMES = 15  # pictures on which the radius is measured
STARTING_SIZES = (1.0, 1.2, 1.5)  # times the width at half contrast, which misses the dark side of a ball


def sharpest(path: Mapping[int, Blob]) -> set[int]:
    """Numbers of the frames in which the ball is least smeared by its motion."""
    return set(sorted(path, key=lambda number: abs(path[number].height - path[number].width))[:RADIUS_FRAMES])


def measure_radius(frames: Iterable[Frame], path: Mapping[int, Blob], guess: float) -> float:
    """Measure a ball's radius on some of its sharpest pictures.

    Parameters
    ----------
    frames : those pictures
    path : the patch that is the ball, by the number of the frame
    guess : float
        Radius in px as the patches tell it; cut at half contrast they are too small.

    Returns
    -------
    float
        Radius, px; the guess if no outline is found.
    """
    places = ((frame, path[frame.index]) for frame in frames)
    radii = [_settled_radius(frame.image, (blob.x, blob.y, guess)) for frame, blob in places]
    found = [radius for radius in radii if radius is not None]
    return float(np.median(found)) if found else guess


def _settled_radius(image: Image, guess: tuple[float, float, float]) -> float | None:
    """Fit from several sizes and believe the sharpest outline: shading has softer edges, further in."""
    x, y, radius = guess
    fits = [_settled_circle(image, (x, y, radius * larger)) for larger in STARTING_SIZES]
    found = [circle for circle in fits if circle is not None]
    return min(found, key=lambda circle: circle.y_sd / circle.inliers).radius if found else None


def _settled_circle(image: Image, guess: tuple[float, float, float]) -> Circle | None:
    """Fit again and again from the circle just found, until the guess no longer matters."""
    circle = None
    for _ in range(5):
        circle = locate_circle(image, guess, reach=0.2 * guess[2] + MARGIN_PX, free_radius=True)
        if circle is None:
            return None
        guess = (circle.x, circle.y, circle.radius)
    return circle
