"""Tracks made of numbers, for the tests."""

import numpy as np

from tracking.blob import Blob
from tracking.track import Track

RADIUS = 0.02
BALL = Blob(
    x=120,
    y=0,
    width=42,
    height=43,
    area=1420,
    hull=1420,
    contrast=78,
    ghost=False,
    colour=(120, 90, 190),
    at_border=False,
)
"""The patch of a ball of 20 px radius."""


def as_track(
    time: np.ndarray,
    height: np.ndarray,
    noise: float = 0.0,
    seed: int = 0,
    *,
    ball: str = "upper",
    least_sd: float = 1e-5,
) -> Track:
    """A ball at some heights, m, seen with normal noise."""
    sd = np.full(len(time), max(noise, least_sd))
    return Track(
        ball=ball,
        unit="m",
        frame=np.arange(len(time)),
        time=time,
        x=np.zeros(len(time)),
        y=height + noise * np.random.default_rng(seed).standard_normal(len(time)),
        x_sd=sd,
        y_sd=sd,
        arc=np.full(len(time), 2 * np.pi),
        radius=RADIUS,
        radius_sd=1e-5,
    )
