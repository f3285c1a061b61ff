"""Compiled loops do what a few lines of numpy or OpenCV say, and a kept picture is the picture."""

import os
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from clips import Clip

from tracking.blob import MINIMUM_DIAMETER_PX, Whole, blobs_in
from tracking.blob_kernel import measured
from tracking.boxes import boxes
from tracking.coarse import (
    CHANGED_RANK,
    COARSE,
    brightened,
    coarsely,
    gain_between,
    largest_change,
    mark_changes,
)
from tracking.differing import closed, difference
from tracking.keeper import Keeper
from tracking.median import median_of
from tracking.patch import patch_of
from tracking.planes import Image, Planes, colours, copied, cut
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
    mark_changes(moved, still, 5.0, marks, 2, (0, 0))
    assert np.argwhere(marks).tolist() == [[3, 4]]
    for left in (1, 0, 0):
        mark_changes(still, still, 5.0, marks, 2, (0, 0))
        assert marks.max() == left


def test_a_part_of_a_picture_is_marked_where_it_differs_from_the_same_part_of_a_reference() -> None:
    whole = noise(40, 40), noise(20, 20), noise(20, 20)
    part = whole[0][8:28, 12:40].copy(), whole[1][4:14, 6:20].copy(), whole[2][4:14, 6:20]
    part[0][3, 4] += 50
    part[1][5, 7] += 50
    marks = np.zeros(part[0].shape, dtype=np.uint8)
    mark_changes(part, whole, 5.0, marks, 1, (8, 12))
    assert np.argwhere(marks).tolist() == [[3, 4], [10, 14], [10, 15], [11, 14], [11, 15]]


@pytest.mark.parametrize("gain", [0.6, 0.9, 1.0, 1.3])
def test_flicker_is_told_to_a_part_in_a_hundred(gain: float) -> None:
    dark = noise(160, 120)
    assert gain_between(np.rint(gain * dark).astype(np.uint8), dark) == pytest.approx(gain, rel=0.01)


@pytest.mark.parametrize("gain", [0.6, 1.3])
def test_another_exposure_scales_brightness_and_what_colour_differs_from_grey(gain: float) -> None:
    planes = noise(40, 30), noise(20, 15), noise(20, 15)
    lit = brightened(planes, gain)
    for levels, other, none in zip(planes, lit, (0, 128, 128), strict=True):
        expected = np.clip((levels - float(none)) * gain + none, 0, 255)
        np.testing.assert_allclose(other, expected, atol=0.5)


def test_planes_whose_exposure_hardly_differs_are_left_alone() -> None:
    planes = noise(40, 30), noise(20, 15), noise(20, 15)
    assert brightened(planes, 1.002) is planes


def test_boxes_hold_all_that_is_marked_with_room_about_it_and_none_overlap() -> None:
    marks = (np.random.default_rng(1).random((90, 70)) < 0.002).astype(np.uint8)
    found = boxes(marks, 3, (360, 280))
    covered = np.zeros((360, 280), dtype=int)
    for window in found:
        covered[window] += 1
    assert covered.max() == 1
    for row, column in np.argwhere(marks):
        near = (
            slice(max(COARSE * (row - 3), 0), COARSE * (row + 4)),
            slice(max(COARSE * (column - 3), 0), COARSE * (column + 4)),
        )
        assert covered[near].all()


def test_more_places_than_any_scene_has_become_fewer_boxes() -> None:
    marks = np.zeros((200, 200), dtype=np.uint8)
    marks[::2, ::2] = 1
    found = boxes(marks, 0, (800, 800))
    assert 0 < len(found) <= 1000
    covered = np.zeros((800, 800), dtype=bool)
    for window in found:
        covered[window] = True
    assert covered[:: 2 * COARSE, :: 2 * COARSE].all()


@pytest.mark.parametrize("count", [1, 2, 5, 10, 11])
def test_the_median_picture_is_the_median_of_every_pixel(count: int) -> None:
    pictures = noise(count, 30, 20)
    np.testing.assert_array_equal(median_of(pictures), np.sort(pictures, axis=0)[(count - 1) // 2])


@pytest.mark.parametrize("fewer", [1, 2])
def test_a_difference_is_the_largest_of_the_planes_averaged(fewer: int) -> None:
    one, other = smooth(40, 62, fewer), smooth(40, 62, fewer)
    one[1][10:14, 12:18] += 30
    one[0][20:26, 30:50] -= 30
    apart = cv2.absdiff(one[0], other[0])
    colour = cv2.max(cv2.absdiff(one[1], other[1]), cv2.absdiff(one[2], other[2]))
    strong = cv2.resize(cv2.convertScaleAbs(colour, alpha=1.5), (62, 40), interpolation=cv2.INTER_NEAREST)
    expected = cv2.blur(cv2.max(apart, strong), (3, 3))
    found = difference(one, other, (0, 40, 0, 62), (0, 0))
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("fewer", [1, 2])
def test_a_part_differs_from_the_background_where_it_was_taken(fewer: int) -> None:
    whole, background = smooth(60, 80, fewer), smooth(60, 80, fewer)
    whole[1][12:20, 12:20] += 40
    part = copied(cut(whole, (slice(16, 60), slice(24, 80))))
    expected = difference(whole, background, (0, 60, 0, 80), (0, 0))[22:50, 36:73]
    found = difference(part, background, (6, 34, 12, 49), (16, 24))
    np.testing.assert_array_equal(found[1:-1, 1:-1], expected[1:-1, 1:-1])


def test_gaps_are_closed_as_opencv_closes_them() -> None:
    apart = noise(50, 70)
    expected = cv2.morphologyEx((apart > 160).astype(np.uint8), cv2.MORPH_CLOSE, np.ones((5, 5), np.uint8))
    np.testing.assert_array_equal(closed(apart, 160.0), expected)


def test_the_smallest_ball_is_a_patch() -> None:
    planes = noise(40, 40) // 4 + 60, np.full((20, 20), 128, np.uint8), np.full((20, 20), 128, np.uint8)
    apart = np.zeros((40, 40), dtype=np.uint8)
    cv2.circle(apart, (20, 20), MINIMUM_DIAMETER_PX // 2, 50, cv2.FILLED)
    (ball,) = blobs_in(apart, 10.0, Whole(apart.shape, planes, planes, (0, 0)), (0, 0))
    assert (ball.x, ball.y, ball.width, ball.height) == (20, 20, MINIMUM_DIAMETER_PX, MINIMUM_DIAMETER_PX)


@pytest.mark.parametrize("seed", range(20))
def test_an_outline_has_the_area_of_its_pixels_and_the_hull_of_its_points(seed: int) -> None:
    rng = np.random.default_rng(seed)
    marks = np.zeros((80, 90), dtype=np.uint8)
    for _ in range(3):
        x, y, wide, high = (int(value) for value in rng.integers((10, 10, 3, 3), (80, 70, 25, 25)))
        cv2.ellipse(marks, (x, y), (wide, high), float(rng.uniform(0, 180)), 0, 360, 1, -1)
    outlines, _ = cv2.findContours(marks, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    for outline in outlines:
        box, area, spanned = measured(np.asarray(outline, dtype=np.int32))
        filled = cv2.drawContours(np.zeros_like(marks), [outline], -1, 1, cv2.FILLED)
        hull = cv2.convexHull(outline)
        assert box == cv2.boundingRect(outline)
        assert area == filled.sum()
        assert spanned == pytest.approx(cv2.contourArea(hull) + cv2.arcLength(hull, closed=True) / 2 + 1)


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
