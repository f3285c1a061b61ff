"""What the path of a ball tells: where it goes on, falls and turns."""

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
from scipy.ndimage import median_filter
from scipy.signal import find_peaks

from tracking.blob import Blob

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

MOVING = 0.03  # radii a frame, up or down
FAR, LEAP_COST = 1.0, 5.0  # radii a frame, beyond twice the steps around it: a leap; and its cost in frames
LONG_FALL = 3.0  # radii
USUAL, STEP = 0.8, 0.4  # quantile of the steps of what moves that should be so many radii long
LEAST_STEP_PX = 0.25
TREMBLING = 0.15  # radii a frame: what rises less may fall all the same
FALLING = 0.5  # radii a frame, beyond what gravity adds: what goes further down at once does not fall


def goes_on(path: Mapping[int, Blob], radius: float) -> float:
    """Count the frames in which a path goes on up or down as it did, less some for each leap.

    What rests does not go on, and a leap leads to another thing: a ball below, or a mirror image.
    """
    step = _steps(path) / radius
    before, now, after = step[:-2], step[1:-1], step[2:]
    going = np.count_nonzero((before * now > 0) & (np.minimum(np.abs(before), np.abs(now)) > MOVING))
    leaps = np.count_nonzero(np.abs(now) > 2 * np.maximum(np.abs(before), np.abs(after)) + FAR)
    return max(going - LEAP_COST * leaps, 0.0)


def first_fall(path: Mapping[int, Blob], radius: float) -> list[int]:
    """List the frames of the first long fall; those until the ball turns if it is not seen to fall far.

    A fall goes on over some radii, nearly as fast as any, but without a leap: that leads to another thing.
    Of a fast camera's frames some are left out: patches tremble, and a step must be more than that.
    """
    frames, depth = list(path), _depths(path)
    every = _spacing(_steps(path), radius)
    seen = median_filter(depth, 3, mode="nearest")  # one patch may be misread
    step = every * np.diff(seen[::every]) / np.diff(frames[::every])
    falling = _falling(step, radius)
    fastest = step[falling].max(initial=0.0)
    for fall in np.split(falling, np.flatnonzero(np.diff(falling) > 1) + 1):
        if fall.size and 2 * step[fall].max() > fastest:  # a hand lowers a ball more slowly
            first, last = every * fall[0], every * (fall[-1] + 1)
            end = first + int(depth[first : last + 1].argmax())
            if depth[end] - depth[first] > LONG_FALL * radius:
                return frames[first : end + 1]
    return frames[: first_turn(depth, radius) + 1]


def _spacing(step: FloatArray, radius: float) -> int:
    """How many frames apart a ball has gone on by more than its patches tremble."""
    moving = np.abs(step[np.abs(step) > LEAST_STEP_PX])
    return max(1, round(STEP * radius / np.quantile(moving, USUAL))) if moving.size else 1


def _falling(step: FloatArray, radius: float) -> IntArray:
    """List the steps of free fall: each longer than those before it by no more than gravity makes it."""
    before = np.concatenate(([0.0, 0.0], step))
    usual = np.maximum(np.maximum(before[:-2], before[1:-1]), 0.0)
    grown = 2 * float(np.median(np.abs(np.diff(step)))) if len(step) > 1 else 0.0
    return np.flatnonzero((step > -TREMBLING * radius) & (step <= usual + grown + FALLING * radius))


def first_turn(depth: FloatArray, radius: float) -> int:
    """Find where a ball first rebounds: the place, among depths in px, of the first or of the lowest one."""
    turns, _ = find_peaks(depth, prominence=radius / 2)
    return int(turns[0]) if turns.size else int(np.argmax(depth))


def _depths(path: Mapping[int, Blob]) -> FloatArray:
    """How deep a path is in its frames, px."""
    return np.array([blob.y for blob in path.values()])


def _steps(path: Mapping[int, Blob]) -> FloatArray:
    """How much deeper a path becomes, px a frame."""
    return np.asarray(np.diff(_depths(path)) / np.diff(list(path)))
