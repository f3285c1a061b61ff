"""Which ball is struck: the one at rest that starts to move, or a sentence that says why none is."""

from pathlib import Path

import numpy as np
import pytest
from film_discs import film
from numpy.typing import NDArray

from tracking.errors import RecordingError
from tracking.strike import track_shot
from tracking.video import open_recording

FRAMES = np.arange(45)


def start_at(frame: int, place: tuple[float, float], step: tuple[float, float]) -> NDArray[np.float64]:
    """Places of a disc that rests until a frame and then goes on by a step each frame."""
    return np.array(place) + np.maximum(FRAMES - frame, 0)[:, None] * np.array(step)


def test_the_ball_that_starts_first_is_the_cue_ball(tmp_path: Path) -> None:
    clip = film(tmp_path / "a.mp4", [start_at(25, (200, 90), (2, 0.5)), start_at(10, (60, 60), (2.5, 0))])
    shot = track_shot(open_recording(clip))
    assert (shot.ball.x[0], shot.ball.y[0]) == pytest.approx((60, 60), abs=0.3)
    assert shot.ball.x[-1] == pytest.approx(60 + 2.5 * 34, abs=0.3)
    assert shot.ball.radius == pytest.approx(9, abs=0.3)
    assert np.abs(shot.lift).max() < 0.03
    assert shot.tip is None
    assert shot.missing_tip == "no cue is seen that comes straight to the ball"


def test_two_balls_that_start_together_must_be_told_apart(tmp_path: Path) -> None:
    clip = film(tmp_path / "b.mp4", [start_at(10, (60, 40), (2.5, 0)), start_at(11, (60, 120), (2, 0))])
    with pytest.raises(
        RecordingError, match=r"two balls start to move together, at \(60, 40\) and \(60, 120\)"
    ):
        track_shot(open_recording(clip))
    named = track_shot(open_recording(clip), start_px=(70, 115))
    assert named.ball.y[0] == pytest.approx(120, abs=0.3)
    with pytest.raises(RecordingError, match=r"near start_px \(200, 80\); those that do rest at"):
        track_shot(open_recording(clip), start_px=(200, 80))


def test_a_ball_that_moves_from_the_start_was_struck_before(tmp_path: Path) -> None:
    clip = film(tmp_path / "c.mp4", [start_at(-1, (40, 60), (2.5, 0))])
    with pytest.raises(RecordingError, match="no strike in the clip"):
        track_shot(open_recording(clip))


def test_balls_that_lie_still_are_no_shot(tmp_path: Path) -> None:
    clip = film(tmp_path / "d.mp4", [start_at(90, (40, 60), (0, 0)), start_at(90, (140, 60), (0, 0))])
    with pytest.raises(RecordingError, match="no ball found that starts to move"):
        track_shot(open_recording(clip))
