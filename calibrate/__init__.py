"""From velocities to restitution and stiffness ratio, with uncertainty and a verdict.

=======================  ===================================================================
`calibrate.trials`       the trial table: read, checked, written
`calibrate.repeats`      repeats of one measurement, their mean and spread
`calibrate.misfit`       how far model and measurements are apart
`calibrate.profile`      the profile likelihood over the stiffness ratio and its intervals
`calibrate.fit`          `fit_restitution` and `fit_stiffness_ratio`
`calibrate.shot_fit`     `fit_shot`: the contacts of cue shots
`calibrate.force_law`    linear, Hertz or between: whether the data can tell
`calibrate.speed`        restitution over speed; `calibrate.readings`: heights and bounce intervals
`calibrate.plan`         which experiment would tell candidate ratios apart
`calibrate.coverage`     whether confidence sets keep their promise
`calibrate.report`       how results print
=======================  ===================================================================
"""

from typing import TYPE_CHECKING, Any

from calibrate.rows import TrialTableError

if TYPE_CHECKING:
    from calibrate.estimate import Calibration, Estimate, MassPair
    from calibrate.fit import fit_restitution, fit_stiffness_ratio
    from calibrate.shot_fit import ShotCalibration, fit_shot
    from calibrate.trials import check_trials, read_trials, write_trials

__all__ = [
    "Calibration",
    "Estimate",
    "MassPair",
    "ShotCalibration",
    "TrialTableError",
    "check_trials",
    "fit_restitution",
    "fit_shot",
    "fit_stiffness_ratio",
    "read_trials",
    "write_trials",
]


def __getattr__(name: str) -> Any:
    """Load tables and fits when they are first asked for: who measures recordings needs neither."""
    if name in ("Calibration", "Estimate", "MassPair"):
        import calibrate.estimate as home
    elif name in ("fit_restitution", "fit_stiffness_ratio"):
        import calibrate.fit as home  # type: ignore[no-redef]
    elif name in ("ShotCalibration", "fit_shot"):
        import calibrate.shot_fit as home  # type: ignore[no-redef]
    elif name in ("check_trials", "read_trials", "write_trials"):
        import calibrate.trials as home  # type: ignore[no-redef]
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(home, name)
