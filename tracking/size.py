"""How large a ball of unknown size is in the picture."""

from collections.abc import Mapping

import numpy as np

from tracking.circle import MARGIN_PX, Circle, Guess, find_rims, fit_circles
from tracking.detect import Blob
from tracking.patch import Patch
from tracking.recording import Recording
from tracking.sighting import cut_out
from tracking.video import revisit

RADIUS_FRAMES = 9  # pictures on which the radius is measured
STARTING_SIZES = (1.0, 1.2, 1.45, 1.75)
"""Times the width at half contrast, which misses the dark side of a ball."""
HALF_WIDTH = 3.0  # of what is looked at, times the first guess
REFITS = 5
SETTLED_PX = 0.01
REACH = 0.2  # radii


def measure_radius(recording: Recording, path: Mapping[int, Blob], guess: float) -> float:
    """Measure a ball's radius on some of the pictures in which it is least smeared by its motion.

    Each is fitted from several sizes and the sharpest outline believed: shading has softer edges, further in.

    Parameters
    ----------
    recording : Recording
    path : the patch that is the ball, by the number of the frame
    guess : float
        Radius in px as the patches tell it; cut at half contrast they are too small.

    Returns
    -------
    float
        Radius, px; the guess if no outline is found.
    """
    sharpest = sorted(path, key=lambda number: path[number].blur)[:RADIUS_FRAMES]
    cuttings = [
        cut_out(view, (path[view.index].x, path[view.index].y), HALF_WIDTH * guess)
        for view in revisit(recording, set(sharpest))
    ]
    patches = [cutting.patch for cutting in cuttings for _ in STARTING_SIZES]
    circles = _settled(
        patches,
        [(path[c.frame].x, path[c.frame].y, size * guess) for c in cuttings for size in STARTING_SIZES],
    )
    radii = []
    for first in range(0, len(circles), len(STARTING_SIZES)):
        found = [circle for circle in circles[first : first + len(STARTING_SIZES)] if circle is not None]
        if found:
            radii.append(min(found, key=lambda circle: circle.y_sd / circle.inliers).radius)
    return float(np.median(radii)) if radii else guess


def _settled(patches: list[Patch], guesses: list[Guess]) -> list[Circle | None]:
    """Fit again and again from the circles just found, until the guesses no longer matter."""
    found: list[Circle | None] = [None] * len(patches)
    going = list(range(len(patches)))
    for _ in range(REFITS):
        reach = np.array([REACH * guesses[i][2] + MARGIN_PX for i in going])
        starts = [guesses[i] for i in going]
        rims = find_rims([patches[i] for i in going], starts, reach=reach)
        for i, circle in zip(tuple(going), fit_circles(rims, starts, free_radius=True), strict=True):
            before, found[i] = guesses[i][2], circle
            if circle is not None:
                guesses[i] = (circle.x, circle.y, circle.radius)
            if circle is None or abs(circle.radius - before) < SETTLED_PX:
                going.remove(i)
    return found
