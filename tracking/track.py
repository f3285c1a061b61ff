"""Images → one `Track` per ball, in pixels."""

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
from scipy.signal import find_peaks

from tracking.circle import MARGIN_PX, Circle, Image, Rim, find_rim, fit_circle, locate_circle
from tracking.detect import MINIMUM_DIAMETER_PX, Blob, find_blobs, make_background
from tracking.errors import RecordingError
from tracking.path import MISSING, best_path, guess_radius
from tracking.size import measure_radius, sharpest
from tracking.video import Frame, Recording, read_frames

FloatArray = npt.NDArray[np.float64]

FEWEST_FRAMES = 8
KEPT_BYTES = 100_000_000
SHARP = 0.12  # motion blur below this share of the radius
FINEST_PX = 0.02  # no rim is located better than this in a compressed picture
SHARED_PX = 0.1  # compression and texture behind the ball shift it by this, alike in frames of like height
RADIUS_TOLERANCE = 0.15  # a fitted circle this much larger or smaller than the ball is something else


@dataclass(frozen=True, slots=True, kw_only=True)
class Track:
    """Where one ball was seen: (n,) arrays over the frames in which it was; missing frames are missing.

    `frame` numbers frames in the file, `time` is in s, `arc` is the part of the rim that was seen, rad.
    `x`, `y`, their standard deviations and `radius` are in pixels with y down (`unit` "px") as they come
    from the pictures, in metres with y up (`unit` "m") after `scale.to_metres`. So is `shared_sd`: an error
    of the centre that no rim shows, shared by frames in which the ball stands before the same background.
    `sizes` (px always) is the radius seen in each frame by itself; empty where it was not asked for.
    """

    ball: str
    unit: str
    frame: npt.NDArray[np.int64]
    time: FloatArray
    x: FloatArray
    y: FloatArray
    x_sd: FloatArray
    y_sd: FloatArray
    arc: FloatArray
    radius: float
    radius_sd: float
    shared_sd: float = 0.0
    sizes: FloatArray = field(default_factory=lambda: np.empty(0))


@dataclass(slots=True)
class _Sighting:
    """One frame's rim of one ball, and the circle first fitted to it."""

    frame: int
    time: float
    rim: Rim
    circle: Circle
    blur: float


def track_balls(
    recording: Recording, *, radius: float | None = None, lower: float | None = None
) -> list[Track]:
    """Track the ball that falls, and the ball it falls on.

    Parameters
    ----------
    recording : as `open_recording` gives it
    radius : float, optional
        Radius of the falling ball in px; found from the pictures if not given.
    lower : float, optional
        Radius of the ball it falls on as a multiple of its own; without it only one ball is tracked.

    Returns
    -------
    list of Track
        The upper ball, then the lower one.

    Raises
    ------
    RecordingError
        If no round thing moves through the picture.
    """
    for ball, size in (("", radius), ("lower ", radius and lower and radius * lower)):
        _require_that_fits(recording, ball, size)
    background = make_background(recording.samples)
    frames = _replay(recording)
    numbers, candidates = [], []
    for frame in frames(None):
        numbers.append(frame.index)
        candidates.append(find_blobs(frame.image, background))
    path, rough = _find_path(recording, numbers, candidates, radius)
    if radius is None:
        radius = measure_radius(frames(sharpest(path)), path, rough)
        path, _ = _find_path(recording, numbers, candidates, radius)
    upper: list[_Sighting] = []
    rest: list[_Sighting] = []
    below = None if lower is None else _place_below(list(path.values()), radius, lower)
    for frame in frames(path if below is None else None):
        blob = path.get(frame.index)
        if blob is not None:
            blur = abs(blob.height - blob.width)
            guess = (blob.x, blob.y, radius)
            _look(upper, frame.image, guess, (frame.index, frame.time, blur))
        if below is not None:
            below = below if rest else _find_resting(frame.image, below)
            _look(rest, frame.image, below, (frame.index, frame.time, 0.0))
            below = _next_guess(rest, below, frame.index)
    tracks = [_as_track("upper", upper, recording)]
    return [*tracks, _as_track("lower", rest, recording)] if lower is not None else tracks


def _require_that_fits(recording: Recording, ball: str, radius: float | None) -> None:
    """Refuse a ball larger than the picture, or too small to have an outline."""
    widest = min(recording.samples[0].shape[:2])
    if radius is not None and not MINIMUM_DIAMETER_PX <= 2 * radius <= widest:
        raise RecordingError(
            f"{recording.path.name}: the {ball}ball would be {2 * radius:.3g} px wide, but must be between "
            f"{MINIMUM_DIAMETER_PX} and {widest} px; check its diameter and the scale"
        )


def _replay(recording: Recording) -> Callable[[Collection[int] | None], Iterable[Frame]]:
    """Give all frames, or some, as often as asked: kept in memory if few, decoded again if many."""
    if recording.bytes > KEPT_BYTES:
        return lambda wanted: read_frames(recording, wanted)
    kept = list(read_frames(recording))
    return lambda wanted: kept if wanted is None else [frame for frame in kept if frame.index in wanted]


def _find_path(
    recording: Recording, numbers: Sequence[int], candidates: Sequence[Sequence[Blob]], radius: float | None
) -> tuple[dict[int, Blob], float]:
    """Choose the ball among the candidates of every frame, and its radius if it was not given."""
    radius = guess_radius(candidates) if radius is None else radius
    if radius is not None:
        chosen = best_path(candidates, radius)
        path = {
            number: blobs[index]
            for number, blobs, index in zip(numbers, candidates, chosen, strict=True)
            if index != MISSING
        }
        if len(path) >= FEWEST_FRAMES:
            return path, radius
    raise RecordingError(
        f"{recording.path.name}: no ball found that moves through the picture; film a plain ball against a "
        "background of another colour, whole and in focus, with more frames a second if it is very fast, and "
        "check --ball-diameter and the scale"
    )


def _place_below(path: Sequence[Blob], radius: float, lower: float) -> tuple[float, float, float]:
    """Guess the resting ball: under the place where the falling ball first turns."""
    seen = [blob for blob in path if blob.height < 3 * radius]
    depth = np.array([blob.y for blob in seen])
    turns, _ = find_peaks(depth, prominence=radius / 2)
    turn = seen[turns[0] if turns.size else int(np.argmax(depth))]
    return turn.x, turn.y + radius * (1 + lower), radius * lower


def _find_resting(image: Image, guess: tuple[float, float, float]) -> tuple[float, float, float]:
    """Find the resting ball up to a radius above or below the guess: where the best rim is."""
    x, y, radius = guess
    reach = 0.15 * radius + MARGIN_PX
    best, least = guess, np.inf
    for shift in np.linspace(-1, 1, 9) * radius:
        coarse = locate_circle(image, (x, y + shift, radius), reach=reach)
        circle = coarse and locate_circle(image, (coarse.x, coarse.y, radius), reach=MARGIN_PX)
        if circle and circle.y_sd / circle.inliers < least:
            best, least = (circle.x, circle.y, radius), circle.y_sd / circle.inliers
    return best


def _look(
    sightings: list[_Sighting],
    image: Image,
    guess: tuple[float, float, float],
    when: tuple[int, float, float],
) -> None:
    """Fit twice, the second time from a good centre and in a narrow ring, and keep what was seen."""
    index, time, blur = when
    radius = guess[2]
    coarse = find_rim(image, guess, reach=0.15 * radius + MARGIN_PX + blur / 2, blur=blur)
    first = None if coarse is None else fit_circle(coarse, guess, free_radius=False)
    if first is None:
        return
    rim = find_rim(image, (first.x, first.y, radius), reach=MARGIN_PX + 0.05 * radius + blur / 2, blur=blur)
    circle = None if rim is None else fit_circle(rim, (first.x, first.y, radius), free_radius=True)
    if rim is None or circle is None or abs(circle.radius - radius) > RADIUS_TOLERANCE * radius + blur / 4:
        return
    sightings.append(_Sighting(index, time, rim, circle, blur))


def _next_guess(
    sightings: list[_Sighting], last: tuple[float, float, float], index: int
) -> tuple[float, float, float]:
    """Expect the ball where it was seen last, with its median radius."""
    if not sightings or sightings[-1].frame != index:
        return last
    circle = sightings[-1].circle
    return circle.x, circle.y, float(np.median([s.circle.radius for s in sightings[-25:]]))


def _as_track(ball: str, sightings: list[_Sighting], recording: Recording) -> Track:
    """Fit all rims again with the one radius of the sharpest pictures."""
    if len(sightings) < FEWEST_FRAMES:
        raise RecordingError(
            f"{recording.path.name}: the {ball} ball's outline was seen in {len(sightings)} frames only; "
            "film it larger, sharper and against a background of another colour"
        )
    radius, radius_sd = _common_radius(sightings)
    if 2 * radius < MINIMUM_DIAMETER_PX:
        raise RecordingError(
            f"{recording.path.name}: the {ball} ball is only {2 * radius:.1f} px wide, but must be at least "
            f"{MINIMUM_DIAMETER_PX}; film it from nearer or zoom in"
        )
    fits = [(s, fit_circle(s.rim, (s.circle.x, s.circle.y, radius), free_radius=False)) for s in sightings]
    seen = [(s, circle) for s, circle in fits if circle is not None]
    return Track(
        ball=ball,
        unit="px",
        frame=np.array([s.frame for s, _ in seen], dtype=np.int64),
        time=np.array([s.time for s, _ in seen]),
        x=np.array([c.x for _, c in seen]),
        y=np.array([c.y for _, c in seen]),
        x_sd=np.array([max(c.x_sd, FINEST_PX) for _, c in seen]),
        y_sd=np.array([max(c.y_sd, FINEST_PX) for _, c in seen]),
        arc=np.array([c.arc for _, c in seen]),
        radius=radius,
        radius_sd=radius_sd,
        shared_sd=SHARED_PX,
        sizes=np.array([s.circle.radius for s, _ in seen]),
    )


def _common_radius(sightings: list[_Sighting]) -> tuple[float, float]:
    """Take the median radius over the sharpest pictures and its standard error, px."""
    blur = np.array([s.blur / s.circle.radius for s in sightings])
    sharp = blur <= max(SHARP, float(np.quantile(blur, 0.25)))
    radii = np.array([s.circle.radius for s in sightings])[sharp]
    spread = 1.4826 * float(np.median(np.abs(radii - np.median(radii))))
    return float(np.median(radii)), max(spread / np.sqrt(len(radii)), 1e-3)
