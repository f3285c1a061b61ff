"""The tip of the cue on its way to the ball: the front end of what differs from the free cloth, along a line.

The frames just before the strike show the same cue further and further ahead. Against the frame in which it
is furthest back each shows the stretch that it has advanced: its middle is the line, its front end the tip.
"""

from dataclasses import dataclass, replace

import cv2
import numpy as np
import numpy.typing as npt

from tracking.planes import Image
from tracking.track import Track
from tracking.video import Frame, Recording, revisit

FloatArray = npt.NDArray[np.float64]

SECONDS = 0.4  # before the strike
MOST_FRAMES = 60
AROUND = 10.0  # radii around the ball that are looked at
CLEAR = 1.08  # radii from the ball's centre where the cloth begins
LEAST_LEVEL = 15.0  # grey levels that a cue differs from the cloth
NEAR = 4.0  # radii from the ball that the cue comes at least
LEAST_ELONGATION = 3.0  # length over width of the stretch that the cue advances
PASSES = 1.5  # radii at which its line passes the ball's centre at most
STEP_PX = 0.25
FEWEST_FRAMES = 3
TIP_SD_PX = 0.3
MOST_STREAK = 0.5  # of the stretch's contrast: its front


@dataclass(frozen=True, slots=True, kw_only=True)
class _Line:
    """The cue's line in px: a point, its unit direction towards the ball, half the width of the stretch."""

    point: FloatArray
    direction: FloatArray
    half_width: float


def track_tip(recording: Recording, ball: Track, started: int) -> tuple[Track | None, str]:
    """Track the cue's tip before the frame in which the ball has started.

    Parameters
    ----------
    recording : as `open_recording` gives it
    ball : Track
        The cue ball, in px.
    started : int
        Number of the frame in which it has left its place.

    Returns
    -------
    tuple of Track or None and str
        The tip in px, radius 0; or None and the reason.
    """
    resting = ball.frame < started
    centre = np.array([np.median(ball.x[resting]), np.median(ball.y[resting])])
    frames, corner = _before(recording, centre, ball.radius, started)
    if len(frames) < FEWEST_FRAMES:
        return None, f"only {len(frames)} frames before the strike; start the recording earlier"
    local = centre - corner
    back = _furthest_back(frames, local, ball.radius)
    line = _find_line(frames, back, local, ball.radius)
    if line is None:
        return None, "no cue is seen that comes straight to the ball"
    ways = [_front(frame, frames[back], line, local, ball.radius) for frame in frames[back + 1 :]]
    kept = _advancing(ways)
    if len(kept) < FEWEST_FRAMES - 1:
        return None, f"the cue's tip is seen in {len(kept)} frames only; record more frames a second"
    places = np.array([line.point + ways[i] * line.direction + corner for i in kept])
    chosen = [frames[back + 1 + i] for i in kept]
    return _as_track(chosen, places), ""


def _before(
    recording: Recording, centre: FloatArray, radius: float, started: int
) -> tuple[list[Frame], FloatArray]:
    """Cut the surroundings of the ball out of the last frames before it starts."""
    earliest = recording.times[started] - SECONDS
    left, top = (max(0, int(v - AROUND * radius)) for v in centre)
    right, bottom = (int(v + AROUND * radius) + 1 for v in centre)
    frames = []
    for frame in (view.frame() for view in revisit(recording)):
        if frame.index >= started:
            break
        if frame.time >= earliest:
            frames.append(replace(frame, image=frame.image[top:bottom, left:right].copy()))
            frames = frames[-MOST_FRAMES:]
    return frames, np.array([left, top], dtype=float)


def _apart(image: Image, other: Image, centre: FloatArray, radius: float) -> FloatArray:
    """Difference of two pictures, grey levels, nothing at the ball itself."""
    apart = cv2.blur(cv2.absdiff(image, other), (3, 3)).max(axis=2).astype(np.float64)
    rows, columns = np.indices(apart.shape)
    apart[np.hypot(columns - centre[0], rows - centre[1]) < CLEAR * radius] = 0
    return np.asarray(apart)


def _furthest_back(frames: list[Frame], centre: FloatArray, radius: float) -> int:
    """Find the frame that differs most from the last one: the cue is drawn back."""
    last = frames[-1].image
    areas = [
        np.count_nonzero(_apart(frame.image, last, centre, radius) > 2 * LEAST_LEVEL) for frame in frames[:-1]
    ]
    return int(np.argmax(areas))


def _find_line(frames: list[Frame], back: int, centre: FloatArray, radius: float) -> _Line | None:
    """Find the stretch that the cue has advanced, and its line, if it is straight and leads to the ball."""
    apart = _apart(frames[-1].image, frames[back].image, centre, radius)
    level = max(LEAST_LEVEL, 0.4 * float(np.percentile(apart, 99.5)))
    count, labels = cv2.connectedComponents((apart > level).astype(np.uint8))
    lines = [_line(np.argwhere(labels == label)[:, ::-1], centre, radius) for label in range(1, count)]
    found = [line for line in lines if line is not None]
    return max(found, key=lambda line: line[0])[1] if found else None


def _line(pixels: npt.NDArray[np.int64], centre: FloatArray, radius: float) -> tuple[int, _Line] | None:
    """Fit a line to a patch; None if it is no cue. The first of the pair is the patch's size."""
    distance = np.hypot(*(pixels - centre).T)
    if len(pixels) < 8 or distance.min() > NEAR * radius:
        return None
    middle = pixels.mean(axis=0)
    spread, axes = np.linalg.eigh(np.cov(pixels.T))
    direction = axes[:, 1] * np.sign(axes[:, 1] @ (centre - middle))
    offset = (centre - middle) @ np.array([-direction[1], direction[0]])
    width = np.sqrt(max(spread[0], 0.1))
    if np.sqrt(spread[1]) < LEAST_ELONGATION * width or abs(offset) > PASSES * radius:
        return None
    return len(pixels), _Line(point=middle, direction=direction, half_width=1.2 * float(width))


def _front(frame: Frame, back: Frame, line: _Line, centre: FloatArray, radius: float) -> float:
    """Where along the line the front of the stretch is, px from its point towards the ball; NaN if unseen."""
    to_ball = float((centre - line.point) @ line.direction)
    along = np.arange(to_ball - AROUND * radius, to_ball - 0.8 * radius, STEP_PX)
    across = np.linspace(-line.half_width, line.half_width, 7)
    normal = np.array([-line.direction[1], line.direction[0]])
    x, y = (
        (line.point[i] + along * line.direction[i] + across[:, None] * normal[i]).astype(np.float32)
        for i in (0, 1)
    )
    inside = (x >= 0) & (y >= 0) & (x < frame.image.shape[1] - 1) & (y < frame.image.shape[0] - 1)
    inside &= np.hypot(x - centre[0], y - centre[1]) > CLEAR * radius
    levels = [cv2.remap(f.image, x, y, cv2.INTER_LINEAR).astype(np.float64) for f in (frame, back)]
    apart = np.linalg.norm(levels[0] - levels[1], axis=2) * inside
    profile = apart.sum(axis=0) / np.maximum(inside.sum(axis=0), 1)
    plateau = float(np.percentile(profile, 90))
    high = np.flatnonzero(profile > MOST_STREAK * plateau)
    if plateau < LEAST_LEVEL or not high.size or high[-1] + 1 >= len(profile):
        return np.nan
    index = high[-1]
    rest = (profile[index] - MOST_STREAK * plateau) / max(profile[index] - profile[index + 1], 1e-9)
    return float(along[index] + min(rest, 1.0) * STEP_PX)


def _advancing(ways: list[float]) -> list[int]:
    """Numbers of the last frames in which the tip advances without a pause."""
    kept: list[int] = []
    for index in reversed(range(len(ways))):
        if np.isnan(ways[index]):
            if kept:
                break
            continue
        if kept and ways[index] >= ways[kept[-1]]:
            break
        kept.append(index)
    return kept[::-1]


def _as_track(frames: list[Frame], places: FloatArray) -> Track:
    """Give the tip's places as a track."""
    count = len(frames)
    return Track(
        ball="tip",
        unit="px",
        frame=np.array([frame.index for frame in frames], dtype=np.int64),
        time=np.array([frame.time for frame in frames]),
        x=places[:, 0],
        y=places[:, 1],
        x_sd=np.full(count, TIP_SD_PX),
        y_sd=np.full(count, TIP_SD_PX),
        arc=np.zeros(count),
        radius=0.0,
        radius_sd=0.0,
    )
