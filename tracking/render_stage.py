"""One exposure of a drop: everything that a frame shows, put together back to front."""

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import ArrayLike

from tracking.flight import Floats
from tracking.render_ball import Image, Look, darken, render_ball
from tracking.render_hand import SKINS, Hand, Part, draw_part, hand_places, make_grip, make_hand
from tracking.render_motion import Drop, heights, play
from tracking.render_scene import DropScene
from tracking.render_wall import paint_wall

BLUR_STEP = 0.75
"""Longest way (px) between two instants that are averaged into one exposure."""
SWAY = (0.6, 0.45)
"""Frequencies at which a hand-held camera sways across and up and down, Hz."""
MIRROR = 0.16
"""Opacity of a ball's mirror image in the plate."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BallTrack:
    """Where a ball is in all frames of a recording, in pixels (x, y).

    `instants` within each exposure, shape (frames, instants, 1 or rows, 2): rows where they are exposed in
    turn; `middles` of the exposures and the `feet` below them on the plate, shape (frames, 2).
    """

    look: Look
    radius: float
    instants: Floats
    middles: Floats
    feet: Floats


@dataclass(frozen=True, slots=True, kw_only=True)
class Stage:
    """A scene with all that is computed once: frames' times, wall, balls, hand; and the place of the hand."""

    scene: DropScene
    times: Floats
    wall: Image
    balls: tuple[BallTrack, ...]
    hand: Hand
    grip: tuple[Part, ...]


def build_stage(scene: DropScene, rng: np.random.Generator) -> Stage:
    """Paint the wall, draw the hand, play the drop, and place the balls in every frame."""
    drop = play(scene)
    times = frame_times(scene, drop)
    density = 1 / scene.camera.metres_per_pixel
    skin = SKINS[int(rng.integers(len(SKINS)))]
    return Stage(
        scene=scene,
        times=times,
        wall=paint_wall(scene, rng),
        balls=tuple(_track(scene, drop, ball, times) for ball in range(len(drop.paths))),
        hand=make_hand(rng, skin, scene.radii[0], density),
        grip=make_grip(rng, skin, scene.radii[1], density) if scene.kind == "held" else (),
    )


def frame_times(scene: DropScene, drop: Drop) -> Floats:
    """Time stamps of all frames until the end of the drop, s; uneven where the camera's rate varies."""
    number = np.arange(math.ceil(drop.end * scene.camera.fps), dtype=float)
    if scene.camera.jitter:  # dice of its own: the wall and the noise stay those of the seed
        late = np.random.default_rng((scene.seed, len(number))).uniform(-1, 1, len(number))
        number[1:] += scene.camera.jitter * late[1:]
    return number / scene.camera.fps


def _track(scene: DropScene, drop: Drop, ball: int, times: Floats) -> BallTrack:
    """Place one ball in all frames; instants of an exposure are so many that the fastest way is sampled."""
    camera = scene.camera
    fastest = math.sqrt(2 * scene.gravity * (scene.drop_height + scene.contact_height))
    halvings = math.ceil(math.log2(max(fastest * camera.exposure / camera.metres_per_pixel / BLUR_STEP, 1)))
    share = (np.arange(2**halvings) + 0.5) / 2**halvings
    moments = (times[:, np.newaxis] + camera.exposure * share)[..., np.newaxis]
    if camera.readout:
        moments = moments + camera.readout * np.linspace(0, 1, scene.size_px[1])
    middle = times + camera.exposure / 2 + camera.readout / 2
    return BallTrack(
        look=Look(colour=scene.colours[ball], shading=scene.shading),
        radius=scene.radii[ball] / camera.metres_per_pixel,
        instants=centres(scene, drop, ball, moments),
        middles=centres(scene, drop, ball, middle),
        feet=project(scene, _across(scene, drop, ball, middle), 0.0, middle),
    )


def expose(stage: Stage, frame: int, picture: Image) -> None:
    """Fill `picture` (grey levels, shape of the wall) with what a frame shows, without noise."""
    scene, hand, time = stage.scene, stage.hand, float(stage.times[frame])
    _view(stage, time, picture)
    for ball in stage.balls:
        _draw_shadows(picture, ball, frame)
    held = project(scene, 0.0, scene.contact_height + scene.drop_height, time)
    finger, thumb, palm = (held + shift for shift in hand_places(hand, time - scene.hold))
    draw_part(picture, hand.finger, finger)
    for ball in stage.balls:
        render_ball(picture, _thinned(ball.instants[frame]), ball.radius, ball.look)
    for part in stage.grip:
        draw_part(picture, part, project(scene, 0.0, scene.radii[1], time))
    draw_part(picture, hand.thumb, thumb)
    draw_part(picture, hand.palm, palm)


def _thinned(instants: Floats) -> Floats:
    """As few instants of an exposure as the ball's way in it needs, by means over neighbours."""
    way = float(np.abs(np.diff(instants[:, 0], axis=0)).sum())
    count = len(instants)
    while count > 1 and way < BLUR_STEP * (count // 2):
        count //= 2
    return np.asarray(instants.reshape(count, -1, *instants.shape[1:]).mean(axis=1))


def _across(scene: DropScene, drop: Drop, ball: int, time: Floats) -> Floats:
    """Way a ball has gone sideways, m."""
    flown = np.maximum(time - drop.release, 0)
    return scene.sideways_velocity * flown if ball == 0 else np.zeros_like(time)


def centres(scene: DropScene, drop: Drop, ball: int, time: Floats) -> Floats:
    """Pixel coordinates of a ball's centre at any times, shape (..., 2)."""
    return project(scene, _across(scene, drop, ball, time), heights(drop.paths[ball], time), time)


def project(scene: DropScene, across: ArrayLike, height: ArrayLike, time: ArrayLike) -> Floats:
    """Pixel coordinates, shape (..., 2), of points by metres from the middle and above the plate."""
    middle, turn = _axis(scene)
    scale = scene.camera.metres_per_pixel
    floor = scene.floor_row - 0.5 - middle[1]
    upright = np.stack(
        np.broadcast_arrays(np.divide(across, scale), floor - np.divide(height, scale)), axis=-1
    )
    return np.asarray(upright @ turn.T + middle + _sway(scene, time))


def _axis(scene: DropScene) -> tuple[Floats, Floats]:
    """Middle of the picture, about which the camera is turned, and that rotation as a matrix."""
    width, height = scene.size_px
    cosine, sine = math.cos(scene.camera.tilt), math.sin(scene.camera.tilt)
    return np.array([width - 1, height - 1]) / 2, np.array([[cosine, -sine], [sine, cosine]])


def _sway(scene: DropScene, time: ArrayLike) -> Floats:
    """Shift (x, y) of the whole picture by the camera's sway, px; none at the first frame."""
    angle = 2 * np.pi * np.multiply.outer(np.asarray(time, float), SWAY)
    return np.asarray(scene.camera.drift_px * np.sin(angle))


def _view(stage: Stage, time: float, picture: Image) -> None:
    """Fill `picture` with the wall as the camera sees it at this moment, tilted and shifted."""
    camera = stage.scene.camera
    if camera.tilt == 0 and camera.drift_px == 0:
        np.copyto(picture, stage.wall)
        return
    middle, turn = _axis(stage.scene)
    shift = middle - turn @ middle + _sway(stage.scene, time)
    matrix = np.column_stack([turn, shift])
    cv2.warpAffine(stage.wall, matrix, stage.scene.size_px, dst=picture, borderMode=cv2.BORDER_REFLECT)


def _draw_shadows(picture: Image, ball: BallTrack, frame: int) -> None:
    """Soft shadows of a ball on wall and plate, and its faint mirror image in the plate; drawn in place."""
    place, foot, radius = ball.middles[frame], ball.feet[frame], ball.radius
    edge = min(max(math.ceil(foot[1]), 0), picture.shape[0])
    wall, plate = picture[:edge], picture[edge:]
    darken(wall, place + np.array([1.2, 1.4]) * radius, (0.8 * radius, 0.8 * radius), 0.13)
    lift = max(float(foot[1] - place[1]) / radius - 1, 0)
    spread = (0.6 + 0.3 * lift) * radius, 0.16 * radius
    darken(plate, foot - np.array([0, edge - 0.12 * radius]), spread, 0.55 / (1 + lift) ** 2)
    # upside down, with its light: drawn on the plate's rows from the bottom up
    mirrored = np.array([place[0], len(plate) - 1 - (2 * foot[1] - place[1] - edge)])
    render_ball(plate[::-1], mirrored, radius, replace(ball.look, opacity=MIRROR))
