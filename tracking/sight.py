"""A ball's outline in many frames: where it is roughly → rims and circles, a batch of frames at a time."""

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from tracking.circle import MARGIN_PX, Guess, find_rims, fit_circles
from tracking.detect import Blob
from tracking.limb import Limb
from tracking.planes import Image
from tracking.recording import Recording, View
from tracking.sharp import limb_of, sharpened
from tracking.sighting import Cutting, Sighting, cut_out
from tracking.video import revisit

FloatArray = npt.NDArray[np.float64]

BATCH = 256  # frames at a time
NARROW = 0.05  # radii around a circle found before, beside the margin
WIDE = 0.15  # ... around a first guess
RADIUS_TOLERANCE = 0.15  # a fitted circle this much larger or smaller than the ball is something else
MOVING_PX = 0.3  # a frame: what moves less rests
SURPRISE_PX = 1.5  # a ball this far from where it was expected is expected anew
LONGEST_STRIDE = 32  # frames looked through at once
MEMORY = 25  # sightings of which the median radius is expected
SAME_RADIUS = 0.01  # a ball whose size changes by less is looked for with one radius
REFITS = 3
SMEARED = 0.25  # radii of motion blur, from which a ball's own size is not believed
LIMB_FRAMES = 8  # pictures on which a ball's limb is measured, from the sharper half of all


def sight_along(recording: Recording, path: Mapping[int, Blob], radius: float) -> list[Sighting]:
    """See a ball of some radius (px) wherever it is on its path, patches by the number of the frame."""
    seen: list[Sighting] = []
    cuttings: list[Cutting] = []
    limb = _limb_along(recording, path, radius)
    for view in revisit(recording, path):
        cuttings.append(_cut_on_path(view, path, radius))
        if len(cuttings) == BATCH:
            seen += sharpened(cuttings, _sight_on_path(cuttings, path, radius), limb)
            cuttings.clear()
    return seen + sharpened(cuttings, _sight_on_path(cuttings, path, radius), limb)


def sight_resting(recording: Recording, guess: Guess) -> list[Sighting]:
    """See a ball that rests first and may be struck later; the guess may be a radius too high or too low."""
    seen: list[Sighting] = []
    waiting: list[Cutting] = []
    stride, half, limb = 1, 2 * guess[2] + _half(guess[2], 0.0), Limb()
    for view in revisit(recording):
        if not seen and not waiting:
            guess = _find_resting(view.frame().image, guess)
            first = [cut_out(view, guess[:2], half)]
            limb = limb_of(first, [s for s in _sight(first, [guess], np.zeros(1)) if s is not None])
        waiting.append(cut_out(view, guess[:2], half))
        if len(waiting) >= stride:
            guess, stride = _advance(seen, waiting, guess, stride, limb)
    while waiting:
        guess, stride = _advance(seen, waiting, guess, stride, limb)
    return seen


def _limb_along(recording: Recording, path: Mapping[int, Blob], radius: float) -> Limb:
    """Measure the limb of a ball on some pictures in which its motion smears it little."""
    sharper = sorted(sorted(path, key=lambda number: path[number].blur)[: len(path) // 2 + 1])
    some = {sharper[i] for i in np.linspace(0, len(sharper) - 1, LIMB_FRAMES).astype(int)}
    cuttings = [_cut_on_path(view, path, radius) for view in revisit(recording, some)]
    return limb_of(cuttings, _sight_on_path(cuttings, path, radius))


def _cut_on_path(view: View, path: Mapping[int, Blob], radius: float) -> Cutting:
    blob = path[view.index]
    return cut_out(view, (blob.x, blob.y), _half(radius, blob.blur))


def _sight_on_path(cuttings: Sequence[Cutting], path: Mapping[int, Blob], radius: float) -> list[Sighting]:
    """See the ball in a batch; again with the radius of the frames around where that is another."""
    blobs = [path[cutting.frame] for cutting in cuttings]
    guesses: list[Guess] = [(blob.x, blob.y, radius) for blob in blobs]
    blur = np.array([blob.blur for blob in blobs])
    found = _sight(cuttings, guesses, blur)
    for _ in range(REFITS):
        around = _radius_around(found, radius)
        if np.abs(around - [guess[2] for guess in guesses]).max(initial=0.0) < SAME_RADIUS * radius:
            break
        guesses = [
            (*guess[:2], r) if seen is None else (seen.circle.x, seen.circle.y, r)
            for guess, seen, r in zip(guesses, found, around.tolist(), strict=True)
        ]
        found = _sight(cuttings, guesses, blur)
    return [sighting for sighting in found if sighting is not None]


def _radius_around(found: Sequence[Sighting | None], radius: float) -> FloatArray:
    """Median radius in the sharp frames around each one: a ball that comes nearer grows."""
    seen = {
        i: sighting.circle.radius
        for i, sighting in enumerate(found)
        if sighting is not None and sighting.blur < SMEARED * radius
    }
    if not seen:
        return np.full(len(found), radius)
    padded = np.pad(list(seen.values()), MEMORY // 2, mode="edge")
    around = np.median(np.lib.stride_tricks.sliding_window_view(padded, MEMORY), axis=1)
    return np.asarray(np.interp(np.arange(len(found)), list(seen), around))


def _advance(
    seen: list[Sighting], waiting: list[Cutting], guess: Guess, stride: int, limb: Limb
) -> tuple[Guess, int]:
    """See the ball in some of the frames that wait, up to the first in which it is not where expected."""
    batch = waiting[:stride]
    places = [_expected(seen, guess, cutting.frame) for cutting in batch]
    first = [s for s in _sight(batch, places, np.zeros(len(batch))) if s is not None]
    found = {sighting.frame: sighting for sighting in sharpened(batch, first, limb)}
    for count, (place, cutting) in enumerate(zip(places, batch, strict=True), start=1):
        sighting = found.get(cutting.frame)
        if sighting is None:
            continue
        seen.append(sighting)
        guess = (sighting.circle.x, sighting.circle.y, _expected_radius(seen))
        if np.hypot(guess[0] - place[0], guess[1] - place[1]) > SURPRISE_PX:
            del waiting[:count]
            return guess, 1
    del waiting[:stride]
    return guess, min(2 * stride, LONGEST_STRIDE)


def _expected(seen: Sequence[Sighting], guess: Guess, frame: int) -> Guess:
    """Expect a ball that moves to go on as it did from the frame before the last."""
    if len(seen) < 2 or seen[-1].frame - seen[-2].frame > 1:
        return guess
    before, last = seen[-2].circle, seen[-1].circle
    step = np.array([last.x - before.x, last.y - before.y])
    if np.hypot(*step) < MOVING_PX:
        return guess
    x, y = (last.x, last.y) + step * (frame - seen[-1].frame)
    return float(x), float(y), guess[2]


def _expected_radius(seen: Sequence[Sighting]) -> float:
    return float(np.median([sighting.circle.radius for sighting in seen[-MEMORY:]]))


def _sight(cuttings: Sequence[Cutting], guesses: Sequence[Guess], blur: FloatArray) -> list[Sighting | None]:
    """Fit twice, the second time from a good centre and in a narrow ring; None where no rim is seen."""
    places = np.array(guesses, dtype=np.float64).reshape(-1, 3)
    patches, radius = [cutting.patch for cutting in cuttings], places[:, 2]
    coarse = find_rims(patches, places, reach=WIDE * radius + MARGIN_PX + blur / 2, blur=blur)
    first = fit_circles(coarse, places, free_radius=False)
    centres = np.array([places[i] if c is None else (c.x, c.y, c.radius) for i, c in enumerate(first)])
    rims = find_rims(patches, centres, reach=MARGIN_PX + NARROW * radius + blur / 2, blur=blur)
    circles = fit_circles(rims, centres, free_radius=True)
    return [
        Sighting(frame=cutting.frame, time=cutting.time, rim=rim, circle=circle, blur=own)
        if before and circle and abs(circle.radius - size) <= RADIUS_TOLERANCE * size + own / 4
        else None
        for cutting, before, rim, circle, size, own in zip(
            cuttings, first, rims, circles, radius.tolist(), blur.tolist(), strict=True
        )
    ]


def _find_resting(image: Image, guess: Guess) -> Guess:
    """Find the resting ball up to a radius above or below the guess: where the best rim is."""
    x, y, radius = guess
    guesses: list[Guess] = [(x, y + shift, radius) for shift in np.linspace(-1, 1, 9) * radius]
    for reach in (WIDE * radius + MARGIN_PX, MARGIN_PX):
        rims = find_rims([image] * len(guesses), guesses, reach=reach)
        circles = [c for c in fit_circles(rims, guesses, free_radius=False) if c is not None]
        guesses = [(c.x, c.y, radius) for c in circles]
    best = min(circles, key=lambda circle: circle.y_sd / circle.inliers, default=None)
    return guess if best is None else (best.x, best.y, radius)


def _half(radius: float, blur: float) -> float:
    """Half the width of what is cut out, so that no ray leaves it."""
    return (1 + 2 * WIDE) * radius + 2 * MARGIN_PX + blur + 2
