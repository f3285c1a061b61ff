"""Two discs or balls that meet in free motion: recording → one row of the trial table."""

from dataclasses import replace
from typing import Any

import numpy as np

from experiments.doubt import find_pair_doubt
from experiments.measured import Fit, Measured, only_seen
from experiments.rows import cells, empty_row, judgement
from experiments.scales import PIXELS, told_scale
from experiments.trial import Trial
from tracking.overlay import Moment, Scene, outline_of
from tracking.pair import PairTrack, pair_to_metres, track_pair
from tracking.pair_impact import PairImpact, measure_pair
from tracking.scale import Scale, scale_from_ball, to_pixels
from tracking.shutter import with_row_times
from tracking.video import Recording

VELOCITIES = ("striker_before", "striker_after", "struck_before", "struck_after")


def measure_pair_trial(measured: Measured, recording: Recording) -> None:
    """Track, scale and fit the recording of two discs that meet."""
    found = track_pair(recording)
    measured.overlay = only_seen(outline_of(found.striker), outline_of(found.struck))
    readout = measured.trial.camera.row_time
    seen = PairTrack(
        striker=with_row_times(found.striker, recording, readout),
        struck=with_row_times(found.struck, recording, readout),
    )
    measured.overlay = replace(measured.overlay, scenes=(measure_seen(measured, seen),))


def measure_seen(measured: Measured, seen: PairTrack) -> Scene:
    """Scale and fit what is seen of two discs; give what the overlay tells of them."""
    scale = _scale(measured, seen)
    scaled = seen if scale is None else pair_to_metres(seen, scale)
    measured.tracks = [scaled.striker, scaled.struck]
    impact = measure_pair(scaled, masses=_masses(measured))
    scale_sd = 0.0 if scale is None else scale.relative_sd
    measured.rows = [_row(measured.trial, impact, scaled.striker.unit, scale_sd)]
    balls = (scaled.striker.ball,) * 2 + (scaled.struck.ball,) * 2
    measured.fits = [Fit(ball=ball, path=leg) for ball, leg in zip(balls, impact.fitted, strict=True)]
    return _scene(impact, scaled, scale or PIXELS)


def _scale(measured: Measured, seen: PairTrack) -> Scale | None:
    """Give the scale; None, with a remark, if nothing tells it."""
    trial = measured.trial
    diameter = trial.body("striker").diameter
    told = told_scale(trial)
    if told is not None:
        return told
    if diameter is not None:
        scale = scale_from_ball(seen.striker, diameter)
        measured.remarks.append(f"scale: {scale.source}")
        return scale
    measured.remarks.append(
        "velocities are in px/s, because nothing tells how large a pixel is; restitution and momentum need "
        "no scale, velocities need --ball-diameter or --metres-per-pixel"
    )
    return None


def _masses(measured: Measured) -> tuple[float, float]:
    """Masses of striker and struck disc; equal, with a remark, if one is not told."""
    striker, struck = (measured.trial.body(name).mass for name in ("striker", "struck"))
    if striker is None or struck is None:
        measured.remarks.append("the masses are not told, so they are taken as equal")
        return 1.0, 1.0
    return striker, struck


def _row(trial: Trial, impact: PairImpact, unit: str, scale_sd: float) -> dict[str, Any]:
    """One row of the trial table."""
    values = np.concatenate([getattr(impact, name) for name in VELOCITIES])
    sd = np.hypot(np.sqrt(np.diag(impact.covariance)), scale_sd * values)
    return {
        **empty_row(trial),
        **judgement(find_pair_doubt(impact)),
        "impact": 1,
        "time": impact.time,
        "time_sd": impact.time_sd,
        "unit": unit,
        **cells([f"{name}_{axis}" for name in VELOCITIES for axis in "xy"], list(values), list(sd)),
        **cells(["restitution"], [impact.restitution], [impact.restitution_sd]),
        **cells(
            ["momentum_gap_along", "momentum_gap_across"],
            list(impact.momentum_gap),
            list(impact.momentum_gap_sd),
        ),
        "frames": impact.frames,
        "residual": impact.residual,
    }


def _scene(impact: PairImpact, scaled: PairTrack, scale: Scale) -> Scene:
    """Tell the overlay the fitted paths, and the impact where the discs touch."""
    share = scaled.striker.radius / (scaled.striker.radius + scaled.struck.radius)
    touching = impact.places[0] + share * (impact.places[1] - impact.places[0])
    ends = np.repeat(impact.places, 2, axis=0)  # a disc's paths before and after end in its place
    curves = [
        np.vstack((place, leg[:, 1:]) if after else (leg[:, 1:], place))
        for leg, place, after in zip(impact.fitted, ends, (False, True) * 2, strict=True)
    ]
    moment = Moment(time=impact.time, place=to_pixels(scale, touching[np.newaxis])[0], words="impact")
    return Scene(
        lines=tuple(_lines(impact, scaled.striker.unit)),
        curves=tuple(to_pixels(scale, curve) for curve in curves),
        moments=(moment,),
    )


def _lines(impact: PairImpact, unit: str) -> list[str]:
    """Results in words."""
    places = 4 if unit == "m" else 0
    named = {name: ", ".join(f"{v:.{places}f}" for v in getattr(impact, name)) for name in VELOCITIES}
    return [
        f"impact at {impact.time:.4f} s",
        f"restitution {impact.restitution:.3f} +/- {impact.restitution_sd:.3f}, "
        f"momentum gap {np.hypot(*impact.momentum_gap):.1%}",
        f"striker ({named['striker_before']}) to ({named['striker_after']}) {unit}/s, x right, y up",
        f"struck ({named['struck_before']}) to ({named['struck_after']}) {unit}/s",
    ]
