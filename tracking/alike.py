"""What pictures show alike of a ball's outline is how it looks, and not where it is.

Light from one side, gloss or a dark wall behind let the same part of a rim seem farther out or in, picture
after picture. Each circle is then drawn there a little, and more or less so as other parts are seen well or
badly: places jump. What all pictures have in common is taken off the points of each rim before circles are
fitted.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tracking.circle import Circle, Rim, fit_circles, places_of


def fit_alike(rims: Sequence[Rim], circles: Sequence[Circle | None]) -> list[Circle | None]:
    """Fit circles of the same radii again, without what all rims have in common.

    Parameters
    ----------
    rims : sequence of Rim
        Of one ball in several pictures.
    circles : as `fit_circles` gives them
        Where one is None, there is none afterwards.
    """
    seen = [(i, circle) for i, circle in enumerate(circles) if circle is not None]
    if not seen:
        return list(circles)
    places = places_of([circle for _, circle in seen])
    ways = np.array([rims[i].points for i, _ in seen]) - places[:, None, :2]
    distance = np.linalg.norm(ways, axis=2)
    beyond = distance - places[:, 2:]
    common = np.zeros(beyond.shape[1])
    met = np.isfinite(beyond).any(axis=0)
    common[met] = np.nanmedian(beyond[:, met], axis=0)
    points = places[:, None, :2] + ways * (1 - common / distance)[..., None]
    evened = [replace(rims[i], points=own) for (i, _), own in zip(seen, points, strict=True)]
    fitted = list(circles)
    for (i, before), circle in zip(seen, fit_circles(evened, places, free_radius=False), strict=True):
        fitted[i] = circle or before
    return fitted
