"""Compiled loops do what a few lines of numpy or OpenCV say, and a kept picture is the picture."""

import os
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from clips import Clip

from tracking.coarse import CHANGED_RANK, COARSE, coarsely, largest_change, mark_changes
from tracking.kept import Keeper
from tracking.patch import patch_of
from tracking.planes import Image, Planes, colours, cut
from tracking.recording import View


def noise(*shape: int, seed: int = 0) -> Image:
    return np.random.default_rng(seed).integers(60, 180, shape, dtype=np.uint8)


def smooth(height: int, width: int, fewer: int = 2) -> Planes:
    """A picture whose colour has `fewer` times fewer rows and columns than its brightness."""
    sizes = [(height, width), *[(-(-height // fewer), -(-width // fewer))] * 2]
    planes = (cv2.GaussianBlur(noise(*size, seed=seed), (0, 0), 5) for seed, size in enumerate(sizes))
    brightness, blue, red = (np.asarray(plane, dtype=np.uint8) for plane in planes)
    return brightness, blue, red


def test_few_pixels_are_averaged_over_their_neighbours() -> None:
    planes = noise(101, 83), noise(51, 42), noise(51, 42)
    few = np.ascontiguousarray(planes[0][::COARSE, ::COARSE])
    averaged = cv2.blur(few, (3, 3), borderType=cv2.BORDER_REPLICATE)
    np.testing.assert_array_equal(coarsely(planes)[0], averaged)


def test_largest_change_is_one_that_several_places_exceed() -> None:
    before, after = noise(40, 30), noise(40, 30, seed=1)
    changes = np.sort(np.abs(before.astype(int) - after), axis=None)
    assert largest_change(before, after) == changes[-CHANGED_RANK]
    assert largest_change(before, before) == 0


def test_a_mark_lasts_and_then_fades() -> None:
    still = noise(20, 20), noise(10, 10), noise(10, 10)
    moved = still[0].copy(), still[1], still[2]
    moved[0][3, 4] += 50
    marks = np.zeros((20, 20), dtype=np.uint8)
    mark_changes(moved, still, (1.0, 5.0), marks, lasting=2)
    assert np.argwhere(marks).tolist() == [[3, 4]]
    for left in (1, 0, 0):
        mark_changes(still, still, (1.0, 5.0), marks, lasting=2)
        assert marks.max() == left


@pytest.mark.parametrize("fewer", [1, 2])
@pytest.mark.parametrize("size", [(40, 60), (41, 59)])
def test_a_patch_has_the_colours_of_the_picture(size: tuple[int, int], fewer: int) -> None:
    planes = smooth(*size, fewer)
    apart = patch_of(planes, 0, 0).image.astype(int) - colours(planes)
    assert np.abs(apart).max() <= 2


def test_what_is_cut_from_a_kept_picture_is_what_was_there() -> None:
    first = smooth(160, 240)
    second = first[0].copy(), first[1].copy(), first[2]
    second[0][60:80, 100:130] += 40
    second[1][30:40, 50:65] += 30
    keeper = Keeper()
    for planes in (first, second):
        keeper.look(planes)
    view = View(index=1, time=0.0, picture=keeper.pictures[0], kept=keeper.frames[1])
    for window in (
        (slice(60, 80), slice(100, 130)),
        (slice(0, 160), slice(80, 240)),
        (slice(0, 8), slice(0, 8)),
    ):
        for own, there in zip(view.cut(window), cut(second, window), strict=True):
            np.testing.assert_array_equal(own, there)


@pytest.mark.slow
def test_what_is_compiled_first_measures_the_same_as_what_is_loaded_later(
    plate_clip: Clip, tmp_path: Path
) -> None:
    code = (
        "import sys; from tracking.track import track_balls; from tracking.video import open_recording; "
        "ball = track_balls(open_recording(sys.argv[1]))[0]; print(ball.x.tolist(), ball.y_sd.tolist())"
    )
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    first, later = (
        subprocess.run(
            [sys.executable, "-c", code, str(plate_clip.path)],
            cwd=Path(__file__).parents[1],
            env=environment,
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for _ in range(2)
    )
    assert first == later != ""
