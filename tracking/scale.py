"""Pixels, y down → metres, y up.

Every way to give a scale ends as one 3 x 3 matrix from picture to plane, so that a plane seen at an angle
(four corners) needs no path of its own.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
import numpy.typing as npt

from tracking.track import Track

FloatArray = npt.NDArray[np.float64]
Point = Sequence[float]

CLICK_PX = 1.0  # how well a person marks a point
GIVEN_SD = 0.003  # of a scale told as a number: two marks half a picture apart tell no better
PLANE_SD = 0.005  # a ruler 1 cm behind the ball, seen from 2 m
OUTLINE_PX = 0.3  # a rim found by its steepest gradient lies this far inside or outside the ball's
DIAMETER_SD = 0.005  # of a ball's nominal diameter: the rules of table tennis allow ± 1 %


@dataclass(frozen=True, slots=True, kw_only=True)
class Scale:
    """How pixels become metres.

    Attributes
    ----------
    matrix : (3, 3) array
        Homography from (x, y, 1) in pixels, y down, to metres, y up.
    relative_sd : float
        Standard uncertainty of lengths, as a share.
    source : str
        Where it comes from, for the person who reads the result.
    """

    matrix: FloatArray
    relative_sd: float
    source: str


def scale_from_metres_per_pixel(metres_per_pixel: float, *, relative_sd: float = GIVEN_SD) -> Scale:
    """Take the scale as given.

    Raises
    ------
    ValueError
        If it is not positive.

    Examples
    --------
    >>> scale_from_metres_per_pixel(0.0008).source
    'given: 0.8 mm/px'
    """
    _require_positive("metres_per_pixel", metres_per_pixel)
    return Scale(
        matrix=np.diag([metres_per_pixel, -metres_per_pixel, 1.0]),
        relative_sd=relative_sd,
        source=f"given: {metres_per_pixel * 1e3:.4g} mm/px",
    )


def scale_from_points(first: Point, second: Point, distance: float) -> Scale:
    """Take the scale from two points in the picture (px) that are `distance` (m) apart, e.g. on a ruler.

    Raises
    ------
    ValueError
        If the distance is not positive, or the points lie too close together to tell.
    """
    _require_positive("distance", distance)
    length = float(np.hypot(second[0] - first[0], second[1] - first[1]))
    if not length >= 10 * CLICK_PX:
        raise ValueError(f"points_px must lie at least {10 * CLICK_PX:g} px apart, got {length:.3g} px")
    scale = scale_from_metres_per_pixel(distance / length, relative_sd=_marked(length))
    return replace(scale, source=f"{distance:g} m between two points {length:.1f} px apart")


def scale_from_ball(track: Track, diameter: float) -> Scale:
    """Take the scale from the tracked outline (px) of a ball of known diameter (m).

    Raises
    ------
    ValueError
        If the diameter is not positive.
    """
    _require_positive("ball_diameter", diameter)
    outline = np.hypot(track.radius_sd, OUTLINE_PX) / track.radius
    scale = scale_from_metres_per_pixel(
        diameter / (2 * track.radius), relative_sd=float(np.hypot(outline, DIAMETER_SD))
    )
    name = track.ball.removesuffix(" ball")
    return replace(scale, source=f"{name} ball, {diameter * 1e3:g} mm wide, {2 * track.radius:.1f} px")


def scale_from_corners(corners: Sequence[Point], width: float, height: float) -> Scale:
    """Take the scale from the four corners (px) of a rectangle of `width` x `height` m.

    The rectangle lies in the plane of motion. The corners go round: lower left, lower right, upper right,
    upper left; the first is the origin.

    Raises
    ------
    ValueError
        If width or height is not positive, or the corners do not go round like that.
    """
    _require_positive("width", width)
    _require_positive("height", height)
    picture = np.array(corners, dtype=np.float32)
    if picture.shape != (4, 2):
        raise ValueError(f"corners_px must be four points [x, y], got an array of shape {picture.shape}")
    if not cv2.isContourConvex(picture.reshape(-1, 1, 2)):
        raise ValueError(
            "corners_px must go round a convex quadrilateral; two of them are swapped or in line"
        )
    if cv2.contourArea(picture, oriented=True) > 0:
        raise ValueError("corners_px must go round as lower left, lower right, upper right, upper left")
    plane = np.array([[0, 0], [width, 0], [width, height], [0, height]], dtype=np.float32)
    side = float(np.linalg.norm(np.diff(picture, axis=0), axis=1).min())
    return Scale(
        matrix=np.asarray(cv2.getPerspectiveTransform(picture, plane), dtype=np.float64),
        relative_sd=_marked(side),
        source=f"four corners of {width:g} m x {height:g} m",
    )


def rescaled(scale: Scale, factor: float) -> Scale:
    """Give all lengths `factor` times as long."""
    return replace(scale, matrix=np.diag([factor, factor, 1.0]) @ scale.matrix)


def to_metres(track: Track, scale: Scale) -> Track:
    """Give a track in metres, y up; uncertainties and radius with the local magnification."""
    x, y = apply(scale, track.x, track.y)
    magnification = local_scale(scale, track.x, track.y)
    return replace(
        track,
        unit="m",
        x=x,
        y=y,
        x_sd=track.x_sd * magnification,
        y_sd=track.y_sd * magnification,
        radius=track.radius * float(np.median(magnification)),
        radius_sd=track.radius_sd * float(np.median(magnification)),
        shared_sd=track.shared_sd * float(np.median(magnification)),
        offset_sd=track.offset_sd * float(np.median(magnification)),
    )


def apply(scale: Scale, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Map points from pixels to metres."""
    u, v, w = scale.matrix @ np.vstack((x, y, np.ones_like(x)))
    return u / w, v / w


def to_pixels(scale: Scale, places: FloatArray) -> FloatArray:
    """Map points (n, 2) from metres back to pixels of the picture, y down."""
    back = replace(scale, matrix=np.asarray(np.linalg.inv(scale.matrix), dtype=np.float64))
    return np.column_stack(apply(back, places[:, 0], places[:, 1]))


def local_scale(scale: Scale, x: FloatArray, y: FloatArray) -> FloatArray:
    """Metres per pixel at points of the picture: the root of the area magnification."""
    w = scale.matrix[2] @ np.vstack((x, y, np.ones_like(x)))
    return np.asarray(np.sqrt(np.abs(np.linalg.det(scale.matrix))) / np.abs(w) ** 1.5)


def _marked(length: float) -> float:
    """Relative uncertainty of a length (px) between two marks, which may lie off the plane of motion."""
    return float(np.hypot(np.sqrt(2) * CLICK_PX / length, PLANE_SD))


def _require_positive(name: str, value: float) -> None:
    """Let only positive finite numbers pass."""
    if not (np.isfinite(value) and value > 0):
        raise ValueError(f"{name} must be positive, got {value:g}")
