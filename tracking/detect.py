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


@dataclass(frozen=True, slots=True, kw_only=True)
class Background:
    """The scene without what moves: (height, width, 3) levels and the noise around them in levels."""

    image: Image
    noise: float

    @property
    def threshold(self) -> float:
        """Difference from which something is there, grey levels."""
        return max(MINIMUM_DIFFERENCE, NOISE_FACTOR * self.noise)


@dataclass(frozen=True, slots=True, kw_only=True)
class Blob:
    """A connected patch that differs from the background (pixels, grey levels).

    `fill` is its area over that of the ellipse in its bounding box: 1 for a ball, sharp or smeared by motion.
    """

    x: float
    y: float
    width: float
    height: float
    area: float
    contrast: float

    @property
    def fill(self) -> float:
        """Area over the area of the ellipse that fits the bounding box."""
        return self.area / (np.pi / 4 * self.width * self.height)


def make_background(samples: list[Image]) -> Background:
    """Take the median of pictures spread over the recording; what rests all the time stays in it."""
    image = np.median(np.stack(samples), axis=0).astype(np.uint8)
    deviations = [np.median(np.abs(difference(sample, image))) for sample in samples[:: max(1, len(samples) // 6)]]
    return Background(image=image, noise=1.4826 * float(np.median(deviations)))


def difference(image: Image, background: Image) -> npt.NDArray[np.uint8]:
    """Find the largest difference over the colour channels, after matching brightness (flicker)."""
    sparse = (slice(None, None, 8), slice(None, None, 8))
    ratio = (image[sparse].astype(np.float32) + 1) / (background[sparse].astype(np.float32) + 1)
    gain = float(np.clip(np.median(ratio), 0.5, 2.0))
    matched = cv2.convertScaleAbs(background, alpha=gain)
    apart = cv2.absdiff(image, matched)
    blue, green, red = cv2.split(apart)
    return np.asarray(cv2.blur(cv2.max(cv2.max(blue, green), red), (3, 3)))


def find_blobs(image: Image, background: Background) -> list[Blob]:
    """List what differs from the background, each patch cut at half its own contrast.

    Cutting each patch at half its own contrast parts a ball from its fainter shadow or reflection.
    """
    apart = difference(image, background.image)
    mask = (apart > background.threshold).astype(np.uint8)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    blobs = []
    for label in range(1, count):
        left, top, width, height, area = (int(v) for v in stats[label])
        if min(width, height) < MINIMUM_DIAMETER_PX or area < MINIMUM_DIAMETER_PX**2 / 2:
            continue
        window = (slice(top, top + height), slice(left, left + width))
        levels = np.where(labels[window] == label, apart[window], 0)
        blobs += _cores(levels, left, top)
    return blobs


def _cores(levels: npt.NDArray[np.uint8], left: int, top: int) -> list[Blob]:
    """Cut one patch at half its contrast and describe each piece."""
    contrast = float(np.percentile(levels[levels > 0], 90))
    core = (levels > 0.5 * contrast).astype(np.uint8)
    count, _, stats, centres = cv2.connectedComponentsWithStats(core, connectivity=4)
    return [
        Blob(
            x=left + float(centres[label][0]),
            y=top + float(centres[label][1]),
            width=float(stats[label][2]),
            height=float(stats[label][3]),
            area=float(stats[label][4]),
            contrast=contrast,
        )
        for label in range(1, count)
        if min(stats[label][2], stats[label][3]) >= MINIMUM_DIAMETER_PX
    ]
