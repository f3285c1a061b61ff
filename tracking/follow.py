"""Follow one round thing through a recording, from a frame in which it moves, back to its rest and forward.

Its last picture is searched for around the expected place, as far away as its last step reaches (it may have
been struck); the rim then gives the centre. Nothing is filled in where it was not seen.
"""

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import cv2
import numpy as np
import numpy.typing as npt

from tracking.circle import Circle, Guess, locate_circle
from tracking.movers import Mover, find_movers
from tracking.planes import Image
from tracking.video import Frame, Recording, revisit

FloatArray = npt.NDArray[np.float64]
RADIUS_GUESSES = (0.5, 0.65, 0.8, 1.0, 1.25)  # of half the patch's width, which may hold a shadow
REST_SECONDS = 0.4  # of rest that are looked at
REST_FRAMES = 30  # ... and at least so many frames
AT_REST = 0.1  # radii that a thing at rest seems to move at most
PATCH_RADII = 1.5  # half the width of the picture kept of a sighting
KEPT_BYTES = 100_000_000
KEPT_DIAMETERS = 6.0  # half the width of what is kept of each picture before the motion
MARGIN_PX = 2.5
RADIUS_TOLERANCE = 0.15  # a fitted circle this much larger or smaller than the thing is something else
LIKENESS = 0.5  # correlation below which a place does not look like the thing
PULL = 0.15  # likeness that a place at the edge of the search has to make up for
LOST_FRAMES = 6
SHARP = 0.03  # a ball's rim is located better than this share of its radius
MOST_MOVERS = 8
FEWEST_SIGHTINGS = 8
MEMORY = 15  # sightings from which the expected radius is taken


@dataclass(frozen=True, slots=True, kw_only=True)
class Sighting:
    """The thing followed in one frame: a circle with its radius free, and the picture around it.

    The upper left pixel of `patch` is at `corner` (x, y) of the picture.
    """

    frame: int
    time: float
    circle: Circle
    patch: Image
    corner: tuple[int, int]


def moving_balls(recording: Recording) -> list[list[Sighting]]:
    """Follow each round thing that moves, once; the one that goes furthest first."""
    balls: list[list[Sighting]] = []
    for mover in find_movers(recording)[:MOST_MOVERS]:
        if not any(_same(mover, ball) for ball in balls):
            ball = follow(recording, mover)
            if len(ball) >= FEWEST_SIGHTINGS and _is_sharp(ball):
                balls.append(ball)
    return balls


def follow(recording: Recording, mover: Mover) -> list[Sighting]:
    """See a mover from shortly before it moves until it is lost or rests, in order of time."""
    frames = (view.frame() for view in revisit(recording))
    number = mover.taken_up
    kept, corner = _keep(recording, frames, mover, number)
    blob = mover.blobs[number]
    start = _settle(kept[-1].image, (blob.x - corner[0], blob.y - corner[1]), mover.diameter / 2)
    if start is None:
        return []
    back = _look_along(iter(reversed(kept)), _Followed(guess=start))
    seen = [_shifted(sighting, corner) for sighting in reversed(back.seen)]
    if not seen:
        return []
    template = back.first_template
    ahead = _Followed(guess=_as_guess(seen[-1].circle), seen=seen, template=template)
    return _look_along(frames, ahead).seen


def _same(mover: Mover, ball: Sequence[Sighting]) -> bool:
    """Tell whether a mover is a ball already followed."""
    places = {sighting.frame: sighting.circle for sighting in ball}
    moving = zip(mover.frames[mover.taken_up :], mover.blobs[mover.taken_up :], strict=True)
    near = [
        frame in places
        and np.hypot(blob.x - places[frame].x, blob.y - places[frame].y) < 1.5 * places[frame].radius
        for frame, blob in moving
    ]
    return float(np.mean(near)) > 0.5


def _is_sharp(ball: Sequence[Sighting]) -> bool:
    """Tell a ball's rim from what a hand shows by chance."""
    share = [max(s.circle.x_sd, s.circle.y_sd) / s.circle.radius for s in ball]
    return float(np.median(share)) < SHARP


def _keep(
    recording: Recording, frames: Iterator[Frame], mover: Mover, number: int
) -> tuple[list[Frame], tuple[int, int]]:
    """Keep what surrounds the seed in the frames before it, to go through them backwards."""
    blob, last = mover.blobs[number], mover.frames[number]
    half = KEPT_DIAMETERS * mover.diameter
    left, top = max(0, int(blob.x - half)), max(0, int(blob.y - half))
    window = (slice(top, int(blob.y + half) + 1), slice(left, int(blob.x + half) + 1))
    each = 3 * (int(blob.y + half) + 1 - top) * (int(blob.x + half) + 1 - left)
    resting = max(int(REST_SECONDS * recording.capture_fps), REST_FRAMES)
    most = min(resting + number, KEPT_BYTES // each)
    kept: deque[Frame] = deque(maxlen=max(most, 2))
    for frame in frames:
        kept.append(replace(frame, image=frame.image[window].copy()))
        if frame.index >= last:
            break
    return list(kept), (left, top)


def _settle(image: Image, place: tuple[float, float], radius: float) -> Guess | None:
    """Find the clearest circle at a place: whichever radius is tried, a shadow's outline is less sharp."""
    circles = [_settled(image, (*place, share * radius)) for share in RADIUS_GUESSES]
    found = [circle for circle in circles if circle is not None]
    if not found:
        return None
    return _as_guess(min(found, key=lambda circle: (circle.x_sd + circle.y_sd) / circle.inliers**2))


def _settled(image: Image, guess: Guess) -> Circle | None:
    """Fit again and again from the circle just found, until the guess no longer matters."""
    circle = None
    for _ in range(5):
        circle = locate_circle(image, guess, reach=0.2 * guess[2] + MARGIN_PX, free_radius=True)
        if circle is None:
            return None
        guess = _as_guess(circle)
    return circle


@dataclass(slots=True, kw_only=True)
class _Followed:
    """What is known of a thing while it is followed."""

    guess: Guess
    seen: list[Sighting] = field(default_factory=list)
    template: Image | None = None
    first_template: Image | None = None


def _look_along(frames: Iterator[Frame], thing: _Followed) -> _Followed:
    """Look for the thing in frame after frame until it is lost or has come to rest."""
    missed, size = 0, 0
    for frame in frames:
        guess = _expect(frame, thing)
        sighting = None if guess is None else _sight(frame, guess)
        missed = 0 if sighting is not None else missed + 1
        if missed > LOST_FRAMES or size > KEPT_BYTES or _rests(thing):
            break
        if sighting is not None:
            size += sighting.patch.nbytes
            thing.seen.append(sighting)
            thing.template = _patch(frame.image, sighting.circle.x, sighting.circle.y, thing.guess[2] + 4)
            thing.first_template = thing.template if thing.first_template is None else thing.first_template
            radius = float(np.median([s.circle.radius for s in thing.seen[-MEMORY:]]))
            thing.guess = (sighting.circle.x, sighting.circle.y, radius)
    return thing


def _expect(frame: Frame, thing: _Followed) -> Guess | None:
    """Expect the thing where it looks most like its last picture, near where it was going."""
    x, y, radius = thing.guess
    if thing.template is None:
        return thing.guess
    step = _step(frame, thing.seen[-3:])
    reach = int(np.ceil(radius + 1.1 * float(np.hypot(*step))))
    x, y = round(x + step[0]), round(y + step[1])
    half = (thing.template.shape[0] - 1) // 2
    likeness = cv2.matchTemplate(
        _patch(frame.image, x, y, half + reach), thing.template, cv2.TM_CCOEFF_NORMED
    )
    away = np.arange(-reach, reach + 1) / reach
    row, column = np.unravel_index(
        np.argmax(likeness - PULL * (away[:, None] ** 2 + away**2)), likeness.shape
    )
    if not likeness[row, column] > LIKENESS:
        return None
    return float(x + column - reach), float(y + row - reach), radius


def _rests(thing: _Followed) -> bool:
    """Tell whether the last sightings show no motion."""
    latest = [s.circle for s in thing.seen if abs(s.time - thing.seen[-1].time) <= REST_SECONDS]
    enough = len(thing.seen) > REST_FRAMES and abs(thing.seen[-1].time - thing.seen[0].time) > REST_SECONDS
    spread = np.ptp([(c.x, c.y) for c in latest], axis=0) if enough else np.inf
    return bool(np.max(spread) < AT_REST * thing.guess[2])


def _step(frame: Frame, seen: list[Sighting]) -> FloatArray:
    """How far it goes until this frame if it goes on as in its last sightings, px."""
    first, last = seen[0], seen[-1]
    if first is last:
        return np.zeros(2)
    way = np.array([last.circle.x - first.circle.x, last.circle.y - first.circle.y])
    return np.asarray(way * (frame.time - last.time) / (last.time - first.time))


def _patch(image: Image, x: float, y: float, half: float) -> Image:
    """Cut out a square around a place, beyond the border by repeating it."""
    size = 2 * int(np.ceil(half)) + 1
    return np.asarray(cv2.getRectSubPix(image, (size, size), (float(x), float(y))))


def _sight(frame: Frame, guess: Guess) -> Sighting | None:
    """Fit twice, the second time from a good centre and in a narrow ring, and keep the picture around it."""
    radius = guess[2]
    coarse = locate_circle(frame.image, guess, reach=0.15 * radius + MARGIN_PX)
    if coarse is None:
        return None
    centre = (coarse.x, coarse.y, radius)
    circle = locate_circle(frame.image, centre, reach=MARGIN_PX + 0.05 * radius, free_radius=True)
    if circle is None or abs(circle.radius - radius) > RADIUS_TOLERANCE * radius:
        return None
    half = PATCH_RADII * radius + MARGIN_PX
    corner = (max(0, int(circle.x - half)), max(0, int(circle.y - half)))
    patch = frame.image[corner[1] : int(circle.y + half) + 2, corner[0] : int(circle.x + half) + 2].copy()
    return Sighting(frame=frame.index, time=frame.time, circle=circle, patch=patch, corner=corner)


def _shifted(sighting: Sighting, corner: tuple[int, int]) -> Sighting:
    """Move a sighting from what was kept of a picture to the picture."""
    (left, top), circle = corner, sighting.circle
    moved = replace(circle, x=circle.x + left, y=circle.y + top)
    return replace(sighting, circle=moved, corner=(sighting.corner[0] + left, sighting.corner[1] + top))


def _as_guess(circle: Circle) -> Guess:
    """Start from a circle."""
    return circle.x, circle.y, circle.radius
