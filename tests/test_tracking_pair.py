"""Two discs that meet: restitution along the line of centres, momentum as check."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from film_discs import film
from numpy.typing import NDArray

from tracking.errors import RecordingError
from tracking.pair import PairTrack, pair_to_metres, track_pair
from tracking.pair_impact import measure_pair
from tracking.scale import scale_from_metres_per_pixel
from tracking.track import Track
from tracking.video import open_recording

Places = NDArray[np.float64]
RADIUS, FPS, MOMENT = 0.016, 240, 0.2
NORMAL = np.array([0.96, -0.28])
FRICTION = 2.0  # m/s²


def leg(velocity: Places, since: Places) -> Places:
    """Displacement of a disc that slows to rest by dry friction."""
    speed = float(np.hypot(*velocity))
    if speed == 0:
        return np.zeros((len(since), 2))
    since = np.minimum(since, speed / FRICTION)
    return np.asarray(velocity * (since - FRICTION / (2 * speed) * since**2)[:, None])


def places(before: Places, after: Places, time: Places) -> Places:
    """Places of a disc that is at the origin at the impact."""
    since = (time - MOMENT)[:, None]
    return np.where(since < 0, leg(before, time - MOMENT), leg(after, np.maximum(time - MOMENT, 0)))


def impact(
    striker: Places, struck: Places, *, restitution: float = 0.9, masses: tuple[float, float] = (1.0, 1.0)
) -> tuple[Places, Places]:
    """Velocities after a smooth impact along NORMAL."""
    closing = (striker - struck) @ NORMAL
    impulse = (1 + restitution) * closing * masses[0] * masses[1] / sum(masses)
    return striker - impulse / masses[0] * NORMAL, struck + impulse / masses[1] * NORMAL


def as_track(ball: str, place: Places, time: Places, noise: float) -> Track:
    """Track with noise."""
    x, y = (place + np.random.default_rng(len(ball)).normal(0, noise, place.shape)).T
    return Track(
        ball=ball,
        unit="m",
        frame=np.arange(len(time)),
        time=time,
        x=x,
        y=y,
        x_sd=np.full(len(time), noise),
        y_sd=np.full(len(time), noise),
        arc=np.full(len(time), 6.0),
        radius=RADIUS,
        radius_sd=1e-5,
    )


def pair_seen(
    striker: Places, struck: Places, *, masses: tuple[float, float] = (1.0, 1.0), until: float = 0.4
) -> PairTrack:
    """Tracks of two discs that meet at MOMENT."""
    time = np.arange(0, until, 1 / FPS) + 0.0011
    after = impact(striker, struck, masses=masses)
    return PairTrack(
        striker=as_track("striker", places(striker, after[0], time), time, 5e-5),
        struck=as_track("struck", 2 * RADIUS * NORMAL + places(struck, after[1], time), time, 5e-5),
    )


SHOVED = np.array([1.3, -0.2])


@pytest.mark.parametrize("struck", [np.zeros(2), np.array([-0.6, 0.5])])
def test_restitution_and_velocities_come_out(struck: Places) -> None:
    seen = measure_pair(pair_seen(SHOVED, struck))
    truth = np.concatenate([SHOVED, impact(SHOVED, struck)[0], struck, impact(SHOVED, struck)[1]])
    found = np.concatenate([seen.striker_before, seen.striker_after, seen.struck_before, seen.struck_after])
    sd = np.sqrt(np.diag(seen.covariance))
    assert abs(seen.restitution - 0.9) < 4 * seen.restitution_sd < 0.05
    assert np.all(np.abs(found - truth) <= 4 * sd)
    assert abs(seen.time - MOMENT) < 0.0005
    assert seen.line_of_centres == pytest.approx(NORMAL, abs=0.01)


def test_discs_that_slide_without_friction_are_measured_as_well() -> None:
    time = np.arange(0, 0.4, 1 / FPS)
    since = (time - MOMENT)[:, None]
    striker, struck = impact(SHOVED, np.zeros(2))
    ways = [np.where(since < 0, SHOVED, striker) * since, np.where(since < 0, 0, struck) * since]
    tracks = [
        as_track(name, place + way, time, 5e-5)
        for name, place, way in zip(("striker", "struck"), ([0, 0], 2 * RADIUS * NORMAL), ways, strict=True)
    ]
    seen = measure_pair(PairTrack(striker=tracks[0], struck=tracks[1]))
    assert abs(seen.restitution - 0.9) < 4 * seen.restitution_sd < 0.05
    assert np.isfinite(seen.covariance).all()


def test_momentum_closes_with_the_right_masses_only() -> None:
    pair = pair_seen(SHOVED, np.zeros(2), masses=(1.0, 1.5))
    right, wrong = measure_pair(pair, masses=(1.0, 1.5)), measure_pair(pair)
    assert np.all(np.abs(right.momentum_gap) < 4 * right.momentum_gap_sd)
    assert abs(wrong.momentum_gap[0]) > 10 * wrong.momentum_gap_sd[0]


def test_pixels_and_metres_tell_the_same_restitution() -> None:
    pair = pair_seen(SHOVED, np.zeros(2))
    pixels = PairTrack(striker=in_pixels(pair.striker), struck=in_pixels(pair.struck))
    again = pair_to_metres(pixels, scale_from_metres_per_pixel(0.001))
    told = [measure_pair(p).restitution for p in (pair, pixels, again)]
    assert told == pytest.approx([told[0]] * 3, abs=1e-4)


def in_pixels(track: Track) -> Track:
    """Give a track in pixels of 1 mm, y down."""
    size = track.x_sd / 0.001
    return replace(
        track,
        unit="px",
        x=track.x / 0.001,
        y=-track.y / 0.001,
        x_sd=size,
        y_sd=size,
        radius=track.radius / 0.001,
    )


def test_too_few_frames_after_the_impact_are_said() -> None:
    with pytest.raises(RecordingError, match="striker disc is seen in free motion in 4 frames only after"):
        measure_pair(pair_seen(SHOVED, np.zeros(2), until=MOMENT + 4.5 / FPS))


def test_masses_must_be_positive() -> None:
    with pytest.raises(ValueError, match="masses must be positive"):
        measure_pair(pair_seen(SHOVED, np.zeros(2)), masses=(1.0, 0.0))


def test_two_filmed_discs_are_told_apart_and_measured(tmp_path: Path) -> None:
    time = np.arange(0.1, 0.3, 1 / FPS)
    after = impact(SHOVED, np.zeros(2))
    spots = [
        np.array([180, 80]) + places(SHOVED, after[0], time) / 0.00178 * [1, -1],
        np.array([180, 80]) + (2 * RADIUS * NORMAL + places(np.zeros(2), after[1], time)) / 0.00178 * [1, -1],
    ]
    pair = track_pair(open_recording(film(tmp_path / "pair.mp4", spots)))
    seen = measure_pair(pair)
    assert seen.restitution == pytest.approx(0.9, abs=0.03)
    assert seen.striker_before * 0.00178 == pytest.approx(SHOVED, abs=0.02)
    assert np.hypot(*seen.momentum_gap) < 0.03


def test_one_moving_disc_is_no_pair(tmp_path: Path) -> None:
    way = np.column_stack((np.linspace(40, 200, 40), np.full(40, 80.0)))
    with pytest.raises(RecordingError, match="only one disc moves"):
        track_pair(open_recording(film(tmp_path / "one.mp4", [way])))


def test_discs_that_pass_each_other_do_not_meet(tmp_path: Path) -> None:
    ways = [np.column_stack((np.linspace(40, 200, 40), np.full(40, y))) for y in (40.0, 120.0)]
    with pytest.raises(RecordingError, match="no two of the moving discs meet"):
        track_pair(open_recording(film(tmp_path / "pass.mp4", ways)))


@pytest.mark.slow
def test_carrom_discs_meet_almost_elastically(shared_data: Path) -> None:
    clip = shared_data / "real" / "carrom-headon-240fps-tagged-30.mp4"
    seen = measure_pair(track_pair(open_recording(clip, capture_fps=240)))
    assert 0.85 < seen.restitution < 0.98
    assert seen.restitution_sd < 0.02
    assert np.hypot(*seen.momentum_gap) < 0.04
    assert not np.any(seen.struck_before)
