"""How large a ball is that a camera without colours sees before a wall as grey as itself."""

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest

from tracking.circle import RAYS
from tracking.consensus import agreed_circles
from tracking.encode import write_video
from tracking.flight import Air, flight_of_ball
from tracking.planes import Image
from tracking.render import Camera, DropScene, frames, truth
from tracking.scale import scale_from_ball, to_metres
from tracking.track import track_balls
from tracking.velocity import measure_impacts
from tracking.video import open_recording

WALLS = {"dark": 4, "bright": 3}
ANGLES = np.arange(RAYS) * 2 * np.pi / RAYS


def without_colour(scene: DropScene) -> Iterator[Image]:
    for picture in frames(scene):
        grey = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
        yield np.asarray(cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR), np.uint8)


@pytest.mark.parametrize(("level", "wall"), [(160.0, "dark"), (180.0, "bright")])
def test_grey_ball_before_a_grey_wall_is_measured_within_its_uncertainty(
    level: float, wall: str, tmp_path: Path
) -> None:
    scene = DropScene(
        kind="plate",
        drop_height=0.15,
        colours=((level, level, level), (235.0, 235.0, 235.0)),
        camera=Camera(width_px=240),
        seed=WALLS[wall],
    )
    write_video(tmp_path / "grey.mp4", without_colour(scene), 240.0)
    (ball,) = track_balls(open_recording(tmp_path / "grey.mp4"))
    assert ball.radius == pytest.approx(25.0, rel=0.02)
    ball = to_metres(ball, scale_from_ball(ball, 0.040))
    impact = measure_impacts(ball, flight_of_ball(0.0027, 0.020, Air()))[0]
    event = truth(scene)["events"][0]
    assert impact.velocities[0] == pytest.approx(event["v0"][0], rel=0.015)
    assert impact.velocities[1] == pytest.approx(event["v1"][0], rel=0.015)


def test_circles_of_an_outline_and_of_a_highlight_within_it_are_both_found() -> None:
    size = np.where(np.arange(RAYS) < RAYS // 2, 20.0, 14.0)
    points = np.column_stack((50 + size * np.cos(ANGLES), 40 + size * np.sin(ANGLES)))
    points[::9] = np.nan
    found = agreed_circles(points, 17.0)
    assert {round(radius) for x, y, radius in found[:2] if np.hypot(x - 50, y - 40) < 0.1} == {14, 20}


def test_points_that_agree_on_nothing_make_no_circle() -> None:
    scattered = np.random.default_rng(5).uniform(0, 100, (RAYS, 2))
    assert agreed_circles(scattered, 20.0) == []
    assert agreed_circles(np.full((RAYS, 2), np.nan), 20.0) == []
