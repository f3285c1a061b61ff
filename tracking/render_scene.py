"""What a synthetic recording of a drop shows: the balls, what happens to them, and the camera."""

import math
from dataclasses import dataclass, field
from typing import Literal, get_args

from tracking.flight import STANDARD_GRAVITY, Air

Colour = tuple[float, float, float]
DropKind = Literal["plate", "held", "two"]

HEADROOM = 0.095
"""Height shown above the centre of the ball in the hand, m: enough for fingers and palm."""
PLATE_ROWS = 64
"""Rows of the picture that the plate takes at the bottom."""


def require(condition: bool, name: str, rule: str, value: object) -> None:
    """Raise the ValueError "name must rule, got value" unless the condition holds."""
    if not condition:
        raise ValueError(f"{name} must {rule}, got {value}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Camera:
    """How the scene is filmed.

    Attributes
    ----------
    fps : float
        Frames captured per second.
    file_fps : float or None
        Frames per second the file claims, where that differs (slow motion).
    metres_per_pixel : float
        Scale in the plane of the balls, m.
    width_px : int
        Picture width; the height follows from the drop.
    exposure : float
        Exposure time, s; it starts at the time stamp of the frame.
    readout : float
        Time from the start of the first row to that of the last, s (rolling shutter).
    noise : float
        Standard deviation of the sensor noise, grey levels.
    flicker : float
        Relative amplitude of the lamps' flicker at 100 Hz.
    drift_px : float
        Amplitude of the slow sway of a hand-held camera.
    tilt : float
        Angle by which the camera is turned about its axis, rad.
    jitter : float
        How far a frame comes early or late at most, as a share of the interval (variable frame rate).

    Raises
    ------
    ValueError
        If a rate or the scale is not positive, or anything else is negative or too large to be filmed.
    """

    fps: float = 240.0
    file_fps: float | None = None
    metres_per_pixel: float = 0.0008
    width_px: int = 360
    exposure: float = 1 / 800
    readout: float = 0.0
    noise: float = 2.5
    flicker: float = 0.01
    drift_px: float = 0.0
    tilt: float = 0.0
    jitter: float = 0.0

    def __post_init__(self) -> None:
        require(0 < self.fps < math.inf, "fps", "be positive and finite", self.fps)
        require(self.file_fps is None or self.file_fps > 0, "file_fps", "be positive", self.file_fps)
        require(self.metres_per_pixel > 0, "metres_per_pixel", "be positive", self.metres_per_pixel)
        even = self.width_px >= 64 and self.width_px % 2 == 0
        require(even, "width_px", "be an even number of at least 64", self.width_px)
        for name in ("exposure", "readout"):
            value = getattr(self, name)
            require(0 <= value <= 1 / self.fps, name, f"be within [0, {1 / self.fps:.6g}] s (1/fps)", value)
        for name in ("noise", "drift_px"):
            require(0 <= getattr(self, name) <= 50, name, "be within [0, 50]", getattr(self, name))
        require(0 <= self.flicker < 0.5, "flicker", "be within [0, 0.5)", self.flicker)
        require(abs(self.tilt) < 0.2, "tilt", "be within (-0.2, 0.2) rad", self.tilt)
        require(0 <= self.jitter < 0.5, "jitter", "be within [0, 0.5)", self.jitter)


@dataclass(frozen=True, slots=True, kw_only=True)
class DropScene:
    """A ball let go by a hand falls on a plate, on a held ball, or on a ball that rests on the plate.

    Attributes
    ----------
    kind : {"plate", "held", "two"}
        What the upper ball falls on.
    drop_height : float
        How far it falls until it touches, m.
    masses, radii : tuple of float
        Upper ball, lower ball; kg and m. The second is not used with "plate".
    restitution_balls, restitution_plate : float
        Restitution between the balls and between a ball and the plate.
    first_rebound : tuple of float or None
        "two" only: velocities of upper and lower ball after the first impact over the speed of approach, up
        positive. An impact model supplies them; later collisions are simple pairwise ones.
    air : Air
        What the balls fall through.
    gravity : float
        Local gravity, m/s².
    sideways_velocity : float
        Horizontal velocity of the upper ball from its release, m/s.
    hold, after : float
        Time the ball rests in the hand, and time filmed after the first impact, s.
    colours : tuple of (blue, green, red)
        Colours of upper and lower ball, 0 to 255.
    shading : float
        0 shows flat discs, 1 balls in full light and shade.
    camera : Camera
        How it is filmed.
    seed : int
        Chooses wall, light, hand and noise: same seed, same picture.

    Raises
    ------
    ValueError
        If a value is impossible or the kind unknown.

    Examples
    --------
    >>> DropScene(kind="plate", drop_height=0.25).size_px
    (360, 522)
    """

    kind: DropKind
    drop_height: float
    masses: tuple[float, float] = (0.0027, 0.0027)
    radii: tuple[float, float] = (0.020, 0.020)
    restitution_balls: float = 0.8
    restitution_plate: float = 0.85
    first_rebound: tuple[float, float] | None = None
    air: Air = field(default_factory=Air)
    gravity: float = STANDARD_GRAVITY
    sideways_velocity: float = 0.0
    hold: float = 0.06
    after: float = 0.3
    colours: tuple[Colour, Colour] = ((40.0, 130.0, 235.0), (232.0, 238.0, 240.0))
    shading: float = 1.0
    camera: Camera = field(default_factory=Camera)
    seed: int = 0

    def __post_init__(self) -> None:
        require(self.kind in get_args(DropKind), "kind", "be plate, held or two", repr(self.kind))
        for name in ("drop_height", "gravity", "after"):
            require(0 < getattr(self, name) < math.inf, name, "be positive and finite", getattr(self, name))
        for name in ("masses", "radii"):
            pair = getattr(self, name)
            require(len(pair) == 2 and min(pair) > 0, name, "be two positive numbers", pair)
        for name in ("restitution_balls", "restitution_plate"):
            require(0 <= getattr(self, name) <= 1, name, "be within [0, 1]", getattr(self, name))
        require(0.05 <= self.hold < math.inf, "hold", "be at least 0.05 s", self.hold)
        self._check_rebound()

    def _check_rebound(self) -> None:
        if self.kind != "two":
            rule = 'be given with kind "two" only'
            require(self.first_rebound is None, "first_rebound", rule, self.first_rebound)
            return
        rule = "be (upper, lower) with 0 <= lower <= upper <= 3"
        require(self.first_rebound is not None, "first_rebound", rule, None)
        upper, lower = self.first_rebound or (0.0, 0.0)
        require(0 <= lower <= upper <= 3, "first_rebound", rule, self.first_rebound)

    @property
    def contact_height(self) -> float:
        """Height of the upper centre above the plate when it first touches, m."""
        upper, lower = self.radii
        return upper if self.kind == "plate" else upper + 2 * lower

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height of the picture, both even."""
        shown = (self.drop_height + self.contact_height + HEADROOM) / self.camera.metres_per_pixel
        return self.camera.width_px, PLATE_ROWS + 2 * math.ceil(shown / 2)

    @property
    def floor_row(self) -> int:
        """First row of the plate; its upper edge, height 0, is at row coordinate ``floor_row - 0.5``."""
        return self.size_px[1] - PLATE_ROWS
