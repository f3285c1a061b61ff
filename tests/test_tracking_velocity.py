"""Velocities at an impact, from tracks made by the closed form of flight and from a rendered recording."""

from dataclasses import replace

import numpy as np
import pytest
from clips import Clip
from hypothesis import given, settings
from hypothesis import strategies as st
from tracks import RADIUS, as_track

from tracking.budget import Budget
from tracking.flight import Air, Flight, flight_of_ball, position
from tracking.scale import scale_from_metres_per_pixel, to_metres
from tracking.track import Track, track_balls
from tracking.velocity import Impact, measure_impacts, measure_two_ball_impact
from tracking.video import open_recording

BALL = flight_of_ball(0.0027, RADIUS, Air())


def bounce(
    approach: float, rebound: float, *, fps: float = 240, flight: Flight = BALL, at: float = 0.1501
) -> Track:
    """A fall to height RADIUS at the time `at`, and the rise from it."""
    time = np.arange(int(0.31 * fps) + 8) / fps
    velocity = np.where(time < at, approach, rebound)
    return as_track(time, RADIUS + position(flight, velocity, time - at))


def only(impacts: list[Impact]) -> Impact:
    (impact,) = impacts
    return impact


@settings(max_examples=10, deadline=None)
@given(st.floats(1.6, 4.0), st.floats(0.5, 0.98), st.sampled_from([60, 120, 240, 960]), st.floats(0, 1))
def test_velocities_of_a_perfect_track_are_exact(
    speed: float, restitution: float, fps: float, phase: float
) -> None:
    at = 0.15 + phase / fps
    impact = only(measure_impacts(bounce(-speed, restitution * speed, fps=fps, at=at), BALL))
    assert impact.velocities[:2] == pytest.approx([-speed, restitution * speed], rel=1e-4)
    assert impact.time == pytest.approx(at, abs=1e-6)
    assert impact.height == pytest.approx(RADIUS, abs=1e-5)
    assert impact.gravity_check == pytest.approx(1, abs=2e-3)


@pytest.mark.parametrize("fps", [60, 240])
def test_uncertainty_is_what_noise_does(fps: float) -> None:
    clean = bounce(-2.0, 1.7, fps=fps)
    impacts = [only(measure_impacts(as_track(clean.time, clean.y, 2e-4, seed), BALL)) for seed in range(20)]
    pulls = [(impact.velocities[:2] - (-2.0, 1.7)) / impact.sd[:2] for impact in impacts]
    assert 0.7 < np.std(pulls) < 1.25
    assert all(np.all(impact.sd[:2] > 0) for impact in impacts)


def test_uncertainty_shrinks_with_more_frames() -> None:
    slow, fast = (
        only(measure_impacts(as_track(clean.time, clean.y, 2e-4, 1), BALL))
        for clean in (bounce(-2.0, 1.7, fps=60), bounce(-2.0, 1.7, fps=960))
    )
    assert fast.sd[0] < 0.6 * slow.sd[0]


def test_errors_of_frames_alike_do_not_average_away() -> None:
    clean = bounce(-2.0, 1.7, fps=240)
    rng = np.random.default_rng(3)
    alike = np.exp(-np.abs(np.subtract.outer(clean.y, clean.y)) / RADIUS)
    pulls = []
    for bias in rng.multivariate_normal(np.zeros(len(clean.y)), 8e-5**2 * alike, size=20):
        track = as_track(clean.time, clean.y + bias, 2e-5, seed=1)
        impact = only(measure_impacts(replace(track, shared_sd=8e-5), BALL))
        pulls.append((impact.velocities[:2] - (-2.0, 1.7)) / impact.sd[:2])
    assert 0.6 < np.std(pulls) < 1.3


def test_each_shared_error_does_what_putting_it_in_does() -> None:
    track = bounce(-2.0, 1.7)
    budget = Budget(drag=0.1, scale=0.003, rate=0.002, gravity=0.0015, readout=0.001)
    told = only(measure_impacts(track, BALL, budget))
    changed = {
        "drag": (track, replace(BALL, terminal_speed=BALL.terminal_speed / 1.1**0.5)),
        "scale": (replace(track, y=1.003 * track.y), BALL),
        "rate": (replace(track, time=1.002 * track.time), BALL),
        "readout": (replace(track, time=track.time - 0.001 * track.y), BALL),
        "gravity": (track, flight_of_ball(0.0027, RADIUS, Air(), gravity=1.0015 * 9.80665)),
    }
    for source, (other, flight) in changed.items():
        moved = only(measure_impacts(other, flight)).velocities - told.velocities
        assert told.shared[source][:2] == pytest.approx(moved[:2], rel=0.1), source


def test_covariance_is_that_of_the_frames_and_of_all_they_share() -> None:
    track = bounce(-2.0, 1.7)
    frames = only(measure_impacts(track, BALL))
    told = only(measure_impacts(track, BALL, Budget(drag=0.1, scale=0.01)))
    added = sum(np.outer(effect[:2], effect[:2]) for effect in told.shared.values())
    assert told.covariance[:2, :2] == pytest.approx(frames.covariance[:2, :2] + added)
    assert told.gravity_check_sd == pytest.approx(np.hypot(frames.gravity_check_sd, 0.01), rel=0.1)


@pytest.mark.parametrize("share", [-0.1, 1.0, float("nan")])
def test_impossible_uncertainties_are_refused(share: float) -> None:
    with pytest.raises(ValueError, match=r"scale must be within \[0, 1\), got"):
        Budget(scale=share)


def test_neglected_air_reads_as_a_lower_restitution() -> None:
    impact = only(measure_impacts(bounce(-3.0, 2.4), Flight(gravity=9.80665)))
    assert -impact.velocities[1] / impact.velocities[0] < 0.79


@pytest.mark.parametrize("slower", [0.5, 2.0, 8.0])
def test_gravity_check_is_the_square_of_a_wrong_time_base(slower: float) -> None:
    vacuum = Flight(gravity=9.80665)
    track = bounce(-2.0, 1.7, flight=vacuum)
    impact = only(measure_impacts(replace(track, time=track.time * slower), vacuum))
    assert impact.gravity_check == pytest.approx(1 / slower**2, rel=0.02)


def test_gravity_check_is_proportional_to_a_wrong_scale() -> None:
    vacuum = Flight(gravity=9.80665)
    track = bounce(-2.0, 1.7, flight=vacuum)
    impact = only(measure_impacts(replace(track, y=1.3 * track.y), vacuum))
    assert impact.gravity_check == pytest.approx(1.3, rel=0.01)


def test_frames_that_straddle_the_impact_or_err_do_no_harm() -> None:
    track = bounce(-2.0, 1.7)
    wrong = track.y.copy()
    wrong[[20, 50]] += 0.004
    impact = only(measure_impacts(replace(track, y=wrong), BALL))
    assert impact.velocities[:2] == pytest.approx([-2.0, 1.7], rel=2e-3)


def test_missing_frames_are_no_hindrance() -> None:
    track = bounce(-2.0, 1.7)
    seen = np.delete(np.arange(len(track.time)), [22, 23, 30, 36, 37, 45])
    arrays = {name: getattr(track, name)[seen] for name in ("frame", "time", "x", "y", "x_sd", "y_sd", "arc")}
    impact = only(measure_impacts(replace(track, **arrays), BALL))
    assert impact.velocities[:2] == pytest.approx([-2.0, 1.7], rel=1e-3)


def test_ball_that_never_turns_has_no_impact() -> None:
    time = np.arange(60) / 240
    assert measure_impacts(as_track(time, 1 + position(BALL, 0.0, time)), BALL) == []
    assert measure_impacts(as_track(time, np.ones(60)), BALL) == []
    assert measure_impacts(as_track(time, 1 + 0.1 * time), BALL) == []


def test_film_that_ends_at_the_impact_has_none() -> None:
    track = bounce(-2.0, 1.7)
    end = int(np.argmin(track.y)) + 2
    arrays = {name: getattr(track, name)[:end] for name in ("frame", "time", "x", "y", "x_sd", "y_sd", "arc")}
    assert measure_impacts(replace(track, **arrays), BALL) == []


def test_sideways_velocity_is_told_before_and_after() -> None:
    track = bounce(-2.0, 1.7)
    sideways = np.where(track.time < 0.1501, 0.1, -0.3) * (track.time - 0.1501)
    assert only(measure_impacts(replace(track, x=sideways), BALL)).sideways == pytest.approx([0.1, -0.3])


@settings(max_examples=6, deadline=None)
@given(st.floats(2.0, 3.5), st.floats(0.6, 0.9), st.floats(0.08, 0.4))
def test_ball_that_is_hit_at_rest_gets_its_own_velocity(speed: float, upper: float, lower: float) -> None:
    top = bounce(-speed, upper * speed)
    struck = replace(top, y=top.y + 2 * RADIUS)
    hop = np.where(top.time < 0.1501, 0.0, position(BALL, lower * speed, np.maximum(top.time - 0.1501, 0)))
    rest = as_track(top.time, RADIUS + np.maximum(hop, 0.0), ball="lower")
    impact = measure_two_ball_impact(struck, rest, [BALL, BALL])
    assert impact is not None
    assert impact.velocities == pytest.approx(np.array([-speed, upper * speed, lower * speed]), rel=5e-3)
    assert np.all(np.isfinite(impact.sd))
    assert np.all(impact.sd > 0)


@pytest.mark.parametrize("misread", [[38], [37, 38], [39]])
def test_a_rim_misread_while_the_balls_touch_is_no_second_meeting(misread: list[int]) -> None:
    top = bounce(-2.0, 1.4)
    struck = replace(top, y=top.y + 2 * RADIUS)
    hop = np.where(top.time < 0.1501, 0.0, position(BALL, 0.7, np.maximum(top.time - 0.1501, 0)))
    height = RADIUS + np.maximum(hop, 0.0)
    height[misread] += 0.003
    impact = measure_two_ball_impact(struck, as_track(top.time, height, ball="lower"), [BALL, BALL])
    assert impact is not None
    assert impact.frames[1] > 20
    assert impact.velocities == pytest.approx(np.array([-2.0, 1.4, 0.7]), rel=0.01)


def test_single_ball_has_no_lower_velocity() -> None:
    impact = only(measure_impacts(bounce(-2.0, 1.7), BALL))
    assert np.isnan(impact.velocities[2])
    assert np.isnan(impact.sd[2])


def test_rendered_recording_gives_its_truth(plate_clip: Clip) -> None:
    (track,) = track_balls(open_recording(plate_clip.path))
    first, *_ = measure_impacts(to_metres(track, scale_from_metres_per_pixel(0.0008)), BALL)
    truth = plate_clip.truth["events"][0]
    assert first.velocities[:2] == pytest.approx([truth["v0"][0], truth["v1"][0]], rel=0.005)
    assert first.gravity_check == pytest.approx(1, abs=0.02)
    assert first.residual < 2e-4
    assert min(first.frames) > 20
