"""Images → one `Track` per ball, in pixels."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from tracking.alike import fit_alike
from tracking.blob import MINIMUM_DIAMETER_PX, Blob
from tracking.candidates import Candidates, find_candidates
from tracking.choice import FEWEST_FRAMES, choose_ball, choose_path
from tracking.circle import Guess, fit_circles
from tracking.errors import RecordingError
from tracking.fall import first_fall
from tracking.notebook import html_table
from tracking.resting import find_resting, sight_resting
from tracking.rivals import is_rival, nearest, refusal, without
from tracking.scatter import path_scatter
from tracking.sight import sight_along
from tracking.sighting import Sighting
from tracking.size import MOST_SIZED, common_radius
from tracking.video import Recording

FloatArray = npt.NDArray[np.float64]

TOUCHING = 0.9  # of the sum of two radii: as near may their centres seem to be
SLACK = 0.4  # radii deeper than where it touches the ball below: a patch need not lie in the middle of a ball
FINEST_PX = 0.003  # no rim is located better than this
SHARED = 0.75  # of what scatters more than rims tell: compression errs as much alike at like height
SHADING_SD = 0.22  # of how far a ball's shading moves its rim


@dataclass(frozen=True, slots=True, kw_only=True)
class Track:
    """Where one ball was seen: (n,) arrays over the frames in which it was; missing frames are missing.

    `frame` numbers frames in the file, `time` is in s, `arc` is the part of the rim that was seen, rad.
    `x`, `y`, their standard deviations and `radius` are in pixels with y down (`unit` "px") as they come
    from the pictures, in metres with y up (`unit` "m") after `scale.to_metres`. So is `shared_sd`: an error
    of the centre that no rim shows, shared by frames in which the ball stands before the same background; and
    `offset_sd`, one that all frames share, which no velocity notices.
    `sizes` (px always) is the radius seen in each frame by itself, NaN where too little of the rim was seen;
    empty where it was not asked for.
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
    offset_sd: float = 0.0
    sizes: FloatArray = field(default_factory=lambda: np.empty(0))

    @property
    def shows_size(self) -> bool:
        """Whether all of its rim was seen in most frames; if not, its radius is a guess by part of it."""
        return not len(self.sizes) or bool(np.isfinite(self.sizes).mean() >= MOST_SIZED)

    def _repr_html_(self) -> str:
        """Show where and when the ball was seen."""
        if not len(self.frame):
            return html_table(f"{self.ball} ball, in no frame", ())
        rows = [
            ("frames", f"{len(self.frame)}, from {self.time.min():.4f} to {self.time.max():.4f} s"),
            ("x", f"{self.x.min():.4g} to {self.x.max():.4g} {self.unit} (± {np.median(self.x_sd):.2g})"),
            ("y", f"{self.y.min():.4g} to {self.y.max():.4g} {self.unit} (± {np.median(self.y_sd):.2g})"),
            ("radius", f"{self.radius:.4g} ± {self.radius_sd:.2g} {self.unit}"),
        ]
        return html_table(f"{self.ball} ball", rows)


def track_balls(
    recording: Recording,
    *,
    radius: float | None = None,
    lower: float | None = None,
    start_px: Sequence[float] | None = None,
) -> list[Track]:
    """Track the ball that falls, and the ball it falls on.

    Parameters
    ----------
    recording : as `open_recording` gives it
    radius : float, optional
        Radius of the falling ball in px; found from the pictures if not given.
    lower : float, optional
        Radius of the ball it falls on as a multiple of its own; without it only one ball is tracked.
    start_px : two floats, optional
        Where the falling ball is first seen (x, y in px), if several fall.

    Returns
    -------
    list of Track
        The upper ball, then the lower one.

    Raises
    ------
    RecordingError
        If no round thing moves through the picture, if two fall and `start_px` is not given, or if none
        starts there.
    """
    for ball, size in (("", radius), ("lower ", radius and lower and radius * lower)):
        _require_that_fits(recording, ball, size)
    candidates, around = find_candidates(recording)
    path, radius = _falling_ball(recording, candidates, around, (radius, start_px))
    if lower is None:
        return [_as_track("upper", sight_along(around, path, radius), recording)]
    below = _find_below(around, path, radius, lower)
    deepest = below[1] - TOUCHING * (radius + below[2])
    lowest_patch = deepest + SLACK * radius
    if any(blob.y > lowest_patch for blob in path.values()):
        above = {k: [blob for blob in blobs if blob.y <= lowest_patch] for k, blobs in candidates.items()}
        path, _ = _falling_ball(recording, above, around, (radius, start_px))
    seen = [sighting for sighting in sight_along(around, path, radius) if sighting.circle.y <= deepest]
    upper = _as_track("upper", seen, recording)
    highest = _touching(upper, upper.radius + below[2], len(recording.times))
    return [upper, _as_track("lower", sight_resting(recording, below, highest), recording)]


def _require_that_fits(recording: Recording, ball: str, radius: float | None) -> None:
    """Refuse a ball larger than the picture, or too small to have an outline."""
    widest = min(recording.size)
    if radius is not None and not MINIMUM_DIAMETER_PX <= 2 * radius <= widest:
        raise RecordingError(
            f"{recording.path.name}: the {ball}ball would be {2 * radius:.3g} px wide, but must be between "
            f"{MINIMUM_DIAMETER_PX} and {widest} px; check its diameter and the scale"
        )


def _require_frames(recording: Recording, ball: str, count: int) -> None:
    """Refuse a ball whose outline is hardly ever seen."""
    if count < FEWEST_FRAMES:
        raise RecordingError(
            f"{recording.path.name}: the {ball} ball's outline was seen in {count} frames only; "
            "film it larger, sharper and against a background of another colour"
        )


def _falling_ball(
    recording: Recording,
    candidates: Candidates,
    around: Recording,
    told: tuple[float | None, Sequence[float] | None],
) -> tuple[dict[int, Blob], float]:
    """Choose the ball that falls, and its radius; of two by where it starts. `told` are radius and place."""
    path, radius = choose_ball(recording, candidates, around, told[0])
    other = choose_path(without(path, candidates, radius), radius)
    paths = [path, other] if other and is_rival(other, path, radius) else [path]
    if told[1] is not None:
        return dict(nearest(paths, told[1], recording.size, recording.path.name)), radius
    if len(paths) > 1:
        raise refusal(paths, recording.path.name)
    return path, radius


def _find_below(recording: Recording, path: Mapping[int, Blob], radius: float, lower: float) -> Guess:
    """Find the ball that rests where the other one first lands."""
    fall = first_fall(path, radius)
    end = path[fall[-1]]
    return find_resting(
        recording, fall[len(fall) // 2], (end.x, end.y + radius * (1 + lower), radius * lower)
    )


def _touching(upper: Track, gap: float, frames: int) -> FloatArray:
    """Give the least y, px, that a ball below can have in each frame: the balls touch there."""
    return np.interp(np.arange(frames), upper.frame, upper.y) + TOUCHING * gap


def _as_track(ball: str, sightings: Sequence[Sighting], recording: Recording) -> Track:
    """Fit all rims again with the one radius of the sharpest pictures."""
    _require_frames(recording, ball, len(sightings))
    radius, radius_sd = common_radius(sightings)
    if 2 * radius < MINIMUM_DIAMETER_PX:
        raise RecordingError(
            f"{recording.path.name}: the {ball} ball is only {2 * radius:.1f} px wide, but must be at least "
            f"{MINIMUM_DIAMETER_PX}; film it from nearer or zoom in"
        )
    guesses = [(s.circle.x, s.circle.y, radius) for s in sightings]
    rims = [s.rim for s in sightings]
    fits = fit_alike(rims, fit_circles(rims, guesses, free_radius=False))
    seen = [(s, circle) for s, circle in zip(sightings, fits, strict=True) if circle is not None]
    _require_frames(recording, ball, len(seen))
    frame = np.array([s.frame for s, _ in seen], dtype=np.int64)
    places = np.array([(c.x, c.y) for _, c in seen]).reshape(-1, 2)
    by_rim = np.maximum([(c.x_sd, c.y_sd) for _, c in seen], FINEST_PX).reshape(-1, 2)
    # compression moves all of a ball, and no rim tells
    unseen = np.sqrt(np.maximum(path_scatter(frame, places) ** 2 - np.median(by_rim**2, axis=0), 0.0))
    shared = SHARED * float(np.hypot(*unseen)) / np.sqrt(2)
    shading = float(np.hypot(*np.median([s.shading for s, _ in seen], axis=0))) / np.sqrt(2)
    hidden = radius_sd * (1 - np.mean([s.sized for s, _ in seen]))  # half a rim moves with the radius
    return Track(
        ball=ball,
        unit="px",
        frame=frame,
        time=np.array([s.time for s, _ in seen]),
        x=places[:, 0],
        y=places[:, 1],
        x_sd=np.hypot(by_rim, unseen)[:, 0],
        y_sd=np.hypot(by_rim, unseen)[:, 1],
        arc=np.array([c.arc for _, c in seen]),
        radius=radius,
        radius_sd=radius_sd,
        shared_sd=shared,
        offset_sd=float(np.linalg.norm((SHADING_SD * shading, shared, hidden))),
        sizes=np.array([s.circle.radius if s.sized else np.nan for s, _ in seen]),
    )
