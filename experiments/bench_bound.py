"""How well the centre of a ball can be known at all from one rendered picture: the Cramér-Rao bound."""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from tracking.render import DropScene
from tracking.render_stage import Stage, build_stage, expose

FloatArray = npt.NDArray[np.float64]

SHIFT_PX = 0.05  # by which the ball is moved to see what changes
ROUNDING = 1 / 6  # variance of two roundings to whole grey levels: the picture's and the noise's


def centre_bounds(scene: DropScene, frames: npt.NDArray[np.int64]) -> FloatArray:
    """Smallest standard deviations that any unbiased estimate of the upper ball's centre can have.

    Column and row of the centre are free; radius, colours, light, background and blur count as known, so no
    larger bound is true. With levels I of all pixels and colours and noise of variance s², the information
    about a place q = (x, y) is F = (dI/dq)ᵀ (dI/dq) / s², and the bound is the diagonal of F⁻¹ (Kay,
    *Fundamentals of Statistical Signal Processing: Estimation Theory*, 1993, section 3.9).

    Parameters
    ----------
    scene : DropScene
        Not compressed, without flicker.
    frames : (n,) array
        Numbers of the frames.

    Returns
    -------
    (n, 2) array
        Of x and y, px.
    """
    stage = build_stage(scene, np.random.default_rng(scene.seed))
    variance = scene.camera.noise**2 + ROUNDING
    bounds = [bound_of(slopes(stage, int(frame)), variance) for frame in frames]
    return np.array(bounds)


def bound_of(slope: FloatArray, variance: float) -> FloatArray:
    """Bounds on the standard deviations of parameters, (k,), from slopes (k, pixels) and noise."""
    information = slope @ slope.T / variance
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(information))))


def slopes(stage: Stage, frame: int) -> FloatArray:
    """How all levels of a picture change with the place of the upper ball: (2, pixels) levels a px."""
    return np.array([_moved(stage, frame, way) - _moved(stage, frame, -way) for way in np.eye(2)]) / (
        2 * SHIFT_PX
    )


def _moved(stage: Stage, frame: int, way: FloatArray) -> FloatArray:
    """Levels of a picture with its ball moved a little; shadow and mirror image stay."""
    ball, *others = stage.balls
    shifted = replace(ball, instants=ball.instants + SHIFT_PX * way)
    picture = np.empty_like(stage.wall)
    expose(replace(stage, balls=(shifted, *others)), frame, picture)
    return np.asarray(picture, dtype=np.float64).ravel()
