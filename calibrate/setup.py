"""How well a camera and a pair of hands measure one trial."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

_GRAVITY = 9.80665
_FEWEST_FRAMES = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """A stated set-up.

    Attributes
    ----------
    fps : float
        Frames captured a second.
    pixels : float
        Of the picture, along the fall.
    field_of_view : float
        Height of the picture, m.
    noise_px : float
        Standard deviation of a ball's place in one frame.
    heights : tuple of float
        Drop heights, m; trials are spread over them evenly.
    repeatability : float
        Relative scatter of rebound speeds from trial to trial that no camera removes (off-centre hits, spin).

    Raises
    ------
    ValueError
        If a value is not positive and finite, or the camera sees too few frames of a fall.
    """

    fps: float = 240.0
    pixels: float = 1080.0
    field_of_view: float = 1.0
    noise_px: float = 0.2
    heights: tuple[float, ...] = (0.3, 0.5, 0.7)
    repeatability: float = 0.02

    def __post_init__(self) -> None:
        for name in ("fps", "pixels", "field_of_view", "noise_px", "repeatability"):
            if not 0 < getattr(self, name) < math.inf:
                raise ValueError(f"{name} must be above zero and finite, got {getattr(self, name)}")
        if not self.heights:
            raise ValueError("heights must name at least one drop height, got none")
        for height in self.heights:
            if not 0 < height < math.inf:
                raise ValueError(f"height must be above zero and finite, got {height}")
            frames = self.fps * self._time_seen(math.sqrt(2 * _GRAVITY * height))
            if frames < _FEWEST_FRAMES:
                raise ValueError(
                    f"fps must show 3 frames of the fall from {height:g} m, got {frames:.1f} frames"
                )

    def rebound_scatter(self, rebounds: ArrayLike) -> NDArray[np.float64]:
        """Give the standard deviation of the ratios v1/|v0|, v2/|v0| of one average trial.

        Parameters
        ----------
        rebounds : array_like (2,)
            The ratios themselves.
        """
        return np.array([self._scatter(ratio) for ratio in np.asarray(rebounds, dtype=float).tolist()])

    def restitution_scatter(self, restitution: float) -> float:
        """Give the standard deviation of the restitution that one average drop shows."""
        return self._scatter(restitution)

    def _scatter(self, ratio: float) -> float:
        """Root mean square over the heights of what camera and hands contribute."""
        camera = [self._camera(ratio, math.sqrt(2 * _GRAVITY * height)) for height in self.heights]
        return math.hypot(*camera, math.sqrt(len(camera)) * self.repeatability * ratio) / math.sqrt(
            len(camera)
        )

    def _camera(self, ratio: float, speed: float) -> float:
        approach = self._velocity_sd(self._time_seen(speed))
        rebound = self._velocity_sd(2 * ratio * speed / _GRAVITY)
        return math.hypot(rebound, ratio * approach) / speed

    def _time_seen(self, speed: float) -> float:
        """Time in which a ball that ends a fall with this speed crosses the picture, s."""
        start = math.sqrt(max(speed**2 - 2 * _GRAVITY * self.field_of_view, 0.0))
        return (speed - start) / _GRAVITY

    def _velocity_sd(self, time: float) -> float:
        """Of the velocity at the end of a flight followed for a time, gravity known (slope of a line)."""
        frames = max(self.fps * time, _FEWEST_FRAMES)
        position = self.noise_px * self.field_of_view / self.pixels
        return position * math.sqrt(12 / frames) / max(time, _FEWEST_FRAMES / self.fps)
