"""Contact frames: a normal and two tangents."""

from __future__ import annotations

import numpy as np

from impact._checks import Array


def tangent_frame(normal: Array) -> tuple[Array, Array, Array]:
    """Complete a unit normal to a frame with two unit tangents, each of shape (..., 3)."""
    helper = np.where(np.abs(normal[..., 2:3]) < 0.9, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    first = np.cross(helper, normal)
    first = first / np.linalg.norm(first, axis=-1, keepdims=True)
    return normal, first, np.cross(normal, first)
