"""One image → where something ball-like differs from the background."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from tracking.coarse import COARSE, boxes, brightened, coarsely, gain_between, mark_changes
from tracking.kernel import compiled
from tracking.planes import Image, Planes, Window, above, copied, cut, enlarged
from tracking.recording import Recording, View, held_still

NOISE_FACTOR = 6.0  # a difference this many times the noise is an object
MINIMUM_DIFFERENCE = 10.0  # grey levels
MINIMUM_DIAMETER_PX = 5
CUT_SHARE = 0.9  # a cut that leaves more than this of a patch tells nothing new
CLOSING = np.ones((5, 5), dtype=np.uint8)
COLOUR_WEIGHT = 1.5  # a difference of colour spans fewer levels than one of brightness
COARSE_SHARE = 0.3  # of the threshold that the smallest object leaves in what is looked at first
BESIDE = 3  # coarse pixels around what a first look found


@dataclass(frozen=True, slots=True, kw_only=True)
class Background:
    """The scene without what moves: planes, a look at few of their pixels, and their noise, levels."""

    planes: Planes
    coarse: Planes
    noise: float

    @property
    def threshold(self) -> float:
        """Difference from which something is there, grey levels."""
        return max(MINIMUM_DIFFERENCE, NOISE_FACTOR * self.noise)


@dataclass(frozen=True, slots=True, kw_only=True)
class Blob:
    """A connected patch that differs from the background (pixels, grey levels).

    `x`, `y` is the middle of its bounding box: a ball's shaded side may be as bright as the wall behind it
    and leave a bay, which would draw a centroid away. `fill` is its area, holes filled, over that of the
    ellipse in its bounding box: 1 for a ball, sharp or smeared by motion; `spanned` the same with bays filled
    as well, `hull` being the area of its convex hull.
    """

    x: float
    y: float
    width: float
    height: float
    area: float
    hull: float
    contrast: float
    at_border: bool

    @property
    def blur(self) -> float:
        """How much longer than wide it is, px: a ball that moves is smeared."""
        return abs(self.height - self.width)

    @property
    def fill(self) -> float:
        """Area over the area of the ellipse that fits the bounding box."""
        return self.area / (np.pi / 4 * self.width * self.height)

    @property
    def spanned(self) -> float:
        """Area of the convex hull over the area of that ellipse."""
        return self.hull / (np.pi / 4 * self.width * self.height)


def make_background(recording: Recording) -> Background:
    """Take the median of pictures spread over the recording; what rests all the time stays in it.

    Where nothing ever changed, one picture is as good.
    """
    windows = _ever_changed(recording)
    parts: list[list[Planes]] = [[] for _ in windows]
    looks = _alike(recording)
    for look in looks:
        for window, part in zip(windows, parts, strict=True):
            part.append(cut(look, window))
    whole, deviations = copied(looks[len(looks) // 2]), []
    for window, part in zip(windows, parts, strict=True):
        median = cut(whole, window)
        for plane, samples in zip(median, zip(*part, strict=True), strict=True):
            plane[:] = _median(samples)
        sparse = (slice(None, None, 3), slice(None, None, 3))
        deviations += [float(np.median(difference(one, median)[sparse])) for one in part[::3]]
    noise = 1.4826 * float(np.median(deviations or [0.0]))
    return Background(planes=whole, coarse=coarsely(whole), noise=noise)


def _alike(recording: Recording) -> list[Planes]:
    """Pictures spread over the recording, the camera's drift and flicker undone."""
    looks = dict(recording.looks)
    if recording.drift is not None:
        return [held_still(look, recording.drift[number]) for number, look in looks.items()]
    if len(recording.pictures) != 1:
        return list(looks.values())
    first = recording.pictures[0]
    gains = [
        gain_between(look[0][::COARSE, ::COARSE], first[0][::COARSE, ::COARSE]) for look in looks.values()
    ]
    return [
        (brightened(look[0], 1 / gain), *look[1:]) for look, gain in zip(looks.values(), gains, strict=True)
    ]


def _ever_changed(recording: Recording) -> tuple[Window, ...]:
    """Windows outside of which no frame differs from any other; all of the picture if nobody looked."""
    if len(recording.pictures) != 1:
        return ((slice(0, recording.size[0]), slice(0, recording.size[1])),)
    changed = np.zeros([-(-side // COARSE) for side in recording.size], dtype=np.uint8)
    for kept in recording.kept:
        for rows, columns in kept.windows:
            changed[_coarsely(rows), _coarsely(columns)] = 1
    return boxes(changed, 0, recording.size)


def _coarsely(pixels: slice) -> slice:
    """Turn rows or columns of a picture into those of its coarse look."""
    return slice(pixels.start // COARSE, -(-pixels.stop // COARSE))


def _median(pictures: Sequence[Image]) -> Image:
    """Median over pictures, pixel by pixel (the upper one of an even number): the brightest bubble away.

    OpenCV compares many pixels at once; sorting each pixel by itself takes twenty times as long.
    """
    left: list[cv2.typing.MatLike] = list(pictures)
    for _ in range(len(left) // 2 + 1):
        for k in range(len(left) - 1):
            left[k], left[k + 1] = cv2.min(left[k], left[k + 1]), cv2.max(left[k], left[k + 1])
        median = left.pop()
    return np.asarray(median, dtype=np.uint8)


def difference(seen: Planes, background: Planes, gain: float = 1.0) -> Image:
    """Find the largest difference over the planes, the background made `gain` times as bright."""
    apart = cv2.absdiff(seen[0], brightened(background[0], gain))
    colour = cv2.max(cv2.absdiff(seen[1], background[1]), cv2.absdiff(seen[2], background[2]))
    strong = cv2.convertScaleAbs(colour, alpha=COLOUR_WEIGHT)
    both = cv2.max(apart, enlarged(np.asarray(strong, dtype=np.uint8), apart.shape, cv2.INTER_NEAREST))
    return np.asarray(cv2.blur(both, (3, 3)), dtype=np.uint8)


def find_blobs(view: View, background: Background) -> list[Blob]:
    """List what differs from the background: each patch whole, and cut at half its own contrast.

    The whole patch is right for a ball whose shaded side is as bright as the wall; the cut one parts a ball
    from its fainter shadow or reflection.
    """
    windows, gain = view.changed, 1.0
    if windows is None:
        windows = ((slice(0, view.size[0]), slice(0, view.size[1])),)
        gain = gain_between(coarsely(view.cut(windows[0]))[0], background.coarse[0])
    return [blob for window in windows for blob in _blobs_within(view.cut(window), background, gain, window)]


def _blobs_within(seen: Planes, background: Background, gain: float, window: Window) -> list[Blob]:
    """List what differs from the background in a window, where a look at few pixels shows something."""
    (rows, columns), shape = window, background.planes[0].shape
    coarse = coarsely(seen)
    marks = np.zeros_like(coarse[0])
    few = _coarsely(rows), _coarsely(columns)
    mark_changes(coarse, cut(background.coarse, few), (gain, COARSE_SHARE * background.threshold), marks)
    base = cut(background.planes, window)
    blobs = []
    for place in boxes(marks, BESIDE, seen[0].shape):
        apart = difference(cut(seen, place), cut(base, place), gain)
        corner = columns.start + place[1].start, rows.start + place[0].start
        blobs += _blobs_in(apart, background.threshold, (corner, shape))
    return blobs


def _blobs_in(apart: Image, threshold: float, frame: tuple[tuple[int, int], tuple[int, ...]]) -> list[Blob]:
    """List the patches of a difference, whose window lies at a corner (x, y) in a picture of some shape."""
    corner, shape = frame
    mask = np.asarray(cv2.morphologyEx(above(apart, threshold), cv2.MORPH_CLOSE, CLOSING), dtype=np.uint8)
    blobs = []
    for place, area, hull in _outlines(mask):
        if area < MINIMUM_DIAMETER_PX**2 / 2:
            continue
        levels = apart[place] * mask[place]
        contrast = _high_level(levels)
        blobs.append(_blob(place, (area, hull), contrast, frame))
        core = above(levels, 0.5 * contrast)
        if cv2.countNonZero(core) < CUT_SHARE * area:
            within = corner[0] + place[1].start, corner[1] + place[0].start
            blobs += [_blob(piece, areas, contrast, (within, shape)) for piece, *areas in _outlines(core)]
    return blobs


def _outlines(mask: Image) -> list[tuple[Window, float, float]]:
    """Bounding box, area with holes filled and with bays filled, of each patch that could be a ball."""
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    found = []
    for outline in outlines:
        left, top, width, height = cv2.boundingRect(outline)
        if min(width, height) >= MINIMUM_DIAMETER_PX:
            area = cv2.contourArea(outline) + len(outline) / 2 + 1  # Pick's theorem
            hull = cv2.convexHull(outline)
            spanned = cv2.contourArea(hull) + cv2.arcLength(hull, closed=True) / 2 + 1
            found.append(((slice(top, top + height), slice(left, left + width)), area, spanned))
    return found


@compiled
def _high_level(levels: Image) -> float:
    """Level that a tenth of the pixels above nothing exceed."""
    pixels = np.zeros(256, dtype=np.int64)
    for row in range(len(levels)):
        for column in range(levels.shape[1]):
            pixels[levels[row, column]] += 1
    rank, level = int(0.9 * (pixels[1:].sum() - 1)), 1
    while level < 255 and rank >= pixels[level]:
        rank -= pixels[level]
        level += 1
    return float(level)


def _blob(
    place: Window, areas: Sequence[float], contrast: float, frame: tuple[tuple[int, int], tuple[int, ...]]
) -> Blob:
    """Describe a patch; its window lies at a corner (x, y) in a picture of some shape."""
    corner, shape = frame
    rows, columns = place
    left, top = corner[0] + columns.start, corner[1] + rows.start
    width, height = columns.stop - columns.start, rows.stop - rows.start
    return Blob(
        x=left + (width - 1) / 2,
        y=top + (height - 1) / 2,
        width=float(width),
        height=float(height),
        area=areas[0],
        hull=areas[1],
        contrast=contrast,
        at_border=left <= 0 or top <= 0 or left + width >= shape[1] or top + height >= shape[0],
    )
