"""A few frames around each impact, cut out and put side by side."""

from collections.abc import Sequence
from math import ceil

import cv2
import numpy as np
import numpy.typing as npt

from tracking.overlay import Overlay
from tracking.overlay_marks import Brush
from tracking.planes import Image
from tracking.video import Recording

FloatArray = npt.NDArray[np.float64]
Window = tuple[float, float, float]
"""Centre (x, y) and half the width of a square, px of the recording."""

MOST_IMPACTS = 3  # later ones have no place on the sheet
PANELS = 9  # at most, divided among the impacts
STEP = 0.008  # s between the frames shown, at least one frame
PANEL_PX = 320
AROUND = 1.0  # radii shown around what moves
LEAST_HALF = 4.0  # radii: half the width of a panel at least


def choose_frames(recording: Recording, overlay: Overlay) -> dict[int, Window]:
    """Choose the frames of the sheet and what part of each is shown.

    Returns
    -------
    dict of int to Window
        By number of the frame in the file: around the first impacts, or spread over the sightings if there
        is none; empty if nothing was seen.
    """
    genuine = np.flatnonzero(recording.genuine)
    times = recording.times[genuine]
    impacts = overlay.impact_times[:MOST_IMPACTS]
    if not impacts:
        seen = np.unique(np.concatenate([outline.frame for outline in overlay.outlines]))
        spread = seen[np.linspace(0, len(seen) - 1, min(PANELS, len(seen))).astype(int)]
        return dict.fromkeys(map(int, spread), _window(overlay, spread, np.nan)) if len(seen) else {}
    count = PANELS // len(impacts)
    chosen: dict[int, Window] = {}
    for impact in impacts:
        steps = np.arange(count) - (count - 1) / 2
        wanted = impact + steps * max(STEP, 1 / recording.capture_fps)
        frames = np.unique(genuine[np.abs(times[:, None] - wanted).argmin(axis=0)])
        window = _window(overlay, frames, impact)
        chosen |= {int(frame): window for frame in frames if int(frame) not in chosen}
    return chosen


def _window(overlay: Overlay, frames: npt.NDArray[np.int64], impact: float) -> Window:
    """Choose the square that holds the impact and all balls of these frames, with some room around."""
    within = [
        (outline.centre[now], outline.radius[now])
        for outline in overlay.outlines
        if (now := np.isin(outline.frame, frames)).any()
    ]
    if not within:
        return 0.0, 0.0, np.inf
    centre, radius = np.vstack([c for c, _ in within]), np.concatenate([r for _, r in within])
    reach = (1 + AROUND) * float(radius.max())
    moments = [moment for scene in overlay.scenes for moment in scene.moments if moment.time == impact]
    places = np.vstack([centre, *(moment.place for moment in moments)])
    low, high = places.min(axis=0) - reach, places.max(axis=0) + reach
    half = max(float((high - low).max()) / 2, LEAST_HALF * float(radius.max()))
    middle = (low + high) / 2
    return float(middle[0]), float(middle[1]), half


def cut_out(image: Image, window: Window) -> tuple[Image, Brush]:
    """Cut a window out of a picture, moved to lie within it, at the size of a panel, and a brush for it."""
    x, y, half = window
    rows, columns = image.shape[:2]
    side = int(min(2 * half, rows, columns))
    left, top = int(np.clip(x - side / 2, 0, columns - side)), int(np.clip(y - side / 2, 0, rows - side))
    cut = image[top : top + side, left : left + side]
    method = cv2.INTER_AREA if side > PANEL_PX else cv2.INTER_CUBIC
    square = np.asarray(cv2.resize(cut, (PANEL_PX, PANEL_PX), interpolation=method), dtype=np.uint8)
    return square, Brush(zoom=PANEL_PX / side, corner=(left, top))


def arrange(panels: Sequence[Image]) -> Image | None:
    """Put panels side by side in rows, with a gap between; None if there is none."""
    if not panels:
        return None
    columns = next((count for count in (3, 4) if len(panels) % count == 0), ceil(np.sqrt(len(panels))))
    framed = [cv2.copyMakeBorder(panel, 2, 2, 2, 2, cv2.BORDER_CONSTANT, value=0) for panel in panels]
    framed += [np.zeros_like(framed[0])] * (-len(framed) % columns)
    rows = [np.hstack(framed[start : start + columns]) for start in range(0, len(framed), columns)]
    return np.asarray(np.vstack(rows), dtype=np.uint8)
