"""A ball's outline in many frames: where it is roughly → rims and circles, a batch of frames at a time."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from tracking.blob import Blob
from tracking.circle import MARGIN_PX, Circle, Guess, find_rims, fit_circles
from tracking.limb import Limb
from tracking.median import weighted_median
from tracking.partial import SMEARED, alike, clarity, exceeds, lacks, room, started, with_clear_radius
from tracking.path import sharper
from tracking.recording import Recording, View
from tracking.sharp import limb_of, sharpened
from tracking.sighting import Cutting, Cuttings, Sighting, cut_out, together
from tracking.video import revisit

FloatArray = npt.NDArray[np.float64]
Weigh = Callable[[Sequence[Circle]], FloatArray]

BATCH = 256  # frames at a time at most; all batches are nearly as large
NARROW = 0.05  # radii around a circle found before, beside the margin
WIDE = 0.15  # ... around a first guess
RADIUS_TOLERANCE = 0.15  # a fitted circle this much larger or smaller than the ball is something else
MEMORY = 25  # sightings of which the median radius is expected
OFTEN = 0.25  # of all patches lack part of the ball: then the clearest sightings decide
SAME_RADIUS = 0.01  # a ball whose size changes by less is looked for with one radius
REFITS = 3
LIMB_FRAMES = 8  # pictures on which a ball's limb is measured


def sight_along(recording: Recording, path: Mapping[int, Blob], radius: float) -> list[Sighting]:
    """See a ball of some radius (px) wherever it is on its path, patches by the number of the frame."""
    seen: list[Sighting] = []
    waiting: list[Cutting] = []
    limb, most = _limb_along(recording, path, radius), -(-len(path) // -(-len(path) // BATCH))
    for view in revisit(recording, path):
        waiting.append(_cut_on_path(view, path, radius))
        if len(waiting) == most:
            seen += _sharp_on_path(together(waiting), path, radius, limb)
            waiting.clear()
    return seen + _sharp_on_path(together(waiting), path, radius, limb) if waiting else seen


def _limb_along(recording: Recording, path: Mapping[int, Blob], radius: float) -> Limb:
    """Measure the limb of a ball on some pictures in which its motion smears it little."""
    some = sharper(path, LIMB_FRAMES)
    cuttings = together([_cut_on_path(view, path, radius) for view in revisit(recording, some)])
    return limb_of(cuttings, _sight_on_path(cuttings, path, radius))


def _sharp_on_path(cuttings: Cuttings, path: Mapping[int, Blob], radius: float, limb: Limb) -> list[Sighting]:
    """See the ball in a batch by its edges, and then by its limb."""
    seen = sharpened(cuttings, _sight_on_path(cuttings, path, radius), limb)
    return with_clear_radius(cuttings, seen, path, radius, limb)


def _cut_on_path(view: View, path: Mapping[int, Blob], radius: float) -> Cutting:
    blob = path[view.index]
    return cut_out(view, (blob.x, blob.y), half_width(radius, blob.blur) + max(room(blob, radius)))


def _sight_on_path(cuttings: Cuttings, path: Mapping[int, Blob], radius: float) -> list[Sighting]:
    """See the ball in a batch; again with the radius of the frames around where that is another."""
    blobs = [path[frame] for frame in cuttings.frames]
    guesses: list[Guess] = [(blob.x, blob.y, radius) for blob in blobs]
    lacking = np.array([lacks(blob, radius) for blob in blobs], dtype=bool)
    unlike = {i: blob for i, blob in enumerate(blobs) if lacking[i] or exceeds(blob, radius)}
    blur = np.where(lacking, 0.0, [blob.blur for blob in blobs])  # what is flat lacks part of the ball
    guesses = started(cuttings, guesses, blur, unlike)
    found = sight_once(cuttings, guesses, blur)
    weigh = clarity if lacking.mean() > OFTEN else alike
    for _ in range(REFITS):
        around = _radius_around(found, radius, weigh)
        if np.abs(around - [guess[2] for guess in guesses]).max(initial=0.0) < SAME_RADIUS * radius:
            break
        guesses = [
            (*guess[:2], r) if seen is None else (seen.circle.x, seen.circle.y, r)
            for guess, seen, r in zip(guesses, found, around.tolist(), strict=True)
        ]
        found = sight_once(cuttings, guesses, blur)
    return [sighting for sighting in found if sighting is not None]


def _radius_around(found: Sequence[Sighting | None], radius: float, weigh: Weigh) -> FloatArray:
    """Weighed median radius in the sharp frames around each one: a ball that comes nearer grows."""
    seen = {
        i: sighting.circle
        for i, sighting in enumerate(found)
        if sighting is not None and sighting.blur < SMEARED * radius
    }
    if not seen:
        return np.full(len(found), radius)
    circles = list(seen.values())
    padded = np.pad(
        [[circle.radius for circle in circles], weigh(circles)], ((0, 0), (MEMORY // 2,) * 2), mode="edge"
    )
    around = weighted_median(*np.lib.stride_tricks.sliding_window_view(padded, MEMORY, axis=1))
    return np.asarray(np.interp(np.arange(len(found)), list(seen), around))


def sight_once(cuttings: Cuttings, guesses: Sequence[Guess], blur: FloatArray) -> list[Sighting | None]:
    """Fit twice, the second time from a good centre and in a narrow ring; None where no rim is seen."""
    places = np.array(guesses, dtype=np.float64).reshape(-1, 3)
    patches, radius = cuttings.patches, places[:, 2]
    coarse = find_rims(patches, places, reach=WIDE * radius + MARGIN_PX + blur / 2, blur=blur)
    first = fit_circles(coarse, places, free_radius=False)
    centres = np.array([places[i] if c is None else (c.x, c.y, c.radius) for i, c in enumerate(first)])
    rims = find_rims(patches, centres, reach=MARGIN_PX + NARROW * radius + blur / 2, blur=blur)
    circles = fit_circles(rims, centres, free_radius=True)
    return [
        Sighting(frame=frame, time=time, rim=rim, circle=circle, blur=own)
        if before and circle and abs(circle.radius - size) <= RADIUS_TOLERANCE * size + own / 4
        else None
        for frame, time, before, rim, circle, size, own in zip(
            cuttings.frames, cuttings.times, first, rims, circles, radius.tolist(), blur.tolist(), strict=True
        )
    ]


def half_width(radius: float, blur: float) -> float:
    """Half the width of what is cut out, so that rays hardly ever leave it."""
    return (1 + WIDE) * radius + 2 * MARGIN_PX + blur + 2
