"""One image → where something ball-like differs from the background."""

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

Image = npt.NDArray[np.uint8]
FloatArray = npt.NDArray[np.float64]

NOISE_FACTOR = 6.0  # a difference this many times the noise is an object
MINIMUM_DIFFERENCE = 8.0  # grey levels
MINIMUM_DIAMETER_PX = 5
CUT_SHARE = 0.9  # a cut that leaves more than this of a patch tells nothing new
CLOSING = np.ones((5, 5), dtype=np.uint8)
COARSE = 4  # first look: pixels to a side of a block
COARSE_SHARE = 0.3  # of the threshold that the smallest object leaves in one of its blocks
BESIDE_PX = 12  # around what a first look found
STRIP_ROWS = 64  # of the background at a time


@dataclass(frozen=True, slots=True, kw_only=True)
class Background:
    """The scene without what moves: (height, width, 3) levels, the same coarsely, the noise in levels."""

    image: Image
    coarse: Image
    noise: float

    @property
    def threshold(self) -> float:
        """Difference from which something is there, grey levels."""
        return max(MINIMUM_DIFFERENCE, NOISE_FACTOR * self.noise)


@dataclass(frozen=True, slots=True, kw_only=True)
class Blob:
    """A connected patch that differs from the background (pixels, grey levels).

    `x`, `y` is the middle of its bounding box: a ball's shaded side may be as bright as the wall behind it
    and leave a hole, which would draw a centroid away. `fill` is its area over that of the ellipse in its
    bounding box: 1 for a ball, sharp or smeared by motion.
    """

    x: float
    y: float
    width: float
    height: float
    area: float
    contrast: float
    at_border: bool

    @property
    def fill(self) -> float:
        """Area over the area of the ellipse that fits the bounding box."""
        return self.area / (np.pi / 4 * self.width * self.height)


def make_background(samples: list[Image]) -> Background:
    """Take the median of pictures spread over the recording; what rests all the time stays in it."""
    image = np.empty_like(samples[0])
    for top in range(0, len(image), STRIP_ROWS):  # all at once would take as much memory as the samples do
        strip = slice(top, top + STRIP_ROWS)
        image[strip] = np.median(np.stack([sample[strip] for sample in samples]), axis=0)
    deviations = [
        np.median(difference(sample, image, _gain(sample, image)))
        for sample in samples[:: max(1, len(samples) // 6)]
    ]
    return Background(image=image, coarse=_coarse(image), noise=1.4826 * float(np.median(deviations)))


def difference(image: Image, background: Image, gain: float) -> npt.NDArray[np.uint8]:
    """Find the largest difference over the colour channels, the background made `gain` times as bright."""
    apart = cv2.absdiff(image, cv2.convertScaleAbs(background, alpha=gain))
    blue, green, red = cv2.split(apart)
    return np.asarray(cv2.blur(cv2.max(cv2.max(blue, green), red), (3, 3)))


def _gain(image: Image, background: Image) -> float:
    """How much brighter a picture is than the background: flicker."""
    sparse = (slice(None, None, 8), slice(None, None, 8))
    ratio = (image[sparse].astype(np.float32) + 1) / (background[sparse].astype(np.float32) + 1)
    return float(np.clip(np.median(ratio), 0.5, 2.0))


def _coarse(image: Image) -> Image:
    """Average a picture over blocks."""
    size = (max(1, image.shape[1] // COARSE), max(1, image.shape[0] // COARSE))
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)


def _changed(image: Image, background: Background, gain: float) -> tuple[slice, slice] | None:
    """Rows and columns outside of which nothing differs from the background, by a first coarse look."""
    apart = cv2.absdiff(_coarse(image), cv2.convertScaleAbs(background.coarse, alpha=gain)).max(axis=2)
    left, top, width, height = cv2.boundingRect(
        (apart > COARSE_SHARE * background.threshold).astype(np.uint8)
    )
    if width == 0:
        return None
    ends = [(top, height, image.shape[0]), (left, width, image.shape[1])]
    rows, columns = (
        slice(max(0, COARSE * start - BESIDE_PX), min(end, COARSE * (start + size + 1) + BESIDE_PX))
        for start, size, end in ends
    )
    return rows, columns


def find_blobs(image: Image, background: Background) -> list[Blob]:
    """List what differs from the background: each patch whole, and cut at half its own contrast.

    The whole patch is right for a ball whose shaded side is as bright as the wall; the cut one parts a ball
    from its fainter shadow or reflection.
    """
    gain = _gain(image, background.image)
    window = _changed(image, background, gain)
    if window is None:
        return []
    apart = difference(image[window], background.image[window], gain)
    mask = cv2.morphologyEx((apart > background.threshold).astype(np.uint8), cv2.MORPH_CLOSE, CLOSING)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    shift = np.array([window[1].start, window[0].start, 0, 0, 0])
    blobs = []
    smallest = stats[:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]].min(axis=1)
    large = (smallest >= MINIMUM_DIAMETER_PX) & (stats[:, cv2.CC_STAT_AREA] >= MINIMUM_DIAMETER_PX**2 / 2)
    for label in np.flatnonzero(large[1:count]) + 1:
        left, top, width, height, area = (int(v) for v in stats[label])
        place = (slice(top, top + height), slice(left, left + width))
        levels = np.where(labels[place] == label, apart[place], 0)
        contrast = float(np.percentile(levels[levels > 0], 90))
        whole = stats[label] + shift
        blobs.append(_blob(whole, contrast, image.shape))
        core = (levels > 0.5 * contrast).astype(np.uint8)
        if core.sum() < CUT_SHARE * area:
            blobs += _cores(core, (int(whole[0]), int(whole[1])), contrast, image.shape)
    return blobs


def _cores(
    core: npt.NDArray[np.uint8], corner: tuple[int, int], contrast: float, shape: tuple[int, ...]
) -> list[Blob]:
    """Describe the pieces of a patch that was cut."""
    count, _, stats, _ = cv2.connectedComponentsWithStats(core, connectivity=4)
    shift = np.array([*corner, 0, 0, 0])
    return [
        _blob(stats[label] + shift, contrast, shape)
        for label in range(1, count)
        if min(stats[label][2], stats[label][3]) >= MINIMUM_DIAMETER_PX
    ]


def _blob(stats: npt.NDArray[np.int64], contrast: float, shape: tuple[int, ...]) -> Blob:
    """Describe a connected component by OpenCV's statistics of it."""
    left, top, width, height, area = (float(v) for v in stats)
    return Blob(
        x=left + (width - 1) / 2,
        y=top + (height - 1) / 2,
        width=width,
        height=height,
        area=area,
        contrast=contrast,
        at_border=left <= 0 or top <= 0 or left + width >= shape[1] or top + height >= shape[0],
    )
