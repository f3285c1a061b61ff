"""How large a ball of unknown size is in the picture."""

from collections.abc import Mapping, Sequence

import numpy as np

from tracking.blob import Blob
from tracking.circle import MARGIN_PX, Circle, Guess, find_rims, fit_circles, places_of
from tracking.consensus import agreed_circles
from tracking.median import weighted_median
from tracking.partial import alike, clarity
from tracking.patch import laid_out
from tracking.path import sharper
from tracking.recording import Recording, View
from tracking.sighting import Cutting, Sighting, cut_out
from tracking.video import revisit

RADIUS_FRAMES = 9  # pictures on which the radius is measured
STARTING_SIZES = (1.0, 1.2, 1.45, 1.75)
"""Times the width at half contrast, which misses the dark side of a ball."""
AGREED_SIZES = (1.0, 1.3, 1.7)
"""Times the mean half width of a patch that a ball may be part of."""
HALF_WIDTH = 3.0  # of what is looked at, times the first guess
REFITS = 5
SETTLED_PX = 0.01
REACH = 0.2  # radii
NARROW = 0.05  # radii: around a circle that many points agree on
SMALLEST_PX = 10.0  # narrower patches have too few pixels to tell circles apart
SHARP = 0.12  # motion blur below this share of the radius
FEWEST_SIZED = 8  # frames that show how large a ball is
MOST_SIZED = 0.8  # of all frames must show it, or the radius is less sure:
UNSEEN = 0.02  # ... by this share, where the wall hides part of the rim in all frames
ANOTHER = 0.2  # share by which circles that are not of one ball differ
DOUBTFUL = 0.008  # radii by which the points of an outline scatter; those of a ball's own scatter less


def measure_radius(
    recording: Recording,
    candidates: Mapping[int, Sequence[Blob]],
    path: Mapping[int, Blob],
    guess: float,
    *,
    part: bool = True,
) -> tuple[float, float]:
    """Measure a ball's radius on some of the pictures in which its motion smears it little.

    Each is fitted from several sizes and the sharpest outline believed: shading has softer edges, further in.
    Where even that is doubtful, as on a shaded ball before a wall of the same grey, circles are sought about
    all patches that the ball may be part of: it may be its highlight that was followed.

    Parameters
    ----------
    recording : Recording
    candidates : all patches that differ from the background, by the number of the frame
    path : the one that is the ball, or part of it
    guess : float
        Radius in px as the patches tell it; cut at half contrast they are too small.
    part : bool
        Whether the path may be that of a part of the ball.

    Returns
    -------
    radius, scatter : float
        Radius, px, and by what share of it the points of the outlines scatter, infinity if most
        show none; the guess if no outline is found.
    """
    some = sharper(path, RADIUS_FRAMES)
    found = []
    for view in revisit(recording, some):
        ball = path[view.index]
        cutting = cut_out(view, (ball.x, ball.y), HALF_WIDTH * guess)
        found.append((cutting, [(ball.x, ball.y, size * guess) for size in STARTING_SIZES]))
    circles, weigh = [_sharpest(fitted) for fitted in _settled(found, REACH)], alike
    if part and _doubt(circles) > DOUBTFUL:
        agreed = [
            _agreed(view, candidates[view.index], path[view.index]) for view in revisit(recording, some)
        ]
        circles = [
            min((first, *others), key=_scatter)
            for first, others in zip(circles, _settled(agreed, NARROW), strict=True)
        ]
        weigh = clarity
    seen = [circle for circle in circles if circle is not None]
    if not seen:
        return guess, np.inf
    radii = places_of(seen)[:, 2]
    near = np.abs(radii / np.quantile(radii, 0.5, method="lower") - 1) < ANOTHER
    return float(weighted_median(radii[near], weigh(seen)[near])), _doubt(circles)


def common_radius(sightings: Sequence[Sighting]) -> tuple[float, float]:
    """Take the median radius over the sharpest pictures that show it, and its standard error, px."""
    blur = np.array([s.blur / s.circle.radius for s in sightings])
    sharp = blur <= max(SHARP, float(np.quantile(blur, 0.25)))
    sized = np.array([s.sized for s in sightings])
    told = sharp & sized if (sharp & sized).sum() >= FEWEST_SIZED else sharp
    radii = np.array([s.circle.radius for s in sightings])[told]
    radius = float(np.median(radii))
    spread = 1.4826 * float(np.median(np.abs(radii - radius)))
    unseen = UNSEEN * radius * (1 - sized.mean()) if sized.mean() < MOST_SIZED else 0.0
    return radius, max(float(np.hypot(spread / np.sqrt(len(radii)), unseen)), 1e-3)


def _agreed(view: View, candidates: Sequence[Blob], ball: Blob) -> tuple[Cutting, list[Guess]]:
    """Look for circles about all patches that a ball may be part of."""
    around = [
        blob
        for blob in candidates
        if 2 * abs(blob.x - ball.x) < blob.width
        and 2 * abs(blob.y - ball.y) < blob.height
        and blob.width > SMALLEST_PX
    ]
    largest = max((blob.width for blob in around), default=ball.width)
    cutting = cut_out(view, (ball.x, ball.y), HALF_WIDTH * largest)
    starts = [
        (blob.x, blob.y, size * (blob.width + blob.height) / 4) for blob in around for size in AGREED_SIZES
    ]
    reach = np.array([REACH * radius + MARGIN_PX for *_, radius in starts])
    rims = find_rims(laid_out([cutting.patch]).take([0] * len(starts)), starts, reach=reach)
    agreed = [
        circle
        for rim, (*_, radius) in zip(rims, starts, strict=True)
        for circle in agreed_circles(rim.points, radius)
    ]
    return cutting, agreed


def _sharpest(circles: Sequence[Circle | None]) -> Circle | None:
    """Choose the circle that is known best."""
    found = [circle for circle in circles if circle is not None]
    return min(found, key=lambda circle: circle.vagueness, default=None)


def _scatter(circle: Circle | None) -> float:
    """How far the points of an outline scatter, in radii; more if many lie off it."""
    return np.inf if circle is None else circle.vagueness / circle.radius


def _doubt(circles: Sequence[Circle | None]) -> float:
    """How much the points of most outlines scatter."""
    return float(np.median([_scatter(circle) for circle in circles]))


def _settled(starts: Sequence[tuple[Cutting, Sequence[Guess]]], share: float) -> list[list[Circle | None]]:
    """Fit circles, again and again from those just found, until the guesses no longer matter."""
    patches = laid_out([cutting.patch for cutting, _ in starts])
    patches = patches.take([i for i, (_, guesses) in enumerate(starts) for _ in guesses])
    guesses = [guess for _, guesses in starts for guess in guesses]
    found: list[Circle | None] = [None] * len(patches)
    going = list(range(len(patches)))
    for _ in range(REFITS):
        reach = np.array([share * guesses[i][2] + MARGIN_PX for i in going])
        now = [guesses[i] for i in going]
        rims = find_rims(patches.take(going), now, reach=reach)
        for i, circle in zip(tuple(going), fit_circles(rims, now, free_radius=True), strict=True):
            before, found[i] = guesses[i][2], circle
            if circle is not None:
                guesses[i] = (circle.x, circle.y, circle.radius)
            if circle is None or abs(circle.radius - before) < SETTLED_PX:
                going.remove(i)
    fitted = iter(found)
    return [[next(fitted) for _ in guesses] for _, guesses in starts]
