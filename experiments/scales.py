"""How large a pixel of a trial's recording is."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from experiments.trial import Trial
from tracking.scale import (
    Scale,
    scale_from_corners,
    scale_from_metres_per_pixel,
    scale_from_points,
)

PIXELS = Scale(matrix=np.diag([1.0, -1.0, 1.0]), relative_sd=0.0, source="none: lengths stay in pixels")
"""Pixels with y up, as measurements without a scale give them."""


def told_scale(trial: Trial) -> Scale | None:
    """Scale that the experiment tells without a ball; None if there is none."""
    told = trial.camera.scale
    scale = _from_marks(told)
    return (
        replace(scale, relative_sd=float(told["relative_sd"])) if scale and "relative_sd" in told else scale
    )


def _from_marks(told: Mapping[str, Any]) -> Scale | None:
    """Scale from a number, points or corners; None where there are none."""
    if "metres_per_pixel" in told:
        return scale_from_metres_per_pixel(float(told["metres_per_pixel"]))
    if "points_px" in told:
        first, second = told["points_px"]
        return scale_from_points(first, second, float(told["distance"]))
    if "corners_px" in told:
        return scale_from_corners(told["corners_px"], float(told["width"]), float(told["height"]))
    return None
