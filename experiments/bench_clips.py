"""Freshly rendered recordings with known truth, tracked as a person would, for the bench of accuracy."""

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tracking.flight import Flight, flight_of_ball
from tracking.render import DropScene, ball_centres, write_recording
from tracking.scale import scale_from_metres_per_pixel, to_metres
from tracking.shutter import with_row_times
from tracking.track import Track, track_balls
from tracking.velocity import Impact, measure_impacts
from tracking.video import Recording, open_recording

FloatArray = npt.NDArray[np.float64]

PRESET = "medium"  # x264's own, to which its rate factor of 23 belongs
HELD = 0.05  # s after its release in which the hand may still cover part of the ball


@dataclass(frozen=True, slots=True, kw_only=True)
class Filmed:
    """A rendered recording: the scene, what it shows, the recording as read, and the ball as tracked (px)."""

    scene: DropScene
    truth: dict[str, Any]
    recording: Recording
    track: Track

    @property
    def flying(self) -> npt.NDArray[np.bool_]:
        """Frames in which the ball flies freely: out of the hand, and in no exposure that an impact is in."""
        camera, time = self.scene.camera, self.track.time
        impacts = np.array([event["t"] for event in self.truth["events"]])
        middle = time + camera.exposure / 2 + camera.readout / 2
        clear = np.abs(middle[:, None] - impacts).min(axis=1) > camera.exposure + camera.readout
        return np.asarray(clear & (time > self.truth["release_t"] + HELD))

    @property
    def errors(self) -> FloatArray:
        """How far the tracked centre is from where the ball is in the middle of the exposure, (n, 2) px."""
        middle = self.track.time + self.scene.camera.exposure / 2
        seen = np.column_stack((self.track.x, self.track.y))
        return (seen - ball_centres(self.scene, 0, middle))[self.flying]

    @property
    def sd(self) -> FloatArray:
        """Stated standard deviations of those errors, what frames share included, (n, 2) px."""
        own = np.column_stack((self.track.x_sd, self.track.y_sd))[self.flying]
        return np.asarray(np.sqrt(own**2 + self.track.shared_sd**2 + self.track.offset_sd**2))


def film(scene: DropScene, crf: int | None) -> Filmed:
    """Render a scene to a file, read it and track its ball; nothing is told to the tracker.

    Parameters
    ----------
    scene : DropScene
    crf : int or None
        Strength of x264's compression; None stores every level as it is.
    """
    with tempfile.TemporaryDirectory() as folder:
        clip = Path(folder) / "clip.mp4"
        truth = write_recording(scene, clip, crf=crf, preset=PRESET, tree=True)
        recording = open_recording(clip)
        (track,) = track_balls(recording)
        return Filmed(scene=scene, truth=truth, recording=recording, track=track)


def first_impact(filmed: Filmed, readout: float = 0.0) -> tuple[Impact, FloatArray]:
    """Measure the first impact of a filmed drop, scale and air told; and its true velocities, (2,) m/s.

    `readout` is the time in which the rows are read, s, as told to the tracker.
    """
    scene = filmed.scene
    timed = with_row_times(filmed.track, filmed.recording, readout)
    ball = to_metres(timed, scale_from_metres_per_pixel(scene.camera.metres_per_pixel))
    impact = measure_impacts(ball, flight_of(scene))[0]
    event = filmed.truth["events"][0]
    return impact, np.array([event["v0"][0], event["v1"][0]])


def flight_of(scene: DropScene) -> Flight:
    """How the ball of a scene flies."""
    return flight_of_ball(scene.masses[0], scene.radii[0], scene.air, scene.gravity)


def pulled(errors: Sequence[FloatArray], sds: Sequence[FloatArray]) -> float:
    """Mean square of errors over their standard deviations: 1 if these are true."""
    return float(np.mean((np.concatenate(errors) / np.concatenate(sds)) ** 2))


def root_mean_square(values: FloatArray) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))
