"""The final outlines of a followed ball, with the radius that its place in the picture asks for.

Seen at an angle a ball on a plane shrinks with its distance, and the inverse of the distance of points on a
plane is linear in picture coordinates (x, y), whatever the camera. So is the radius. A ball whose lower limb
is dark has two rims to choose from; the radius of all the other frames tells which. A ball that leaves the
plane, towards a camera above, looks larger than this.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tracking.circle import Circle, find_rim, fit_circle
from tracking.follow import Sighting
from tracking.limb import measure_limb, sharpen
from tracking.track import Track

FloatArray = npt.NDArray[np.float64]

REFINEMENTS = 3
SETTLED_PX = 0.03
REACH = 0.12  # radii around the expected rim
MARGIN_PX = 2.0
FINEST_PX = 0.02  # no rim is located better than this in a compressed picture
LIMB_FRAMES = 12  # on which the ball's limb is measured
WHOLE = 0.9  # of the most that is seen of its rim is seen in those
LEAST_SPAN = 4.0  # radii a ball must have gone for its radius to tell the perspective
HUBER = 1.345
HIDDEN_HALF_ANGLE = np.deg2rad(30)  # a cue's tip is a quarter as wide as a ball, its shadow comes on top


@dataclass(frozen=True, slots=True, kw_only=True)
class Outlines:
    """A ball's `track` in px, with (n,) radii: as seen in each frame, and as its place asks for, px."""

    track: Track
    seen_radius: FloatArray
    expected_radius: FloatArray


def trace_outlines(ball: str, sightings: Sequence[Sighting], *, hidden: float | None = None) -> Outlines:
    """Fit the rims of all sightings again, with the radius that varies only as the perspective does.

    Parameters
    ----------
    ball : str
        What to call it.
    sightings : sequence of Sighting
    hidden : float, optional
        Direction, rad from x to y down, in which something touches the ball in some of the frames. The rim
        there is left out in all of them, so that a place is never told differently with and without it.
    """
    circles = [sighting.circle for sighting in sightings]
    expected = _plane_radius(circles)
    for _ in range(REFINEMENTS):
        circles = [
            _refined(sighting, circle, radius, hidden) or circle
            for sighting, circle, radius in zip(sightings, circles, expected, strict=True)
        ]
        before, expected = expected, _plane_radius(circles)
        if np.abs(expected - before).max() < SETTLED_PX:
            break
    final = [
        _fit(sighting, circle, (radius, hidden), free_radius=False)
        for sighting, circle, radius in zip(sightings, circles, expected, strict=True)
    ]
    kept = [i for i, circle in enumerate(final) if circle is not None]
    centres = [circle for circle in final if circle is not None]
    seen = np.array([circles[i].radius for i in kept])
    larger = _larger_by_limb([sightings[i] for i in kept], centres)
    seen, expected = larger * seen, larger * expected
    spread = 1.4826 * float(np.median(np.abs(seen - expected[kept]))) if kept else np.nan
    track = Track(
        ball=ball,
        unit="px",
        frame=np.array([sightings[i].frame for i in kept], dtype=np.int64),
        time=np.array([sightings[i].time for i in kept]),
        x=np.array([circle.x for circle in centres]),
        y=np.array([circle.y for circle in centres]),
        x_sd=np.array([max(circle.x_sd, FINEST_PX) for circle in centres]),
        y_sd=np.array([max(circle.y_sd, FINEST_PX) for circle in centres]),
        arc=np.array([circle.arc for circle in centres]),
        radius=float(np.median(expected[kept])),
        radius_sd=max(spread / np.sqrt(max(len(kept), 1)), 1e-3),
    )
    return Outlines(track=track, seen_radius=seen, expected_radius=expected[kept])


def _larger_by_limb(sightings: Sequence[Sighting], circles: Sequence[Circle]) -> float:
    """Radius of a ball's limb over that of its edges, which shading draws inwards."""
    most = WHOLE * max((circle.inliers for circle in circles), default=0.0)
    whole = [i for i, circle in enumerate(circles) if circle.inliers >= most]
    some = [whole[i] for i in np.linspace(0, len(whole) - 1, min(LIMB_FRAMES, len(whole))).astype(int)]
    patches, still = [sightings[i].patch for i in some], np.zeros(len(some))
    inside = [
        replace(circles[i], x=circles[i].x - sightings[i].corner[0], y=circles[i].y - sightings[i].corner[1])
        for i in some
    ]
    _, found = sharpen(patches, inside, still, measure_limb(patches, inside, still))
    ratios = [limb.radius / edge.radius for limb, edge in zip(found, inside, strict=True) if limb is not None]
    return float(np.median(ratios)) if ratios else 1.0


def _plane_radius(circles: Sequence[Circle]) -> FloatArray:
    """Radius that each place asks for: a robust fit, linear in the place (constant if it hardly moves)."""
    place = np.array([(circle.x, circle.y) for circle in circles])
    radius = np.array([circle.radius for circle in circles])
    middle = float(np.median(radius))
    if np.hypot(*np.ptp(place, axis=0)) < LEAST_SPAN * middle:
        return np.full(len(radius), middle)
    centred = (place - place.mean(axis=0)) / np.ptp(place, axis=0).max()
    design = np.column_stack((np.ones(len(radius)), centred))
    weights = np.array([circle.inliers**2 / (circle.x_sd + circle.y_sd + FINEST_PX) for circle in circles])
    scale = np.ones(len(radius))
    for _ in range(10):
        root = np.sqrt(weights * scale)
        solution, *_ = np.linalg.lstsq(design * root[:, None], radius * root, rcond=1e-2)
        apart = np.abs(radius - design @ solution)
        width = HUBER * max(1.4826 * float(np.median(apart)), 1e-3)
        scale = width / np.maximum(apart, width)
    return np.asarray(design @ solution)


def _refined(sighting: Sighting, circle: Circle, radius: float, hidden: float | None) -> Circle | None:
    """Look again where the rim is expected, and let the radius go free at the end."""
    fixed = _fit(sighting, circle, (radius, hidden), free_radius=False)
    return None if fixed is None else _fit(sighting, fixed, (radius, hidden), free_radius=True)


def _fit(
    sighting: Sighting, circle: Circle, rule: tuple[float, float | None], *, free_radius: bool
) -> Circle | None:
    """Fit a circle to the picture kept of a sighting; places are those of the whole picture."""
    (left, top), (radius, hidden) = sighting.corner, rule
    guess = (circle.x - left, circle.y - top, radius)
    rim = find_rim(sighting.patch, guess, reach=REACH * radius + MARGIN_PX)
    if hidden is not None:
        rim = rim.without(hidden, HIDDEN_HALF_ANGLE)
    found = fit_circle(rim, guess, free_radius=free_radius)
    return None if found is None else replace(found, x=found.x + left, y=found.y + top)
