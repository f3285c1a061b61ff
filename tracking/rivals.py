"""Two balls that fall in one picture: told from a ball and its shadow or mirror image, and one chosen."""

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from tracking.blob import Blob
from tracking.errors import RecordingError
from tracking.fall import LONG_FALL, first_turn

FloatArray = npt.NDArray[np.float64]
Path = Mapping[int, Blob]
"""The patch that is a ball, by the number of the frame."""

APART = 2.5  # radii: what is nearer belongs to the ball itself
FEWEST_FRAMES = 7  # of a fall
SMOOTH = 0.15  # radii off a parabola: hands and feet fall less smoothly
ALIKE = 0.6  # of the other's acceleration and contrast: a shadow is fainter, a mirror image rises
CLICK_SHARE = 0.05  # of the picture's longer side: as near as a person points


def without(path: Path, candidates: Mapping[int, Sequence[Blob]], radius: float) -> dict[int, list[Blob]]:
    """Leave out the patches of all frames that belong to the ball on a path."""
    numbers = np.array(list(path))
    x, y = (np.array([getattr(blob, axis) for blob in path.values()]) for axis in ("x", "y"))
    left = {}
    for number, blobs in candidates.items():
        place = np.interp(number, numbers, x), np.interp(number, numbers, y)
        left[number] = [
            blob
            for blob in blobs
            if max(
                abs(blob.x - place[0]) - blob.width / 2,
                abs(blob.y - place[1]) - blob.height / 2,
            )
            > (APART - 1) * radius
        ]
    return left


def is_rival(other: Path, path: Path, radius: float) -> bool:
    """Tell whether a second path is that of a ball that falls like the first."""
    ours, theirs = acceleration(path, radius), acceleration(other, radius)
    if ours is None or theirs is None or not ALIKE < theirs / ours < 1 / ALIKE:
        return False
    contrast, its_contrast = (
        float(np.median([blob.contrast for blob in one.values()])) for one in (path, other)
    )
    return its_contrast > ALIKE * contrast


def acceleration(path: Path, radius: float) -> float | None:
    """Downward acceleration of a ball before it first turns, px a frame²; None if it does not fall freely."""
    number, depth = np.array(list(path), dtype=np.float64), np.array([blob.y for blob in path.values()])
    turn = first_turn(depth, radius)
    moving = np.flatnonzero(depth[turn] - depth[: turn + 1] < LONG_FALL * radius)
    fall = slice(max(0, int(moving[0]) - FEWEST_FRAMES), turn)
    if fall.stop - fall.start < FEWEST_FRAMES or depth[turn - 1] - depth[fall.start] < LONG_FALL * radius:
        return None
    parabola, (residual, *_), *_ = np.polyfit(number[fall], depth[fall], 2, full=True)
    rough = np.sqrt(float(residual) / (fall.stop - fall.start))
    return 2 * float(parabola[0]) if rough < SMOOTH * radius and parabola[0] > 0 else None


def nearest(paths: Sequence[Path], start_px: Sequence[float], size: tuple[int, int], name: str) -> Path:
    """Choose the path that begins nearest to where a person says.

    Raises
    ------
    RecordingError
        If none begins there.
    """
    starts = _starts(paths)
    away = [float(np.hypot(blob.x - start_px[0], blob.y - start_px[1])) for blob in starts]
    best = int(np.argmin(away))
    if away[best] > max(CLICK_SHARE * max(size), 1.5 * starts[best].width):
        at = ", ".join(map(_place, starts))
        raise RecordingError(
            f"{name}: no ball starts near start_px ({start_px[0]:g}, {start_px[1]:g}); those that move are "
            f"first seen at {at} px"
        )
    return paths[best]


def refusal(paths: Sequence[Path], name: str) -> RecordingError:
    """Say that two balls fall, and how to choose."""
    at = " and ".join(map(_place, _starts(paths)))
    return RecordingError(
        f"{name}: two balls fall, first seen at {at} px; say with --start-px (start_px in experiment.toml) "
        "which one to measure, or film one ball alone"
    )


def _starts(paths: Sequence[Path]) -> list[Blob]:
    """Give where each ball is first seen."""
    return [next(iter(path.values())) for path in paths]


def _place(blob: Blob) -> str:
    return f"({blob.x:.0f}, {blob.y:.0f})"
