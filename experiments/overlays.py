"""Overlays as files: a film with what was found drawn on it, and a sheet of its impacts."""

from pathlib import Path

from calibrate.files import write_whole, written_beside
from tracking.overlay import Overlay
from tracking.overlay_film import as_png, write_overlay
from tracking.video import Recording


def write_overlays(recording: Recording, overlay: Overlay, stem: Path) -> list[str]:
    """Write `stem`.mp4 and `stem`.png, each whole or not at all; a name may hold dots. Give the endings."""
    with written_beside(stem.with_name(f"{stem.name}.mp4")) as film:
        sheet = write_overlay(recording, overlay, film)
    if sheet is None:
        return ["mp4"]
    write_whole(stem.with_name(f"{stem.name}.png"), as_png(sheet))
    return ["mp4", "png"]
