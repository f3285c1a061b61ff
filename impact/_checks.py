"""Rules for input values: each raises a `ValueError` that names the value, the rule and what was given."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


def require_within(name: str, value: float, low: float, high: float) -> None:
    """Demand ``low <= value <= high``."""
    if not low <= value <= high:
        raise ValueError(f"{name} must be within [{low:g}, {high:g}], got {value}")


def require_nonnegative(name: str, value: float) -> None:
    """Demand a finite value of zero or more."""
    if not 0.0 <= value < math.inf:
        raise ValueError(f"{name} must be zero or more, got {value}")


def require_positive(name: str, value: float) -> None:
    """Demand a finite value above zero."""
    if not 0.0 < value < math.inf:
        raise ValueError(f"{name} must be positive, got {value}")


def require_at_least(name: str, value: float, low: float) -> None:
    """Demand a finite value of `low` or more."""
    if not low <= value < math.inf:
        raise ValueError(f"{name} must be at least {low:g}, got {value}")


def require_finite(name: str, value: float) -> None:
    """Demand a number that is neither infinite nor NaN."""
    if not math.isfinite(value):
        raise ValueError(f"{name} must be finite, got {value}")


def as_array(name: str, value: Any, shape: tuple[int, ...]) -> Array:
    """Turn `value` into a read-only array of finite floats of the given shape."""
    array: Array = np.array(value, dtype=np.float64)
    if array.shape != shape:
        raise ValueError(f"{name} must have shape {shape}, got {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name} must be finite, got {array.tolist()}")
    array.flags.writeable = False
    return array
