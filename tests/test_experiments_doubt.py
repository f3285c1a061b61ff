"""What makes an impact suspect, and the remedy that goes with it."""

from dataclasses import replace

import numpy as np
import pytest

from experiments.doubt import find_doubt, find_rest_doubt, find_size_doubt
from experiments.rates import likely_rate
from tracking.flight import Air, Flight, flight_of_ball, position
from tracking.track import Track
from tracking.velocity import Impact, measure_impacts

BALL = flight_of_ball(0.0027, 0.020, Air())
AT = 0.1501


def bounce(flight: Flight = BALL, sideways: float = 0.0) -> Track:
    """A fall and the rise from it, 240 frames a second, 0.1 mm of noise."""
    time = np.arange(82) / 240
    noise = 1e-4 * np.random.default_rng(6).standard_normal((2, len(time)))
    velocity = np.where(time < AT, -2.0, 1.7)
    fine = np.full(len(time), 1e-4)
    return Track(
        ball="upper",
        unit="m",
        frame=np.arange(len(time)),
        time=time,
        x=np.where(time < AT, 0.0, sideways) * (time - AT) + noise[0],
        y=0.02 + position(flight, velocity, time - AT) + noise[1],
        x_sd=fine,
        y_sd=fine,
        arc=np.full(len(time), 2 * np.pi),
        radius=0.02,
        radius_sd=1e-5,
    )


def first(track: Track, flight: Flight = BALL) -> Impact:
    return measure_impacts(track, flight)[0]


def test_a_good_impact_leaves_no_doubt() -> None:
    impact = first(bounce())
    assert find_doubt(impact, 240) == ""
    assert impact.free_velocities[:2] == pytest.approx([-2.0, 1.7], abs=3 * impact.free_sd[:2].max())
    assert impact.free_gravity == pytest.approx([9.6, 9.6], rel=0.1)


def test_a_model_the_frames_contradict_is_suspect() -> None:
    wrong = replace(BALL, gravity=0.9 * BALL.gravity)
    doubt = find_doubt(first(bounce(), wrong), 240)
    assert doubt.startswith("the frames by themselves tell -1.99")
    assert "check mass, scale and rate" in doubt


def test_a_hop_too_low_to_tell_is_no_fault_of_scale_or_rate() -> None:
    fall = first(bounce())
    hop = replace(fall, velocities=np.array([-2.0, 1.7, 0.05]), covariance=np.diag([1e-6, 1e-6, 0.3**2]))
    doubt = find_doubt(hop, 240)
    assert doubt.startswith(
        "the lower ball's velocity is known to ± 0.3 m/s only, for it hops low and briefly"
    )
    assert "(up to 6.2 mm, for 71 ms or 17.1 frames); record more frames a second, film it larger" in doubt
    assert find_doubt(replace(hop, covariance=np.diag([1e-6, 1e-6, 0.03**2])), 240) == ""


def test_a_ramp_into_slow_motion_is_suspect() -> None:
    track = bounce()
    ramp = replace(track, time=np.where(track.time < AT, track.time, AT + 2 * (track.time - AT)))
    doubt = find_doubt(first(ramp), 240)
    assert "the rate changes within the recording (a slow-motion ramp); export it at one rate" in doubt


def test_a_rebound_to_the_side_is_suspect() -> None:
    impact = first(bounce(sideways=0.6))
    assert impact.sideways == pytest.approx([0.0, 0.6], abs=0.02)
    assert find_doubt(impact, 240).startswith("the ball rebounds sideways (0.60 m/s), so the hit was not")


@pytest.mark.parametrize(("stored", "captured"), [(30, 240), (25, 100)])
def test_slow_motion_stored_as_ordinary_film_is_recognized(stored: int, captured: int) -> None:
    track = bounce()
    slow = replace(track, time=track.time * captured / stored)
    doubt = find_doubt(first(slow), stored, likely_rate(slow, BALL, stored))
    assert doubt.endswith(f"{captured} fps stored as {stored}; use --capture-fps {captured}")


def test_ball_that_seems_to_swell_is_doubted() -> None:
    def seen(change: float, tilt: float = 0.0) -> str:
        since = np.linspace(0, 1, 60)
        size = 20 * (1 + change * since + tilt * np.sin(9 * since) / 2)
        ones, frame = np.ones(60), np.arange(60)
        return find_size_doubt(
            Track(
                ball="upper",
                unit="px",
                frame=frame,
                time=frame / 240,
                x=100 * ones,
                y=100 + 40 * np.sin(9 * since),
                x_sd=0.05 * ones,
                y_sd=0.05 * ones,
                arc=6 * ones,
                radius=20.0,
                radius_sd=0.01,
                sizes=size + np.random.default_rng(3).normal(0, 0.05, 60),
            )
        )

    assert seen(0.02) == ""
    assert "size changes by" in seen(0.16)
    assert "background of another colour" in seen(0.16)
    assert seen(0.02, tilt=0.16) == ""
    assert "the camera is tilted too far; set it level" in seen(0.02, tilt=0.4)


@pytest.mark.parametrize(("hop", "moves"), [(0.0, False), (0.001, False), (0.004, True)])
def test_a_ball_that_moves_before_it_is_struck_is_not_at_rest(hop: float, moves: bool) -> None:
    impact = first(bounce())
    lower = replace(bounce(), ball="lower")
    lower = replace(lower, y=0.02 + hop * np.sin(40 * lower.time) ** 2)
    doubt = find_rest_doubt(lower, impact)
    rolls = find_rest_doubt(replace(lower, x=0.3 * lower.time), impact)
    assert "where it has to rest" in rolls
    assert ("where it has to rest" in doubt) == moves
    assert ("3.9 mm before the impact at 0.150 s" in doubt) == moves


def test_gravity_off_by_a_tenth_is_the_fault_of_a_size_that_is_not_seen() -> None:
    impact = replace(first(bounce()), gravity_check=1.12, gravity_check_sd=0.04)
    assert find_doubt(impact, 240) == ""
    assert find_doubt(replace(impact, gravity_check_sd=0.07), 240, unseen_scale=True) == ""
    slow = find_doubt(replace(impact, gravity_check=0.0157), 30, 240, unseen_scale=True)
    assert slow.endswith("this looks like 240 fps stored as 30; use --capture-fps 240")
    doubt = find_doubt(impact, 240, unseen_scale=True)
    assert doubt.startswith("fitted gravity is 10.98 m/s²: in many frames part of the ball's rim")
    assert "tell the scale" in doubt
    assert find_doubt(first(bounce()), 240, unseen_scale=True) == ""
