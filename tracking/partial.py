"""A ball part of whose rim is as bright as the wall: several starts, and the radius of clear frames.

The dark side of a white ball before a grey wall has no edge, and its patch ends where its shade begins. From
the middle of such a patch rays meet that first. So the rim is sought from places around as well, and the one
that is known best believed; and since too little of it is seen to tell how large the ball is, the radius
comes from the frames in which it is clear.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from tracking.blob import Blob
from tracking.circle import MARGIN_PX, Circle, Guess, find_rims, fit_circles, places_of
from tracking.limb import Limb
from tracking.median import weighted_median
from tracking.sharp import sharpened
from tracking.sighting import Cuttings, Sighting

FloatArray = npt.NDArray[np.float64]

LACKING, LACKING_PX = 0.06, 2.0  # of its width, or pixels: a patch narrower by more lacks part of the ball
EXCESS, EXCESS_PX = 0.12, 4.0  # ... and one wider by more is that of a shadow or a hand as well
MOST_PATCHES = 0.5  # of a path must be unlike the ball, or it is seen as it is
SMEARED = 0.25  # radii of motion blur, from which a ball's own size is not believed
ASIDE = 0.18  # radii, at least, from the middle of a patch to the other starts,
HIDDEN = 0.85  # ... or this share of how far off it can be if the patch is part of the ball
WAYS = np.vstack((np.zeros((1, 2)), [(np.cos(a), np.sin(a)) for a in np.arange(8) * np.pi / 4]))
REACHES = (0.15, 0.1, 0.1)  # radii, look after look, beside the margin,
LAST_REACH = 0.05  # ... and at last, when the radius is free
OTHER_BALL = 0.1  # a circle larger or smaller by more is not the ball
CLEARLY = -4.0  # power of how vague an outline is: few clear ones outweigh many that are not
LOST = 3.0  # times as vague as usual
HUBER = 1.345
ROUNDS = 10
TINY = 1e-9


def lacks(blob: Blob, radius: float) -> bool:
    """Whether a patch is too small to be all of a ball of some radius, px; one smeared upright never is."""
    width = 2 * radius
    least = width - max(LACKING * width, LACKING_PX)
    return blob.height - blob.width < SMEARED * radius and min(blob.width, blob.height) < least


def exceeds(blob: Blob, radius: float) -> bool:
    """Whether a patch is wider than a ball of some radius, px: a shadow or a hand is part of it."""
    width = 2 * radius
    return blob.width > width + max(EXCESS * width, EXCESS_PX)


def is_unlike(blobs: Collection[Blob], radius: float) -> bool:
    """Whether patches are mostly too small or too large to be a ball of some radius, px."""
    return float(np.mean([lacks(blob, radius) or exceeds(blob, radius) for blob in blobs])) > MOST_PATCHES


def clarity(circles: Sequence[Circle]) -> FloatArray:
    """Weigh circles so that those whose outlines are clear decide."""
    vague = [max(circle.vagueness / circle.radius, TINY) for circle in circles]
    return np.array(vague) ** CLEARLY


def alike(circles: Sequence[Circle]) -> FloatArray:
    """Weigh all circles alike."""
    return np.ones(len(circles))


def room(blob: Blob, radius: float) -> tuple[float, float]:
    """How far from the middle of a patch that of its ball is looked for, px, across and up or down."""
    across, along = (max(ASIDE * radius, HIDDEN * (radius - side / 2)) for side in (blob.width, blob.height))
    return across, along


def started(
    cuttings: Cuttings, guesses: Sequence[Guess], blur: FloatArray, unlike: Mapping[int, Blob]
) -> list[Guess]:
    """Start anew where a patch is unlike the ball, from the clearest circle found from places around it."""
    anew, places = list(guesses), np.array(guesses).reshape(-1, 3)
    many = np.repeat(np.fromiter(unlike, dtype=np.int64), len(WAYS))
    radius, smear, patches = places[many, 2], blur[many], cuttings.patches.take(many.tolist())
    at = places[many]
    rooms = np.array([room(blob, guesses[i][2]) for i, blob in unlike.items()]).reshape(-1, 1, 2)
    at[:, :2] += (rooms * WAYS).reshape(-1, 2)

    def look(share: float, free_radius: bool) -> list[Circle | None]:
        rims = find_rims(patches, at, reach=share * radius + MARGIN_PX + smear / 2, blur=smear)
        return fit_circles(rims, at, free_radius=free_radius)

    for share in REACHES:
        for place, circle in zip(at, look(share, False), strict=True):
            if circle is not None:
                place[:2] = circle.x, circle.y
    found = look(LAST_REACH, True)
    for k, i in enumerate(unlike):
        size = guesses[i][2]
        own = [
            circle
            for circle in found[k * len(WAYS) : (k + 1) * len(WAYS)]
            if circle is not None and abs(circle.radius / size - 1) < OTHER_BALL
        ]
        best = min(own, key=lambda circle: circle.vagueness, default=None)
        anew[i] = guesses[i] if best is None else (best.x, best.y, size)
    return anew


def with_clear_radius(
    cuttings: Cuttings, seen: Sequence[Sighting], path: Mapping[int, Blob], usual: float, limb: Limb
) -> list[Sighting]:
    """See a ball again in the frames whose patches lack part of it, as large as the clear ones around tell.

    Where its patch is unlike it and its outline far from as clear as usual, it is left out. `usual` is its
    radius, px: one that goes away becomes smaller than the clear ones tell.
    """
    if not seen:
        return []
    radii = _trend(seen).tolist()
    lacking = [
        (sighting, (sighting.circle.x, sighting.circle.y, radius))
        for sighting, radius in zip(seen, radii, strict=True)
        if lacks(path[sighting.frame], min(radius, usual))
    ]
    known = {sighting.frame: sighting for sighting in _as_large(cuttings, lacking, limb)}
    unlike = {s.frame for s, radius in zip(seen, radii, strict=True) if exceeds(path[s.frame], radius)}
    unlike |= {sighting.frame for sighting, _ in lacking}
    all_of_it = [known.get(s.frame, replace(s, sized=s.sized and s.frame not in unlike)) for s in seen]
    most = LOST * float(np.median([sighting.circle.vagueness for sighting in all_of_it]))
    return [s for s in all_of_it if s.frame not in unlike or s.circle.vagueness < most]


def _as_large(cuttings: Cuttings, told: Sequence[tuple[Sighting, Guess]], limb: Limb) -> list[Sighting]:
    """See a ball again with the radii that are told; how far its limb moved it at first stays known."""
    circles = fit_circles([s.rim for s, _ in told], [guess for _, guess in told], free_radius=False)
    first = [
        replace(sighting, circle=circle, sized=False)
        for (sighting, _), circle in zip(told, circles, strict=True)
        if circle is not None
    ]
    again = sharpened(cuttings, first, limb, free_radius=False)
    return [replace(s, shading=before.shading) for s, before in zip(again, first, strict=True)]


def _trend(seen: Sequence[Sighting]) -> FloatArray:
    """Fit a straight line to the radii over time: least squares by clarity, with Huber's weights."""
    circles = [sighting.circle for sighting in seen]
    radii, time = places_of(circles)[:, 2], np.array([sighting.time for sighting in seen])
    design = np.column_stack((np.ones(len(seen)), (time - time.mean()) / max(np.ptp(time), TINY)))
    clear, near = clarity(circles), np.ones(len(seen))
    line = radii
    for _ in range(ROUNDS):
        root = np.sqrt(clear * near)
        line = design @ np.linalg.lstsq(design * root[:, None], radii * root, rcond=None)[0]
        apart = np.abs(radii - line)
        scale = 1.4826 * float(weighted_median(apart, clear)) + TINY
        near = 1 / np.maximum(apart / (HUBER * scale), 1.0)
    return np.asarray(line)
