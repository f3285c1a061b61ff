"""Synthetic recordings of drops with known truth: for the demo, the tests, and for planning an experiment.

`frames` gives the pictures, `truth` what they show, `write_recording` puts both into files. A frame's time
stamp is the start of its exposure. Pictures have y down and pixel centres at whole numbers; heights are in
metres above the plate, whose upper edge is at row coordinate ``scene.floor_row - 0.5``.
"""

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tracking.encode import write_video
from tracking.flight import Floats, flight_of_ball
from tracking.render_ball import Look, render_ball
from tracking.render_motion import play
from tracking.render_scene import Camera, DropScene
from tracking.render_stage import build_stage, centres, expose, frame_times
from tracking.render_wall import add_noise, noise_tiles

__all__ = ["Camera", "DropScene", "Look", "ball_centres", "frames", "render_ball", "truth", "write_recording"]

LAMP_FLICKER = 100.0
"""Lamps on 50 Hz mains flicker at twice that, Hz."""


def frames(scene: DropScene) -> Iterator[NDArray[np.uint8]]:
    """Pictures of a scene in order, blue, green, red.

    Yields
    ------
    ndarray of uint8, shape (rows, columns, 3)

    Examples
    --------
    >>> picture = next(frames(DropScene(kind="plate", drop_height=0.1)))
    >>> picture.shape, picture.dtype
    ((334, 360, 3), dtype('uint8'))
    """
    rng = np.random.default_rng(scene.seed)
    stage = build_stage(scene, rng)
    tiles = noise_tiles(scene.size_px, scene.camera.noise, rng)
    # fresh memory for every picture would cost more than all the drawing
    picture, levels = np.empty_like(stage.wall), np.empty(stage.wall.shape, np.uint8)
    for frame, time in enumerate(stage.times):
        expose(stage, frame, picture)
        lamp = math.sin(2 * math.pi * LAMP_FLICKER * (time + scene.camera.exposure / 2))
        cv2.convertScaleAbs(picture, levels, 1 + scene.camera.flicker * lamp)
        yield add_noise(levels, tiles, rng)


def truth(scene: DropScene) -> dict[str, Any]:
    """Tell what a recording of the scene shows, in the layout of its JSON file.

    Returns
    -------
    dict
        ``events`` lists the impacts of the upper ball: ``t`` (s from the first time stamp), ``v0`` and ``v1``
        (m/s before and after, upper ball first, up positive); the rest are the parameters behind them.
    """
    drop, camera, balls = play(scene), scene.camera, 1 if scene.kind == "plate" else 2
    flights = [
        flight_of_ball(mass, radius, scene.air, scene.gravity)
        for mass, radius in zip(scene.masses[:balls], scene.radii, strict=False)
    ]
    return {
        "kind": scene.kind,
        "fps": camera.fps,
        "file_fps": camera.file_fps or camera.fps,
        "mm_per_px": camera.metres_per_pixel * 1000,
        "size": list(scene.size_px),
        "seed": scene.seed,
        "noise": camera.noise,
        "masses_kg": list(scene.masses),
        "drag_coefficient": scene.air.drag_coefficient,
        "air_density": scene.air.density,
        "effective_gravity": [flight.gravity for flight in flights],
        "mass_ratio_upper_over_lower": scene.masses[0] / scene.masses[1],
        "ball_radius_m": scene.radii[0],
        "ball_radii_m": list(scene.radii),
        "drop_height_m": scene.drop_height,
        "events": [
            {"t": impact.time, "v0": list(impact.before), "v1": list(impact.after)}
            for impact in drop.impacts
            if impact.before[0] != impact.after[0] and impact.time <= drop.end
        ],
        "e1": scene.restitution_balls,
        "e2": scene.restitution_plate,
        "tilt_deg": math.degrees(camera.tilt),
        "floor_row": scene.floor_row,
        "frames": len(frame_times(scene, drop)),
        "release_t": drop.release,
        "exposure": camera.exposure,
        "readout": camera.readout,
    }


def write_recording(
    scene: DropScene,
    path: Path | str,
    *,
    crf: int | None = 20,
    preset: str = "ultrafast",
    tree: bool = False,
) -> dict[str, Any]:
    """Write the video to `path` and its truth beside it, as JSON with the same name.

    Parameters
    ----------
    scene : DropScene
        What to film.
    path : Path or str
        Video file to write, as in ``two-06.mp4``.
    crf : int or None
        Strength of the compression: None none at all, 0 of colour only, 20 good, 35 poor.
    preset : str
        Speed of x264 against how well it follows what moves.
    tree : bool
        Whether x264 may take bits from what moves, as programs let it and cameras do not.

    Returns
    -------
    dict
        The truth.
    """
    path, shown, camera = Path(path), truth(scene), scene.camera
    stretch = camera.fps / shown["file_fps"]
    times = frame_times(scene, play(scene)) * stretch if camera.jitter else None
    clear_places(path)
    write_video(path, frames(scene), shown["file_fps"], crf=crf, preset=preset, tree=tree, times=times)
    path.with_suffix(".json").write_text(json.dumps(shown, indent=1) + "\n")
    return shown


def clear_places(path: Path) -> None:
    """Remove what lies where a recording and its truth will: a link there would be written through."""
    for place in (path, path.with_suffix(".json")):
        place.unlink(missing_ok=True)


def ball_centres(scene: DropScene, ball: int, time: ArrayLike) -> Floats:
    """Centre of a ball in pixels at any times.

    Parameters
    ----------
    scene : DropScene
        The recording.
    ball : int
        0 is the upper, 1 the lower ball.
    time : array_like
        Seconds from the first time stamp.

    Returns
    -------
    ndarray, shape (..., 2)
        Column and row, ``(x, y)``; pixel centres are at whole numbers.
    """
    return centres(scene, play(scene), ball, np.asarray(time, float))
