"""What is made of one recording: rows for the trial table, tracks, remarks, what to draw."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from calibrate.rows import VELOCITIES
from experiments.trial import Trial
from tracking.overlay import Outline, Overlay, Scene
from tracking.track import Track
from tracking.video import Recording

DROPS = ("plate", "held", "two")


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
    remarks : list of str
        For the person who made the recording.
    overlay : Overlay or None
        What to draw on the recording; None if no ball was found.
    recording : Recording or None
        The recording, until it is drawn upon: too large to pass from process to process.
    """

    trial: Trial
    rows: list[dict[str, Any]] = field(default_factory=list)
    tracks: list[Track] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    overlay: Overlay | None = None
    recording: Recording | None = None


def only_seen(*outlines: Outline) -> Overlay:
    """Give the overlay of what is seen but not measured yet: all there is to draw if measuring fails."""
    return Overlay(outlines=outlines, scenes=(Scene(lines=("no impact measured",)),))


def empty_row(trial: Trial) -> dict[str, Any]:
    """Write down what is known of a trial before it is measured."""
    upper, lower = (trial.body(name).mass if trial.kind in DROPS else None for name in ("upper", "lower"))
    velocities = {f"{name}{suffix}": None for name in VELOCITIES for suffix in ("", "_sd")}
    return {
        "trial": trial.name,
        "kind": trial.kind,
        "upper_mass": upper,
        "lower_mass": None if trial.kind == "plate" else lower,
        **velocities,
    }


def failed_row(trial: Trial, reason: str) -> dict[str, Any]:
    """Give the row of a trial that could not be measured."""
    return empty_row(trial) | {"status": "failed", "reason": reason, "impact": 1}


def judgement(reason: str) -> dict[str, str]:
    """Status and reason of an impact that was measured: suspect if there is a reason."""
    return {"status": "suspect" if reason else "ok", "reason": reason}


def cells(names: Sequence[str], values: Sequence[float], sd: Sequence[float]) -> dict[str, float]:
    """Put values and their standard deviations into the columns NAME and NAME_sd."""
    row: dict[str, float] = {}
    for name, value, deviation in zip(names, values, sd, strict=True):
        row |= {name: float(value), f"{name}_sd": float(deviation)}
    return row
