"""One recording and what is known about it, as checked dataclasses."""

import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from reprlib import repr as shown
from typing import Any

KINDS = ("plate", "held", "two", "shot", "pair")
SCALE_KEYS = (
    {"ball_diameter"},
    {"metres_per_pixel"},
    {"points_px", "distance"},
    {"corners_px", "width", "height"},
)
POINTS = {"points_px": 2, "corners_px": 4}
HEAVIEST = 1000.0  # kg: more is a mass in other units
WIDEST = 1.0  # m: a ball wider than that was given in millimetres
FASTEST_CAMERA = 1e6  # frames/s
LONGEST_LENGTH = 1000.0  # m: nothing larger fits a laboratory
SHORTEST_LENGTH = 1e-9  # m
FARTHEST_PX = 1e6  # no camera has so many pixels in a row
LONGEST_NAME = 200  # bytes: file systems allow 255 with the ending
FORMULA = re.compile(r"[=@+]|-.*[(|!]")
"""How names begin that a spreadsheet would compute when it opens trials.csv, whoever chose them."""
NOT_IN_NAMES = re.compile(r"[/\\:\x00-\x1f\x7f\ud800-\udfff]")


@dataclass(frozen=True, slots=True, kw_only=True)
class Body:
    """A ball or a cue.

    Attributes
    ----------
    mass : float or None
        Mass, kg; None where it was not told.
    diameter : float or None
        Diameter, m; None where it was not told.

    Raises
    ------
    ValueError
        If one of them is not positive, or so large that it must be in other units.

    Examples
    --------
    >>> Body(mass=0.0027, diameter=40)
    Traceback (most recent call last):
    ValueError: diameter must be at most 1 m, got 40; is it in metres?
    """

    mass: float | None = None
    diameter: float | None = None

    def __post_init__(self) -> None:
        for name, most, units in (("mass", HEAVIEST, "kg kilograms"), ("diameter", WIDEST, "m metres")):
            value = getattr(self, name)
            if value is None:
                continue
            require_positive(name, value)
            unit, words = units.split()
            if value > most:
                raise ValueError(
                    f"{name} must be at most {most:g} {unit}, got {shown(value)}; is it in {words}?"
                )


@dataclass(frozen=True, slots=True, kw_only=True)
class Camera:
    """How the pictures were taken.

    Attributes
    ----------
    capture_fps : float or None
        Frames captured a second, where the file does not tell.
    readout : float or None
        Rolling shutter: time from the first to the last row, s; None where it was not told.
    scale : mapping
        As in the file: ``{"metres_per_pixel": 0.0008}``, ``{"ball_diameter": "upper"}``, two points and
        their distance, or four corners with width and height. Empty: from the diameter of the upper ball.
        ``"relative_sd": 0.002`` beside one of them says how well it is known.

    Raises
    ------
    ValueError
        If a value is impossible, naming it and the rule.
    """

    capture_fps: float | None = None
    readout: float | None = None
    scale: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.capture_fps is not None:
            require_positive("capture_fps", self.capture_fps)
            if self.capture_fps > FASTEST_CAMERA:
                raise ValueError(
                    f"capture_fps must be at most {FASTEST_CAMERA:g}, got {shown(self.capture_fps)}"
                )
        if self.readout is not None and not (is_number(self.readout) and 0 <= self.readout < 1):
            raise ValueError(f"readout must be within [0, 1) s, got {shown(self.readout)}")
        _check_scale(self.scale)

    @property
    def row_time(self) -> float:
        """Time from the first to the last row, s: 0, as in a camera without rolling shutter, if not told."""
        return self.readout or 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """One recording.

    Attributes
    ----------
    name : str
        What it is called in the results; its files are named after it.
    video : Path
        The recording.
    kind : {"plate", "held", "two", "shot", "pair"}
        What it shows: a ball on the plate, on a ball held still, on a ball at rest; a cue ball struck; two
        bodies that meet in free motion.
    bodies : mapping of str to Body
        By name: upper and lower of a drop, ball and cue of a shot, striker and struck of a pair.
    camera : Camera
        How it was filmed.
    start_px : two floats or None
        Where the ball to be measured is first seen (x, y in px), if several move; not for a pair.

    Raises
    ------
    ValueError
        If the kind is unknown, the name cannot be that of a file, or `start_px` is no point.
    """

    name: str
    video: Path
    kind: str
    bodies: Mapping[str, Body] = field(default_factory=dict)
    camera: Camera = field(default_factory=Camera)
    start_px: Sequence[float] | None = None

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ValueError(f"kind must be one of {', '.join(KINDS)}, got {self.kind!r}")
        too_long = len(self.name.encode(errors="replace")) > LONGEST_NAME
        if not self.name.strip(" .") or too_long or NOT_IN_NAMES.search(self.name):
            raise ValueError(
                f"name must be that of a file (no folder, none of / \\ :, at most {LONGEST_NAME} bytes), "
                f"got {shown(self.name)}"
            )
        for name in (self.name, self.video.name):
            if FORMULA.match(name):
                raise ValueError(
                    f"name must not begin like a formula of a spreadsheet (=, +, @), got {shown(name)}"
                )
        if self.start_px is not None:
            if not _is_point(self.start_px):
                raise ValueError(f"start_px must be a point [x, y] in pixels, got {shown(self.start_px)}")
            if self.kind == "pair":
                raise ValueError("start_px is for trials that measure one ball, got kind 'pair'")

    def body(self, name: str) -> Body:
        """Give a body, unknown in everything if it was not told."""
        return self.bodies.get(name, Body())


def _check_scale(scale: Any) -> None:
    """Refuse a scale that is none of the four ways to give one."""
    if not isinstance(scale, Mapping):
        raise TypeError(f"scale must be a table such as {{ metres_per_pixel = 0.0008 }}, got {shown(scale)}")
    if scale and set(scale) - {"relative_sd"} not in SCALE_KEYS:
        ways = " or ".join(" + ".join(sorted(keys)) for keys in SCALE_KEYS)
        raise ValueError(f"scale must have {ways}, got the keys {', '.join(sorted(scale))}")
    for name, value in scale.items():
        if name == "ball_diameter":
            if value not in ("upper", "ball", "striker"):
                names = "'upper', 'ball' or 'striker'"
                raise ValueError(f"scale: ball_diameter must name the ball {names}, got {shown(value)}")
        elif name in POINTS:
            _check_points(name, value)
        elif name == "relative_sd":
            if not (is_number(value) and 0 <= value < 1):
                raise ValueError(f"scale: relative_sd must be within [0, 1), got {shown(value)}")
        else:
            require_positive(f"scale: {name}", value)
            if not SHORTEST_LENGTH <= value <= LONGEST_LENGTH:
                span = f"[{SHORTEST_LENGTH:g}, {LONGEST_LENGTH:g}] m"
                raise ValueError(f"scale: {name} must be within {span}, got {shown(value)}")


def _check_points(name: str, points: Any) -> None:
    """Refuse what is not a list of the right number of points [x, y]."""
    pairs = points if _is_list(points) else []
    count = POINTS[name]
    if len(pairs) != count or not all(map(_is_point, pairs)):
        raise ValueError(f"scale: {name} must be {count} points [x, y] in pixels, got {shown(points)}")
    if name == "corners_px" and not _goes_round(pairs):
        raise ValueError(
            "scale: corners_px must be the lower left, lower right, upper right and upper left corner, in "
            f"this order, got {shown(points)}"
        )


def _goes_round(corners: Sequence[Sequence[float]]) -> bool:
    """Tell whether four corners turn to the left at each, as one sees them in a picture, where y is down."""
    sides = [(b[0] - a[0], b[1] - a[1]) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)]
    return all(a[0] * b[1] < a[1] * b[0] for a, b in zip(sides, [*sides[1:], sides[0]], strict=True))


def require_positive(name: str, value: object) -> None:
    """Let only positive finite numbers pass."""
    if not (is_number(value) and value > 0):  # type: ignore[operator]
        raise ValueError(f"{name} must be positive, got {shown(value)}")


def is_number(value: object) -> bool:
    """Tell a finite number from text, a truth value, NaN and infinity."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    return abs(value) <= sys.float_info.max


def _is_point(value: Any) -> bool:
    """Tell a pair of pixel coordinates that may lie in a picture or near it."""
    if not _is_list(value) or len(value) != 2:
        return False
    return all(is_number(number) and abs(number) <= FARTHEST_PX for number in value)


def _is_list(value: object) -> bool:
    return isinstance(value, Sequence) and not isinstance(value, (str, bytes))
