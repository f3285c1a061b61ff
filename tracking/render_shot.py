"""Synthetic recordings of a cue shot seen from above: a cue strikes a white ball, which slides, then rolls.

Metres have x to the right and y up in the picture, from its lower left corner; pixel centres are at whole
numbers, so column ``x / scale - 0.5`` and row ``height - 0.5 - y / scale``.
"""

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tracking.cloth import Cloth, cloth_position, sliding_time
from tracking.encode import write_video
from tracking.flight import Floats
from tracking.render_ball import Image, Look, darken, render_ball
from tracking.render_scene import Camera, Colour, require
from tracking.render_wall import add_noise, clouds, noise_tiles

Vector = tuple[float, float]

GREEN: Colour = (72, 124, 40)
WOOD: Colour = (110, 168, 214)
WHITE: Colour = (226, 234, 238)
OBJECT_BALLS: tuple[Colour, ...] = ((40, 30, 170), (110, 40, 100), (30, 150, 220), (90, 60, 30))
"""Colours (blue, green, red) of cloth, cue, cue ball, and of the balls that lie about."""
INSTANTS = 6
"""Instants averaged into one exposure of the moving ball."""
CUE_HALF_WIDTH = 0.0065
"""Half the width of the cue's tip, m; it is twice as thick one metre behind."""
FOLLOW_THROUGH = 0.06
"""Way of the cue after the strike, m."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ShotScene:
    """A cue strikes a resting ball, filmed from straight above.

    Attributes
    ----------
    velocity, angular_velocity : tuple of float
        Of the ball just after the strike, (x, y), m/s and rad/s.
    cloth : Cloth
        What it slides and rolls on.
    radius : float
        Of the ball, m.
    start : tuple of float
        Where the ball rests, m.
    strike, duration : float
        Time of the strike, and of the end of the recording, s.
    cue_speed, cue_direction : float
        Of the cue before the strike, m/s; angle of its motion from x to y, rad.
    height_px : int
        Picture height; the width is the camera's.
    camera : Camera
        Fixed, untilted and without rolling shutter.
    seed : int
        Chooses cloth, light, the other balls and the noise.

    Raises
    ------
    ValueError
        If a value is impossible, or the camera moves.

    Examples
    --------
    >>> scene = ShotScene(velocity=(1.8, 0.35), angular_velocity=(-8.0, -30.0), cloth=Cloth(friction=0.2))
    >>> print(f"{shot_truth(scene)['roll_t']:.4f} s")
    0.5376 s
    """

    velocity: Vector
    angular_velocity: Vector
    cloth: Cloth
    radius: float = 0.0286
    start: Vector = (0.25, 0.512)
    strike: float = 0.15
    duration: float = 1.3
    cue_speed: float = 2.0
    cue_direction: float = 0.2
    height_px: int = 640
    camera: Camera = field(default_factory=lambda: Camera(fps=120, metres_per_pixel=0.0016, width_px=1280))
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("radius", "strike", "cue_speed"):
            require(0 < getattr(self, name) < math.inf, name, "be positive and finite", getattr(self, name))
        require(self.duration > self.strike, "duration", f"exceed the strike, {self.strike} s", self.duration)
        even = self.height_px >= 64 and self.height_px % 2 == 0
        require(even, "height_px", "be an even number of at least 64", self.height_px)
        still = self.camera.tilt == self.camera.drift_px == self.camera.readout == 0
        require(still, "camera", "have no tilt, drift_px and readout", self.camera)

    @property
    def slip(self) -> Vector:
        """Velocity of the lowest point of the ball over the cloth just after the strike, m/s."""
        (vx, vy), (wx, wy) = self.velocity, self.angular_velocity
        return vx - self.radius * wy, vy + self.radius * wx

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height of the picture."""
        return self.camera.width_px, self.height_px


def shot_path(scene: ShotScene, time: ArrayLike) -> Floats:
    """Centre of the cue ball (x, y) in metres at any times (s from the first frame), shape (n, 2)."""
    since = np.maximum(np.asarray(time, float) - scene.strike, 0)
    return np.asarray(np.array(scene.start) + cloth_position(scene.cloth, scene.velocity, scene.slip, since))


def shot_truth(scene: ShotScene) -> dict[str, Any]:
    """Tell what a recording of the shot shows, in the layout of its JSON file; `path` lists t, x, y."""
    camera, times = scene.camera, np.arange(scene.strike, scene.duration, 0.01)
    return {
        "kind": "shot",
        "fps": camera.fps,
        "file_fps": camera.file_fps or camera.fps,
        "mm_per_px": camera.metres_per_pixel * 1000,
        "size": list(scene.size_px),
        "seed": scene.seed,
        "noise": camera.noise,
        "ball_radius_m": scene.radius,
        "v": list(scene.velocity),
        "w": list(scene.angular_velocity),
        "mu": scene.cloth.friction,
        "rolling": scene.cloth.rolling_resistance,
        "strike_t": scene.strike,
        "roll_t": scene.strike + sliding_time(scene.cloth, scene.slip),
        "cue_speed": scene.cue_speed,
        "frames": len(_times(scene)),
        "path": np.column_stack([times - scene.strike, shot_path(scene, times)]).tolist(),
    }


def write_shot(scene: ShotScene, path: Path, *, crf: int = 20) -> dict[str, Any]:
    """Write the video to `path` and its truth beside it, as JSON with the same name; returns the truth."""
    shown = shot_truth(scene)
    write_video(path, shot_frames(scene), shown["file_fps"], crf=crf, preset="ultrafast")
    path.with_suffix(".json").write_text(json.dumps(shown, indent=1) + "\n")
    return shown


def shot_frames(scene: ShotScene) -> Iterator[NDArray[np.uint8]]:
    """Pictures of a shot in order, uint8 arrays of shape (rows, columns, 3): blue, green, red."""
    rng = np.random.default_rng(scene.seed)
    table = _paint_table(scene, rng)
    tiles = noise_tiles(scene.size_px, scene.camera.noise, rng)
    picture, levels = np.empty_like(table), np.empty(table.shape, np.uint8)
    for time in _times(scene):
        np.copyto(picture, table)
        instants = shot_path(scene, time + scene.camera.exposure * (np.arange(INSTANTS) + 0.5) / INSTANTS)
        _draw_ball(picture, scene, instants, WHITE)
        _draw_cue(picture, scene, float(time + scene.camera.exposure / 2))
        cv2.convertScaleAbs(picture, levels)
        yield add_noise(levels, tiles, rng)


def _times(scene: ShotScene) -> Floats:
    return np.arange(math.ceil(scene.duration * scene.camera.fps)) / scene.camera.fps


def _pixels(scene: ShotScene, place: ArrayLike) -> Floats:
    """Pixel coordinates (column, row) of points (x, y) in metres."""
    scaled = np.asarray(place, float) / scene.camera.metres_per_pixel
    return np.stack([scaled[..., 0] - 0.5, scene.height_px - 0.5 - scaled[..., 1]], axis=-1)


def _paint_table(scene: ShotScene, rng: np.random.Generator) -> Image:
    """Cloth with its nap and light, and balls that lie about away from the path."""
    width, height = scene.size_px
    across, down = np.linspace(-1, 1, width, dtype=np.float32), np.linspace(-1, 1, height, dtype=np.float32)
    light = 1 + 0.03 * clouds(rng, (width, height), (110, 30, 7, 3))
    light *= 1.05 - 0.12 * (across**2 + down[:, np.newaxis] ** 2)
    table = np.asarray(light[..., np.newaxis] * np.array(GREEN), np.float32)
    taken = shot_path(scene, np.linspace(0, scene.duration, 60))
    size = np.array(scene.size_px) * scene.camera.metres_per_pixel
    for colour in OBJECT_BALLS:
        place = rng.uniform(2 * scene.radius, size - 2 * scene.radius)
        # a ball in the way would be hit, and one beside the cue would be covered
        if np.hypot(*(taken - place).T).min() > 4 * scene.radius and place[0] > scene.start[0]:
            taken = np.vstack([taken, place])
            _draw_ball(table, scene, place[np.newaxis], colour)
    return table


def _draw_ball(picture: Image, scene: ShotScene, places: Floats, colour: Colour) -> None:
    """Draw a ball and its soft shadow in place."""
    radius = scene.radius / scene.camera.metres_per_pixel
    centres = _pixels(scene, places)
    darken(picture, centres.mean(axis=0) + 0.35 * radius, (0.75 * radius, 0.75 * radius), 0.55)
    render_ball(picture, centres, radius, Look(colour=colour))


def _draw_cue(picture: Image, scene: ShotScene, time: float) -> None:
    """Draw the cue with its tip where it is at this moment, in place."""
    way = scene.cue_speed * (time - scene.strike)
    behind = scene.radius - min(way, FOLLOW_THROUGH * -math.expm1(-max(way, 0) / FOLLOW_THROUGH))
    along = np.array([math.cos(scene.cue_direction), math.sin(scene.cue_direction)])
    side = CUE_HALF_WIDTH * np.array([-along[1], along[0]])
    tip = np.array(scene.start) - behind * along
    butt = tip - along
    outline = _pixels(scene, [tip + side, tip - side, butt - 2 * side, butt + 2 * side])
    left, top = np.maximum(np.floor(outline.min(axis=0)).astype(int) - 2, 0)
    right, bottom = np.maximum(np.ceil(outline.max(axis=0)).astype(int) + 3, 0)
    patch = picture[top:bottom, left:right]
    if patch.size:
        mask = np.zeros(patch.shape[:2], np.uint8)
        corners = np.rint((outline - (left, top)) * 16).astype(np.int32)
        cv2.fillConvexPoly(mask, corners, 255, cv2.LINE_AA, 4)
        cover = mask.astype(np.float32)[..., np.newaxis] / 255
        patch += cover * (np.array(WOOD, np.float32) - patch)
