"""The lower ball of two: its hop ends at its landing, and its velocity is as sure as it states."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from clips import film
from hypothesis import given, settings
from hypothesis import strategies as st
from tracks import RADIUS, as_track

from tracking.flight import Air, flight_of_ball, position
from tracking.hop import low_hop
from tracking.render import Camera, DropScene
from tracking.scale import scale_from_metres_per_pixel, to_metres
from tracking.track import Track, track_balls
from tracking.velocity import Impact, measure_two_ball_impact
from tracking.video import open_recording

Film = tuple[Impact, list[float]]  # as measured, and the true velocities
AT = 0.1507
BALL = flight_of_ball(0.0046, RADIUS, Air())


def hops(time: np.ndarray, velocity: float, restitution: float = 0.85) -> np.ndarray:
    """Heights above rest of a ball struck at AT that hops on the plate, ever lower."""
    lift, start = np.zeros(len(time)), AT
    while velocity > 1e-3:
        lift = np.maximum(lift, np.where(time > start, position(BALL, velocity, time - start), 0.0))
        start, velocity = start + 2 * velocity / BALL.gravity, restitution * velocity
    return lift


def two_balls(
    hop: float, *, fps: float = 240, noise: float = 0.0, rebound: float = 1.5, seed: int = 0
) -> tuple[Track, Track]:
    """Tracks of a ball that falls at 2 m/s on one that then hops."""
    time = np.arange(int(0.31 * fps)) / fps
    fall = position(BALL, np.where(time < AT, -2.0, rebound), time - AT)
    return (
        as_track(time, 3 * RADIUS + fall, noise, seed, least_sd=1e-6),
        as_track(time, RADIUS + hops(time, hop), noise, seed + 1000, ball="lower", least_sd=1e-6),
    )


def measured(tracks: tuple[Track, Track]) -> Impact:
    impact = measure_two_ball_impact(*tracks, [BALL, BALL])
    assert impact is not None
    return impact


def filmed(folder: Path, hop: float, *, fps: float = 240, crf: int | None = 20, seed: int = 1) -> Film:
    """Film a ball that falls 0.1 m and measure; the lower ball starts with `hop`, as a share of its speed."""
    camera = Camera(fps=fps, width_px=100, metres_per_pixel=0.001, exposure=0.0008)
    scene = DropScene(
        kind="two",
        drop_height=0.1,
        masses=(0.0046, 0.0046),
        first_rebound=(0.8, hop),
        after=0.1,
        camera=camera,
        seed=seed,
    )
    clip = film(scene, folder / "two.mp4", crf=crf)
    scale = scale_from_metres_per_pixel(camera.metres_per_pixel)
    upper, lower = track_balls(open_recording(clip.path), radius=20.0, lower=1.0)
    event = clip.truth["events"][0]
    return measured((to_metres(upper, scale), to_metres(lower, scale))), [event["v0"][0], *event["v1"]]


@pytest.mark.parametrize("fps", [120, 240])
def test_ball_that_hops_a_third_of_a_millimetre_is_measured_within_its_uncertainty(
    tmp_path: Path, fps: float
) -> None:
    impact, truth = filmed(tmp_path, 0.058, fps=fps)
    assert abs(impact.velocities[2] - truth[2]) < 2 * impact.sd[2] < 0.06
    assert impact.velocities[:2] == pytest.approx(truth[:2], rel=3e-3)
    assert impact.gravity_check == pytest.approx(1, abs=0.01)
    assert np.isnan(impact.free_velocities[2])


@settings(max_examples=10, deadline=None)
@given(st.floats(0.03, 0.35), st.sampled_from([60, 120, 240, 1000]))
def test_only_the_first_hop_of_a_perfect_track_counts(hop: float, fps: float) -> None:
    impact = measured(two_balls(hop, fps=fps))
    assert abs(impact.velocities[2] - hop) < 2.5 * impact.sd[2] + 1e-3
    assert impact.gravity_check == pytest.approx(1, abs=2e-3)


@pytest.mark.parametrize(("fps", "hop"), [(40, 0.35), (120, 0.06), (240, 0.06), (1000, 0.06)])
def test_uncertainty_of_a_hop_is_what_noise_does(fps: float, hop: float) -> None:
    impacts = [measured(two_balls(hop, fps=fps, noise=3e-5, seed=seed)) for seed in range(10)]
    pulls = np.array([(impact.velocities[2] - hop) / impact.sd[2] for impact in impacts])
    assert np.sqrt(np.mean(pulls**2)) < 1.4
    assert max(impact.sd[2] for impact in impacts) < 0.02


def test_ball_that_stays_has_a_velocity_between_nothing_and_what_noise_hides() -> None:
    impact = measured(two_balls(0.0, noise=2e-5))
    assert 0 < impact.velocities[2] < 2.5 * impact.sd[2] < 0.05


def test_compression_that_hides_a_low_hop_makes_it_less_sure() -> None:
    _, lower = two_balls(0.06, noise=1e-5)
    clear, hidden = (low_hop(replace(lower, shared_sd=sd), AT, BALL) for sd in (0.0, 5e-5))
    assert clear is not None
    assert hidden is not None
    assert clear[1] < 0.3 * hidden[1]


def test_lower_ball_that_is_not_seen_after_the_impact_has_no_velocity() -> None:
    _, lower = two_balls(0.06)
    gone = {name: getattr(lower, name)[lower.time < AT] for name in ("frame", "time", "x", "y", "y_sd")}
    assert low_hop(replace(lower, **gone), AT, BALL) is None


def test_frames_after_the_balls_meet_again_are_no_flight() -> None:
    upper, lower = two_balls(0.35, rebound=0.36)
    again = AT + 0.0735  # the lower ball has landed, and stays; the upper one rises by a millimetre only
    rest = np.where(lower.time < again - 0.001, lower.y, RADIUS)
    kicked = upper.y + np.where(upper.time > again, 0.52 * (upper.time - again), 0.0)
    impact = measured((replace(upper, y=kicked), replace(lower, y=rest)))
    assert impact.velocities == pytest.approx([-2.0, 0.36, 0.35], abs=2e-3)
    assert upper.time[upper.time > AT][impact.frames[1] - 1] < again


@pytest.mark.slow
def test_low_hops_are_as_sure_as_they_state(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    pulls = []
    for number in range(30):
        hop, fps = rng.uniform(0.0, 0.15), (120, 240, 240, 480, 1000)[number % 5]
        impact, truth = filmed(tmp_path, hop, fps=fps, crf=(None, 18, 20, 23)[number % 4], seed=number)
        pulls.append((impact.velocities[2] - truth[2]) / impact.sd[2])
        assert impact.gravity_check == pytest.approx(1, abs=0.02)
    assert np.mean(np.abs(pulls) < 2) > 0.9
    assert np.sqrt(np.mean(np.square(pulls))) < 1.4
