"""What is made of one recording: rows for the trial table, tracks, remarks, what to draw."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from experiments.trial import Trial
from tracking.overlay import Outline, Overlay, Scene
from tracking.track import Track
from tracking.video import Recording


@dataclass(frozen=True, slots=True, kw_only=True)
class Fit:
    """What was fitted to a stretch of a ball's track: (n, 3) times (s) and places (x, y) in its unit."""

    ball: str
    path: npt.NDArray[np.float64]


@dataclass(slots=True, kw_only=True)
class Measured:
    """What became of one trial; filled step by step, so that a failure keeps what was found before it.

    Attributes
    ----------
    trial : Trial
    rows : list of dict
        For the trial table, one an impact.
    tracks : list of Track
        In metres, or in pixels where nothing tells the scale.
    fits : list of Fit
        What was fitted to the tracks.
    remarks : list of str
        For the person who made the recording.
    overlay : Overlay or None
        What to draw on the recording; None if no ball was found.
    recording : Recording or None
        The recording, for whoever draws upon it: without what is kept of its pictures, which is much.
    """

    trial: Trial
    rows: list[dict[str, Any]] = field(default_factory=list)
    tracks: list[Track] = field(default_factory=list)
    fits: list[Fit] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    overlay: Overlay | None = None
    recording: Recording | None = None


def only_seen(*outlines: Outline) -> Overlay:
    """Give the overlay of what is seen but not measured yet: all there is to draw if measuring fails."""
    return Overlay(outlines=outlines, scenes=(Scene(lines=("no impact measured",)),))
