"""Rows of the trial table, as they are made of a trial and what was measured in it."""

from collections.abc import Sequence
from typing import Any

from calibrate.rows import VELOCITIES
from experiments.trial import Trial

DROPS = ("plate", "held", "two")


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
