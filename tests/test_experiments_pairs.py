"""Pairs of discs from recording to table: values, units, reasons."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from film_discs import RESTITUTION, SPEED, film_impact

from experiments import pairs
from experiments.measured import Measured
from experiments.trial import Body, Trial
from tracking.errors import RecordingError
from tracking.pair import PairTrack, track_pair
from tracking.video import open_recording


@pytest.fixture(scope="module")
def pair_seen(tmp_path_factory: pytest.TempPathFactory) -> PairTrack:
    return track_pair(open_recording(film_impact(tmp_path_factory.mktemp("pair") / "pair.mp4")))


def pair_of(seen: PairTrack, **told: Any) -> Measured:
    """Measure a pair that is tracked already."""
    measured = Measured(trial=Trial(name="pair", video=Path("pair.mp4"), kind="pair", **told))
    pairs.measure_seen(measured, seen)
    return measured


def test_a_pair_tells_restitution_and_velocities(pair_seen: PairTrack) -> None:
    measured = pair_of(pair_seen)
    (row,) = measured.rows
    assert (row["status"], row["unit"]) == ("ok", "px"), row["reason"]
    assert abs(row["restitution"] - RESTITUTION) < 4 * row["restitution_sd"] < 0.1
    assert np.hypot(row["momentum_gap_along"], row["momentum_gap_across"]) < 0.02
    assert row["striker_before_x"] == pytest.approx(SPEED * 240, rel=0.01)
    assert row["struck_after_x"] == pytest.approx(SPEED * 240 * (1 + RESTITUTION) / 2, rel=0.01)
    assert row["struck_before_x"] == 0
    assert any("restitution and momentum need no scale" in remark for remark in measured.remarks)


def test_the_diameter_of_a_disc_gives_metres(pair_seen: PairTrack) -> None:
    disc = Body(mass=0.015, diameter=0.032)
    measured = pair_of(pair_seen, bodies={"striker": disc, "struck": disc})
    (row,) = measured.rows
    assert row["unit"] == "m"
    assert row["striker_before_x"] == pytest.approx(SPEED * 240 * 0.016 / 9, rel=0.03)
    assert measured.remarks == [f"scale: striker ball, 32 mm wide, {2 * pair_seen.striker.radius:.1f} px"]


def test_momentum_that_does_not_close_is_suspect(pair_seen: PairTrack) -> None:
    (row,) = pair_of(pair_seen, bodies={"striker": Body(mass=1.0), "struck": Body(mass=3.0)}).rows
    assert row["status"] == "suspect"
    assert "momentum does not close" in row["reason"]
    assert "check the masses" in row["reason"]


def test_a_pair_cut_short_keeps_its_tracks_for_the_overlay(pair_seen: PairTrack) -> None:
    seen = PairTrack(**{name: until(getattr(pair_seen, name), 33) for name in ("striker", "struck")})
    measured = Measured(trial=Trial(name="pair", video=Path("pair.mp4"), kind="pair"))
    with pytest.raises(RecordingError, match="record more frames a second"):
        pairs.measure_seen(measured, seen)
    assert [track.ball for track in measured.tracks] == ["striker", "struck"]


def until(track: Any, frame: int) -> Any:
    """Cut a track off behind a frame."""
    arrays = ("frame", "time", "x", "y", "x_sd", "y_sd", "arc")
    return replace(track, **{name: getattr(track, name)[track.frame <= frame] for name in arrays})
