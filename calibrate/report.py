"""How an `Estimate` and a `Calibration` print: the verdict first, values rounded by their uncertainty."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from calibrate.estimate import Calibration, Estimate
    from calibrate.intervals import Interval

_INDENT = "    "


def rounded(value: float, sd: float) -> str:
    """Value and standard deviation, both to the second digit of the latter.

    Examples
    --------
    >>> rounded(0.807755, 0.00751)
    '0.8078 ± 0.0075'
    >>> rounded(123.4, 25.2)
    '123 ± 25'
    """
    digits = _decimals(sd)
    return f"{value:.{digits}f} ± {sd:.{digits}f}"


def interval_text(interval: Interval) -> str:
    """One interval, its ends rounded by its width.

    Examples
    --------
    >>> interval_text((9.8132, 10.2409))
    '9.81 to 10.24'
    """
    low, high = interval
    digits = _decimals((high - low) / 4)
    return f"{low:.{digits}f} to {high:.{digits}f}"


def estimate_text(estimate: Estimate) -> str:
    """Verdict, value and 95 % set of an estimate in one line."""
    reach = " or ".join(interval_text(interval) for interval in estimate.intervals_95)
    if estimate.value is None:
        return f"{estimate.verdict} (95 %: {reach})"
    if estimate.sd is None:
        width = max(high - low for low, high in estimate.intervals_95)
        return f"{estimate.verdict}: best {estimate.value:.{_decimals(width / 4)}f} (95 %: {reach})"
    return f"{estimate.verdict}: {rounded(estimate.value, estimate.sd)} (95 %: {reach})"


def calibration_text(calibration: Calibration) -> str:
    """All of a calibration, a line a fact."""
    lines = [
        f"stiffness ratio k2/k1: {calibration.stiffness_ratio}{calibration.caveat}",
        f"restitution ball-ball e1: {calibration.restitution_ball_ball}",
        f"restitution ball-table e2: {calibration.restitution_ball_table}",
    ]
    lines += _pair_lines(calibration)
    if calibration.degrees_of_freedom > 0:
        freedom = calibration.degrees_of_freedom
        lines.append(f"fit: chi-square {calibration.chi_square:.1f} for {freedom} degrees of freedom")
    lines += [f"note: {note}" for note in calibration.notes]
    return "\n".join(lines)


def _pair_lines(calibration: Calibration) -> list[str]:
    lines = []
    for pair in calibration.pairs:
        measured = [rounded(value, sd) for value, sd in zip(pair.measured, pair.measured_sd, strict=True)]
        digits = [_decimals(sd) for sd in pair.measured_sd]
        fitted = [f"{value:.{places}f}" for value, places in zip(pair.fitted, digits, strict=True)]
        lines.append(
            f"mass ratio {pair.mass_ratio:.3g}, {_count(pair.trials)}, states {' '.join(pair.states)}"
        )
        lines += [
            f"{_INDENT}{name}/|v0|: measured {was}, fitted {is_now}"
            for name, was, is_now in zip(("v1", "v2"), measured, fitted, strict=True)
        ]
    return lines


def _count(trials: int) -> str:
    return "1 trial" if trials == 1 else f"{trials} trials"


def _decimals(uncertainty: float) -> int:
    """Decimal places that show two digits of an uncertainty."""
    if not uncertainty > 0:
        return 4
    leading = math.floor(math.log10(float(f"{uncertainty:.1e}")))
    return max(0, 1 - leading)
