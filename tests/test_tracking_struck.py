"""A struck ball is followed wherever it goes: not its mirror image, not the place that it left."""

from pathlib import Path

import numpy as np
import pytest
from clips import film

from tracking.flight import STANDARD_GRAVITY
from tracking.render import Camera, DropScene
from tracking.track import Track, track_balls
from tracking.video import open_recording

HEAVY = DropScene(  # at 120 frames a second the lower ball leaves by more than half its radius a frame
    kind="two",
    drop_height=0.3,
    masses=(0.012, 0.0046),
    radii=(0.019, 0.019),
    first_rebound=(1.6619 / 2.4112, 1.2729 / 2.4112),
    camera=Camera(fps=120, metres_per_pixel=0.0011, readout=0.006),
    seed=37,
)


@pytest.fixture(scope="module")
def struck(tmp_path_factory: pytest.TempPathFactory) -> tuple[list[Track], dict[str, list[float]]]:
    clip = film(HEAVY, Path(tmp_path_factory.mktemp("struck")) / "heavy.mp4")
    return track_balls(open_recording(clip.path), lower=1.0), clip.truth["events"][0]


def climb(track: Track, moment: float) -> float:
    """Upward speed at a moment by the first frames behind it, m/s."""
    behind = np.flatnonzero(track.time > moment + 1 / 120)[:4]
    slope = np.polyfit(track.time[behind], track.y[behind], 1)[0]
    return float(-slope * 0.0011 + STANDARD_GRAVITY * (track.time[behind].mean() - moment))


def test_heavy_ball_throws_the_lower_one_and_both_are_followed(
    struck: tuple[list[Track], dict[str, list[float]]],
) -> None:
    (upper, lower), event = struck
    moment, velocities = float(np.ravel(event["t"])[0]), event["v1"]
    assert climb(upper, moment) == pytest.approx(velocities[0], rel=0.05)
    assert climb(lower, moment) == pytest.approx(velocities[1], rel=0.05)


def test_balls_are_never_seen_within_each_other_nor_in_the_plate(
    struck: tuple[list[Track], dict[str, list[float]]],
) -> None:
    (upper, lower), _ = struck
    common, one, other = np.intersect1d(upper.frame, lower.frame, return_indices=True)
    assert len(common) > 30
    assert np.all(lower.y[other] - upper.y[one] > 0.9 * (upper.radius + lower.radius))
    assert np.all(lower.y < lower.y[0] + 0.15 * lower.radius)
