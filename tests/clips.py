"""Rendered recordings for the tests."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tracking.render import Camera, DropScene, write_recording

SMALL = Camera(width_px=200)


@dataclass(frozen=True)
class Clip:
    """A rendered recording, what was rendered, and what it shows."""

    path: Path
    scene: DropScene
    truth: dict[str, Any]


def film(scene: DropScene, path: Path, *, crf: int | None = 20) -> Clip:
    """Render a recording to `path`."""
    return Clip(path=path, scene=scene, truth=write_recording(scene, path, crf=crf))
