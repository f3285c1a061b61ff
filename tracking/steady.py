"""A camera that drifts slowly in a hand: its motion found on the background, and undone.

Corners of the background are followed from one reference picture into every other one. The picture is then
moved, turned and stretched a little so that they stay where they were; the ball hardly disturbs the fit.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import cv2
import numpy as np
import numpy.typing as npt

from tracking.errors import RecordingError
from tracking.planes import Image
from tracking.recording import Recording
from tracking.video import revisit

FloatArray = npt.NDArray[np.float64]
Points = npt.NDArray[np.float32]

STILL_PX = 0.7  # less drift than that is not undone: its finding is about as noisy
MOST_CORNERS = 200
FEWEST_CORNERS = 8
FEWEST_TO_TURN = 16  # fewer corners tell a shift, but hardly a turn
SAME_PX = 1.0  # corners agree about the motion to this
THERE_AND_BACK_PX = 0.5
SMOOTH_SECONDS = 0.06  # a hand trembles more slowly than that
LARGEST_SHARE = 0.2  # of the picture: a camera that moves farther is carried about
MOST_LOST = 0.2  # share of the pictures in which the background may be lost
EXPLAINED = 0.95  # of the difference to the reference may be left when a drift is undone
NO_MOTION = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


def steadied(recording: Recording) -> Recording:
    """Find whether the camera drifts, and if it does, give a recording whose frames are moved back.

    Parameters
    ----------
    recording : Recording

    Returns
    -------
    Recording
        The same one if the camera stands still or its background has too few corners to tell.

    Raises
    ------
    RecordingError
        If the camera moves too much.
    """
    looks = [np.ascontiguousarray(look[0]) for look in recording.looks.values()]
    reference = looks[len(looks) // 2]
    corners = _corners(reference)
    if len(corners) < FEWEST_CORNERS:
        return recording
    motions = list(_motions(looks, reference, corners))
    shifts = [_shift(motion, reference) for motion in motions if motion is not None]
    one_scene = len(recording.pictures) == 1  # corners that are lost all the same belong to what moves in it
    if not shifts or (one_scene and len(shifts) < len(looks) / 2):
        return recording
    if float(np.median(shifts)) < STILL_PX:  # a passing hand drags corners along in a few
        return recording
    if not explains(motions, looks, reference):
        return recording
    recording = replace(recording, kept=(), pictures=())  # what hardly moves is kept as if it stood still
    drift = _drift(recording, reference, corners)
    moved = max(_shift(motion, reference) for motion in drift)
    if moved > LARGEST_SHARE * min(reference.shape):
        raise _moves_too_much(recording, f"by {moved:.0f} px")
    note = f"the camera drifts by up to {moved:.1f} px; the background was held still"
    return replace(recording, drift=drift, notes=(*recording.notes, note))


def explains(motions: Sequence[FloatArray | None], looks: Sequence[Image], reference: Image) -> bool:
    """Tell whether pictures that are moved back look more like the reference than they do as they are.

    On a smooth wall a few faint corners that compression moves would pass for a drift of the camera.
    """
    as_they_are, moved_back = 0.0, 0.0
    for motion, look in zip(motions, looks, strict=True):
        if motion is None:
            continue
        ones, size = np.ones_like(look), look.shape[::-1]
        back, there = (
            cv2.warpAffine(image, motion, size, flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)
            for image in (look, ones)
        )
        as_they_are += float(cv2.mean(cv2.absdiff(look, reference), mask=there)[0])
        moved_back += float(cv2.mean(cv2.absdiff(np.asarray(back), reference), mask=there)[0])
    return moved_back < EXPLAINED * as_they_are


def _motions(pictures: Iterable[Image], reference: Image, corners: Points) -> Iterator[FloatArray | None]:
    """Motion of each grey picture against the reference, each looked for near the one before."""
    last = NO_MOTION
    for picture in pictures:
        motion = _motion(reference, corners, picture, last)
        last = last if motion is None else motion
        yield motion


def _drift(recording: Recording, reference: Image, corners: Points) -> FloatArray:
    """Motion of every stored frame against the reference, smoothed, shape (frames, 2, 3)."""
    found = np.full((len(recording.times), 2, 3), np.nan)
    motions = _motions(
        (np.ascontiguousarray(view.planes[0]) for view in revisit(recording)), reference, corners
    )
    for place, motion in zip(np.flatnonzero(recording.genuine), motions, strict=False):
        found[place] = np.nan if motion is None else motion
    known = np.flatnonzero(np.isfinite(found[:, 0, 0]))
    lost = 1 - len(known) / int(recording.genuine.sum())
    if lost > MOST_LOST:
        raise _moves_too_much(recording, f"so fast that the background is lost in {lost:.0%} of the frames")
    index = np.arange(len(found))
    flat = found.reshape(len(found), 6)
    filled = np.column_stack([np.interp(index, known, column[known]) for column in flat.T])
    return _smoothed(filled, recording).reshape(found.shape)


def _smoothed(values: FloatArray, recording: Recording) -> FloatArray:
    """Average over `SMOOTH_SECONDS`."""
    half = int(SMOOTH_SECONDS * recording.capture_fps / 2)
    width = 2 * half + 1
    padded = np.pad(values, ((half, half), (0, 0)), mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, width, axis=0)
    return np.asarray(windows.mean(axis=-1))


def _motion(reference: Image, corners: Points, picture: Image, guess: FloatArray) -> FloatArray | None:
    """Affine map, (2, 3), from the reference to a picture; None where too few corners are found again."""
    there, found, _ = cv2.calcOpticalFlowPyrLK(
        reference, picture, corners, _mapped(guess, corners), flags=cv2.OPTFLOW_USE_INITIAL_FLOW
    )
    back, again, _ = cv2.calcOpticalFlowPyrLK(picture, reference, there, corners.copy())
    good = (found[:, 0] == 1) & (again[:, 0] == 1)
    good &= np.abs(back - corners).max(axis=1) < THERE_AND_BACK_PX
    if good.sum() < FEWEST_CORNERS:
        return None
    matrix, inliers = cv2.estimateAffinePartial2D(
        corners[good], there[good], method=cv2.RANSAC, ransacReprojThreshold=SAME_PX
    )
    if matrix is None or inliers.sum() < FEWEST_CORNERS:
        return None
    if inliers.sum() >= FEWEST_TO_TURN:
        return np.asarray(matrix, dtype=np.float64)
    shift = np.median((there - corners)[good][inliers[:, 0] == 1], axis=0)
    return np.column_stack((np.eye(2), shift))


def _mapped(motion: FloatArray, points: Points) -> Points:
    """Where points, (n, 2), are after a motion."""
    return np.asarray(points @ motion[:, :2].T + motion[:, 2], dtype=np.float32)


def _shift(motion: FloatArray, picture: Image) -> float:
    """How far a motion takes the farthest corner of a picture, px."""
    height, width = picture.shape
    ends = np.array([[0, 0], [width, 0], [0, height], [width, height]], dtype=np.float32)
    return float(np.hypot(*(_mapped(motion, ends) - ends).T).max())


def _corners(picture: Image) -> Points:
    """Places, (n, 2) px, that can be found again in another picture."""
    found = cv2.goodFeaturesToTrack(picture, MOST_CORNERS, 0.01, 8)
    return np.asarray([] if found is None else found, dtype=np.float32).reshape(-1, 2)


def _moves_too_much(recording: Recording, how: str) -> RecordingError:
    return RecordingError(
        f"{recording.path.name}: the camera moves {how}; put it on a tripod or lean it against something"
    )
