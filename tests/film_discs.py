"""Films of white discs on a brown board, for tests."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from tracking.encode import write_video

WIDTH, HEIGHT, RADIUS_PX = 320, 160, 9
BOARD, WHITE = (40, 60, 90), (220, 225, 230)
FINER = 4
SPEED, SLOWING, RESTITUTION = 3.0, 0.02, 0.9  # px/frame, px/frame²
IMPACT_FRAME = 30


def film(path: Path, discs: Sequence[NDArray[np.float64]]) -> Path:
    """Film discs at these places, an array (frames, 2) in px for each disc, 240 frames a second."""
    write_video(path, _pictures(discs), 240, crf=18, preset="ultrafast")
    return path


def film_impact(path: Path) -> Path:
    """Film a disc that meets an equal one at rest, head-on, in IMPACT_FRAME."""
    since = np.arange(-IMPACT_FRAME, 30)
    after = np.maximum(since, 0)
    striker = np.where(since < 0, _way(SPEED, since), _way(SPEED * (1 - RESTITUTION) / 2, after))
    struck = 2 * RADIUS_PX + _way(SPEED * (1 + RESTITUTION) / 2, after)
    return film(path, [np.column_stack((130 + x, 70 + 0.2 * x)) for x in (striker, struck)])


def _way(speed: float, since: NDArray[np.int64]) -> NDArray[np.float64]:
    """Way of a disc that slows to rest by dry friction."""
    sliding = np.minimum(since, speed / SLOWING)
    return np.asarray(speed * sliding - SLOWING / 2 * sliding**2)


def _pictures(discs: Sequence[NDArray[np.float64]]) -> Iterator[NDArray[np.uint8]]:
    rng = np.random.default_rng(2)
    for places in zip(*discs, strict=True):
        fine = np.full((HEIGHT * FINER, WIDTH * FINER, 3), BOARD, np.uint8)
        for place in places:
            column, row = np.rint(16 * (FINER * np.asarray(place) + (FINER - 1) / 2)).astype(int).tolist()
            cv2.circle(fine, (column, row), 16 * FINER * RADIUS_PX, WHITE, -1, cv2.LINE_AA, 4)
        picture = cv2.resize(fine, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
        yield np.clip(picture + rng.normal(0, 2, picture.shape), 0, 255).astype(np.uint8)
