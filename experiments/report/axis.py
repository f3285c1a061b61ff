"""One axis of a drawing: from numbers to places, and the round numbers marked on it."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

ROOM = 0.06  # of the range, kept free at each end
FEWEST_TICKS = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class Axis:
    """Numbers from `low` to `high` lie from `start` to `end` in the drawing."""

    low: float
    high: float
    start: float
    end: float

    @property
    def span(self) -> float:
        """Numbers a step of the drawing, without sign."""
        return (self.high - self.low) / abs(self.end - self.start)

    def places(self, values: Array) -> Array:
        """Give the places of numbers."""
        share = (values - self.low) / (self.high - self.low)
        return np.asarray(self.start + share * (self.end - self.start))

    def ticks(self) -> list[tuple[float, str]]:
        """Give places and texts of round numbers within.

        Examples
        --------
        >>> [text for _, text in Axis(low=-0.013, high=0.27, start=0, end=100).ticks()]
        ['0', '0.05', '0.1', '0.15', '0.2', '0.25']
        """
        step = _round_step((self.high - self.low) / FEWEST_TICKS)
        first, last = math.ceil(self.low / step), math.floor(self.high / step)
        values = [number * step for number in range(first, last + 1)]
        return [(float(self.places(np.array(value))), f"{value:.10g}") for value in values]


def axis_around(values: Array, start: float, end: float) -> Axis:
    """Give an axis that holds all numbers, with some room around."""
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
    room = ROOM * (high - low) or ROOM * abs(high) or 1.0
    return Axis(low=low - room, high=high + room, start=start, end=end)


def widened(axis: Axis, span: float) -> Axis:
    """Give the axis with so many numbers a step, the middle kept."""
    middle, half = (axis.low + axis.high) / 2, span * abs(axis.end - axis.start) / 2
    return Axis(low=middle - half, high=middle + half, start=axis.start, end=axis.end)


def _round_step(most: float) -> float:
    """Give the largest of 1, 2, 5, 10, 20, … that is not above `most`."""
    power = 10.0 ** math.floor(math.log10(most))
    return max(power * factor for factor in (1, 2, 5) if power * factor <= most * (1 + 1e-9))
