"""How fits show in a notebook: small HTML tables."""

from __future__ import annotations

from typing import TYPE_CHECKING

from calibrate.report import interval_text, rounded
from impact.notebook import html_table

if TYPE_CHECKING:
    from calibrate.estimate import Calibration, Estimate
    from calibrate.shot_fit import ShotCalibration

HEADER = ("", "verdict", "value", "95 %")


def estimate_html(estimate: Estimate) -> str:
    """Verdict, value and 95 % set of one number."""
    return html_table("", [_row("", estimate)], HEADER)


def calibration_html(calibration: Calibration) -> str:
    """Verdict, value and 95 % set of each number, below them what the reader has to know."""
    rows = [
        _row("k₂/k₁", calibration.stiffness_ratio),
        _row("e₁, ball-ball", calibration.restitution_ball_ball),
        _row("e₂, ball-table", calibration.restitution_ball_table),
    ]
    return html_table(
        _goodness(calibration) + calibration.caveat, [*rows, *_notes(calibration.notes)], HEADER
    )


def shots_html(calibration: ShotCalibration) -> str:
    """Verdict, value and 95 % set of each parameter, and those that were held."""
    rows = [_row(name.replace("_", " "), estimate) for name, estimate in calibration.estimates.items()]
    rows += [(name.replace("_", " "), "fixed", f"{value:g}", "") for name, value in calibration.fixed.items()]
    return html_table(_goodness(calibration), [*rows, *_notes(calibration.notes)], HEADER)


def _goodness(calibration: Calibration | ShotCalibration) -> str:
    return f"chi-square {calibration.chi_square:.1f} for {calibration.degrees_of_freedom} degrees of freedom"


def _notes(notes: tuple[str, ...]) -> list[tuple[str, str]]:
    return [("note", note) for note in notes]


def _row(name: str, estimate: Estimate) -> tuple[str, str, str, str]:
    value = "" if estimate.value is None else f"{estimate.value:.4g}"
    if estimate.value is not None and estimate.sd is not None:
        value = rounded(estimate.value, estimate.sd)
    return name, estimate.verdict, value, " or ".join(map(interval_text, estimate.intervals_95))
