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


def film(path: Path, discs: Sequence[NDArray[np.float64]]) -> Path:
    """Film discs at these places, an array (frames, 2) in px for each disc, 240 frames a second."""
    write_video(path, _pictures(discs), 240, crf=18, preset="ultrafast")
    return path


def _pictures(discs: Sequence[NDArray[np.float64]]) -> Iterator[NDArray[np.uint8]]:
    rng = np.random.default_rng(2)
    for places in zip(*discs, strict=True):
        fine = np.full((HEIGHT * FINER, WIDTH * FINER, 3), BOARD, np.uint8)
        for place in places:
            column, row = np.rint(16 * (FINER * np.asarray(place) + (FINER - 1) / 2)).astype(int).tolist()
            cv2.circle(fine, (column, row), 16 * FINER * RADIUS_PX, WHITE, -1, cv2.LINE_AA, 4)
        picture = cv2.resize(fine, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
        yield np.clip(picture + rng.normal(0, 2, picture.shape), 0, 255).astype(np.uint8)
