"""Cue shots: the struck ball is found, followed, and its path tells what the strike did."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from tracking.cloth import Cloth, cloth_position
from tracking.errors import RecordingError
from tracking.render_scene import Camera
from tracking.render_shot import ShotScene, shot_truth, write_shot
from tracking.scale import scale_from_corners, scale_from_metres_per_pixel
from tracking.shot import Shot, measure_shot
from tracking.strike import ShotTrack, shot_to_metres, track_shot
from tracking.track import Track
from tracking.video import open_recording

RADIUS = 0.0286
CLOTH = Cloth(friction=0.2, rolling_resistance=0.01)
STRIKE = 0.1
Places = NDArray[np.float64]
CLOTH_CORNERS = [[150, 488], [940, 488], [712, 103], [352, 103]]


def seen_from_above(
    place: Callable[[Places], Places], *, until: float = 1.0, noise: float = 8e-5
) -> ShotTrack:
    """Track, at 120 frames a second, of a ball at rest until STRIKE, at ``place(time since)`` afterwards."""
    time = np.arange(0, until, 1 / 120)
    x, y = (place(np.maximum(time - STRIKE, 0)) + np.random.default_rng(5).normal(0, noise, (len(time), 2))).T
    sd = np.full(len(time), noise)
    ball = Track(
        ball="cue ball",
        unit="m",
        frame=np.arange(len(time)),
        time=time,
        x=x,
        y=y,
        x_sd=sd,
        y_sd=sd,
        arc=np.full(len(time), 6.0),
        radius=RADIUS,
        radius_sd=1e-5,
    )
    return ShotTrack(
        ball=ball,
        tip=None,
        missing_tip="no cue",
        lift=np.zeros(len(time)),
        expected_radius=np.full(len(time), RADIUS),
        perspective=0.0,
    )


def struck(velocity: tuple[float, float], spin: tuple[float, float]) -> Callable[[Places], Places]:
    """Path of a ball with this velocity (m/s) and angular velocity (rad/s) after the strike."""
    slip = velocity[0] - RADIUS * spin[1], velocity[1] + RADIUS * spin[0]
    return lambda since: cloth_position(CLOTH, velocity, slip, since)


def pulls(shot: Shot, velocity: tuple[float, float], spin: tuple[float, float]) -> Places:
    """Deviations from the truth in standard deviations."""
    off = np.concatenate((shot.velocity - velocity, shot.angular_velocity - spin))
    return off / np.sqrt(np.diag(shot.covariance))


@pytest.mark.parametrize(
    ("velocity", "spin"),
    [
        ((1.8, 0.35), (-8.0, -30.0)),
        ((1.5, 0.5), (-40.0, 10.0)),
        ((-1.0, 1.2), (0.0, 0.0)),
        ((0.9, 0.0), (0.0, 60.0)),
    ],
)
def test_the_path_tells_velocity_spin_and_friction(
    velocity: tuple[float, float], spin: tuple[float, float]
) -> None:
    shot = measure_shot(seen_from_above(struck(velocity, spin)), RADIUS)
    assert np.abs(pulls(shot, velocity, spin)).max() < 4
    assert shot.velocity == pytest.approx(velocity, abs=0.01)
    assert shot.angular_velocity == pytest.approx(spin, abs=1.0)
    assert abs(shot.friction - 0.2) < 4 * shot.friction_sd < 0.05
    assert abs(shot.strike_time - STRIKE) < 0.0005
    assert np.isnan(shot.meeting_time)
    assert shot.notes == ("no cue",)


def test_rolling_starts_when_and_where_the_slip_is_gone() -> None:
    shot = measure_shot(seen_from_above(struck((1.8, 0.35), (-8.0, -30.0))), RADIUS)
    end = 2 * np.hypot(1.8 + RADIUS * 30, 0.35 - RADIUS * 8) / (7 * 0.2 * 9.80665)
    assert shot.rolling_time == pytest.approx(STRIKE + end, abs=0.003)
    assert shot.rolling_place == pytest.approx(
        struck((1.8, 0.35), (-8.0, -30.0))(np.array([end]))[0], abs=0.004
    )


def test_a_ball_that_rolls_at_once_tells_no_friction() -> None:
    shot = measure_shot(seen_from_above(struck((1.2, -0.4), (0.4 / RADIUS, 1.2 / RADIUS))), RADIUS)
    assert np.isnan(shot.friction)
    assert shot.angular_velocity == pytest.approx((0.4 / RADIUS, 1.2 / RADIUS), abs=0.5)
    assert "friction cannot be told" in shot.notes[0]


def test_a_ball_that_still_slides_tells_friction_but_no_spin() -> None:
    shot = measure_shot(seen_from_above(struck((2.0, 0.0), (0.0, -60.0)), until=0.35), RADIUS)
    assert shot.friction == pytest.approx(0.2, abs=0.02)
    assert np.isnan([*shot.angular_velocity, shot.rolling_time]).all()
    assert "still slides" in shot.notes[0]


def test_a_frame_off_the_path_spoils_neither_sliding_nor_rolling() -> None:
    for velocity, spin, until in (((2.0, 0.0), (0.0, -60.0), 0.35), ((1.2, 0.0), (0.0, 1.2 / RADIUS), 1.0)):
        seen = seen_from_above(struck(velocity, spin), until=until)
        y = seen.ball.y.copy()
        y[25] += 0.001
        shot = measure_shot(replace(seen, ball=replace(seen.ball, y=y)), RADIUS)
        assert shot.velocity == pytest.approx(velocity, abs=0.02)
        assert shot.frames == len(y) - 14  # those after the strike but one


def test_the_fit_ends_where_the_ball_meets_another() -> None:
    free = struck((1.8, 0.35), (-8.0, -30.0))

    def path(since: Places) -> Places:
        met = free(np.array([0.6]))
        return np.where(
            since[:, None] < 0.6, free(since), met + (since[:, None] - 0.6) * np.array([0.1, -0.5])
        )

    shot = measure_shot(seen_from_above(path), RADIUS)
    assert shot.meeting_time == pytest.approx(STRIKE + 0.6, abs=0.002)
    assert np.abs(pulls(shot, (1.8, 0.35), (-8.0, -30.0))).max() < 4


def test_a_ball_that_looks_larger_has_left_the_cloth() -> None:
    seen = seen_from_above(struck((1.8, 0.35), (-8.0, -30.0)))
    lift = 0.06 * np.exp(-(((seen.ball.time - 0.25) / 0.05) ** 2))
    shot = measure_shot(replace(seen, lift=lift), RADIUS)
    assert shot.jumps
    assert "jump shot" in shot.notes[-1]
    assert shot.doubts == shot.notes[-1:]


def test_uncertain_scale_makes_velocity_and_spin_uncertain() -> None:
    seen = seen_from_above(struck((1.8, 0.35), (-8.0, -30.0)))
    shot = measure_shot(seen, RADIUS, scale_sd=0.05)
    assert shot.velocity_sd[0] == pytest.approx(0.05 * 1.8, rel=0.01)
    assert shot.angular_velocity_sd[1] == pytest.approx(0.05 * 30, rel=0.01)


def test_a_ball_in_motion_from_the_start_is_no_shot() -> None:
    with pytest.raises(RecordingError, match="not seen at rest before the strike"):
        measure_shot(
            seen_from_above(lambda since: np.column_stack((since * 5 + np.arange(len(since)) / 60, since))),
            RADIUS,
        )


def test_a_few_frames_after_the_strike_are_too_few() -> None:
    with pytest.raises(RecordingError, match="moves freely in 5 frames only"):
        measure_shot(seen_from_above(struck((1.8, 0.35), (0.0, 0.0)), until=0.15), RADIUS)


@pytest.fixture(scope="module")
def small_shot(tmp_path_factory: pytest.TempPathFactory) -> tuple[ShotScene, ShotTrack]:
    """A small rendered shot, and what is tracked of it."""
    scene = ShotScene(
        velocity=(1.2, 0.2),
        angular_velocity=(-8.0, -10.0),
        cloth=CLOTH,
        start=(0.25, 0.25),
        duration=0.6,
        height_px=160,
        camera=Camera(fps=120, metres_per_pixel=0.0032, width_px=320, noise=2),
    )
    path = tmp_path_factory.mktemp("shot") / "small.mp4"
    write_shot(scene, path)
    return scene, track_shot(open_recording(path))


def test_a_rendered_shot_is_measured_from_rest_to_rolling(small_shot: tuple[ShotScene, ShotTrack]) -> None:
    scene, seen = small_shot
    shot = measure_shot(shot_to_metres(seen, scale_from_metres_per_pixel(0.0032)), RADIUS)
    assert shot.velocity == pytest.approx(scene.velocity, abs=0.012)
    assert shot.angular_velocity == pytest.approx(scene.angular_velocity, abs=1.3)
    assert shot.rolling_time == pytest.approx(shot_truth(scene)["roll_t"], abs=0.02)
    assert not shot.jumps


def test_the_cue_is_seen_coming(small_shot: tuple[ShotScene, ShotTrack]) -> None:
    scene, seen = small_shot
    tip = measure_shot(shot_to_metres(seen, scale_from_metres_per_pixel(0.0032)), RADIUS).tip
    assert tip is not None
    assert np.hypot(*tip.velocity) == pytest.approx(scene.cue_speed, abs=4 * np.hypot(*tip.velocity_sd))
    assert np.arctan2(*tip.velocity[::-1]) == pytest.approx(scene.cue_direction, abs=0.05)
    assert abs(tip.offset) < 0.15


def test_pixels_tell_the_same_spin_by_the_radius_of_the_ball(small_shot: tuple[ShotScene, ShotTrack]) -> None:
    scene, seen = small_shot
    shot = measure_shot(seen, RADIUS)
    assert shot.unit == "px"
    assert shot.velocity * 0.0032 == pytest.approx(scene.velocity, abs=0.012)
    assert np.abs(pulls(shot, np.array(scene.velocity) / 0.0032, scene.angular_velocity)[2:]).max() < 4


@pytest.mark.slow
@pytest.mark.parametrize("name", ["shot-draw", "shot-swerve"])
def test_shots_rendered_elsewhere_come_out(shared_data: Path, name: str) -> None:
    path = shared_data / "rendered" / "shots" / f"{name}.mp4"
    truth = json.loads(path.with_suffix(".json").read_text())
    seen = shot_to_metres(track_shot(open_recording(path)), scale_from_metres_per_pixel(0.0016))
    shot = measure_shot(seen, truth["ball_radius_m"])
    assert np.hypot(*(shot.velocity - truth["v"])) < 0.01 * np.hypot(*truth["v"])
    assert np.hypot(*(shot.angular_velocity - truth["w"])) < 0.1 * np.hypot(*truth["w"])
    assert np.abs(pulls(shot, truth["v"], truth["w"])).max() < 4
    assert shot.friction == pytest.approx(truth["mu"], rel=0.02)
    assert abs(shot.rolling_time - truth["roll_t"]) < 3 * shot.rolling_time_sd
    assert shot.tip is not None


@pytest.fixture(scope="module")
def club_shot(shared_data: Path) -> ShotTrack:
    """Track of the cue ball on the club table."""
    return track_shot(open_recording(shared_data / "real" / "cueball-club-table-25fps.mp4"))


@pytest.mark.slow
def test_the_white_ball_among_nine_is_struck_and_meets_another(club_shot: ShotTrack) -> None:
    shot = measure_shot(club_shot, RADIUS)
    ball = club_shot.ball
    assert np.array_equal(ball.frame, np.arange(122))
    speed = np.hypot(np.diff(ball.x), np.diff(ball.y)) * 25
    assert (ball.x[0], ball.y[0]) == pytest.approx((751.5, 270), abs=2)
    assert 9 / 25 < shot.strike_time < 15 / 25
    assert speed[14:20].mean() == pytest.approx(10.8 * 25, rel=0.05)
    assert np.all(np.diff(speed[15:55].reshape(8, 5).mean(axis=1)) < 0)
    assert 54 / 25 < shot.meeting_time < 58 / 25
    assert np.isnan(shot.friction)
    assert "four corners" in shot.notes[0]


@pytest.mark.slow
def test_four_corners_of_the_cloth_give_metres(club_shot: ShotTrack) -> None:
    shot = measure_shot(shot_to_metres(club_shot, scale_from_corners(CLOTH_CORNERS, 1.27, 2.54)), RADIUS)
    assert 0.6 < np.hypot(*shot.velocity) < 0.9
    assert 54 / 25 < shot.meeting_time < 58 / 25
    assert shot.place == pytest.approx((1.13, 0.95), abs=0.05)
    assert shot.tip is not None
    assert np.isnan(shot.tip.offset)
