"""The recording again with everything drawn on it: a film that a browser plays, and its contact sheet.

Frames are decoded, drawn and encoded one at a time. Text stands on a strip of its own below the picture.
"""

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

from tracking.contact_sheet import arrange, choose_frames, cut_out
from tracking.encode import write_video
from tracking.overlay import Overlay
from tracking.overlay_marks import (
    Brush,
    add_strip,
    draw_circle,
    draw_curve,
    draw_moment,
    draw_trail,
    resized,
    whole_brush,
)
from tracking.planes import Image
from tracking.video import Frame, Recording, read_frames

FASTEST_PLAY = 30.0  # pictures a second: faster recordings play in slow motion
LONGEST_TRAIL = 240  # sightings
FLASH_FRAMES = 1.5  # on each side of a moment, in which its place is ringed
QUALITY, PRESET = 23, "ultrafast"  # of x264: an overlay is looked at, not measured


def write_overlay(recording: Recording, overlay: Overlay, path: Path) -> Image | None:
    """Write the film to an MP4 file and give its contact sheet.

    Parameters
    ----------
    recording : as `open_recording` gives it
    overlay : Overlay
        In pixels of that recording.
    path : Path
        Of the film: one picture for each genuine frame, in slow motion if they were captured faster than
        `FASTEST_PLAY`.

    Returns
    -------
    image or None
        Frames around the first impacts; None if nothing was seen.
    """
    panels: list[Image] = []
    pictures = _film(recording, overlay, panels)
    rate = min(recording.capture_fps, FASTEST_PLAY)
    write_video(path, pictures, rate, crf=QUALITY, preset=PRESET, index_first=True)
    return arrange(panels)


def as_png(picture: Image) -> bytes:
    """Encode a picture as PNG."""
    return bytes(cv2.imencode(".png", picture)[1])


def _film(recording: Recording, overlay: Overlay, panels: list[Image]) -> Iterator[Image]:
    """Draw every frame; put those of the contact sheet into `panels` on the way."""
    brush = whole_brush(recording.size)
    last = recording.genuine.size, float(recording.times[-1])
    texts = [_stamp(*last), *(line for scene in overlay.scenes for line in scene.lines)]
    room = 1 + max(len(scene.lines) for scene in overlay.scenes), texts
    chosen = choose_frames(recording, overlay)
    flash = FLASH_FRAMES / recording.capture_fps
    for frame in read_frames(recording):
        if frame.index in chosen:
            panel, fine_brush = cut_out(frame.image, chosen[frame.index])
            _draw(panel, frame, overlay, fine_brush, flash)
            stamp = _stamp(frame.index, frame.time)
            panels.append(add_strip(panel, [stamp], fine_brush, (1, [stamp])))
        picture = resized(frame.image, brush)
        _draw(picture, frame, overlay, brush, flash)
        lines = _stamp(frame.index, frame.time), *overlay.scene_at(frame.time).lines
        yield add_strip(picture, lines, brush, room)


def _stamp(index: int, time: float) -> str:
    """Give number and time of a frame as text."""
    return f"frame {index}   t = {time:.4f} s"


def _draw(picture: Image, frame: Frame, overlay: Overlay, brush: Brush, flash: float) -> None:
    """Draw fitted paths, trails, outlines and moments; `flash` s around a moment its place is ringed."""
    scene = overlay.scene_at(frame.time)
    for curve in scene.curves:
        draw_curve(picture, curve, brush)
    for ball, outline in enumerate(overlay.outlines):
        past = outline.centre[outline.frame <= frame.index][-LONGEST_TRAIL:]
        draw_trail(picture, past, ball, brush)
        for seen in np.flatnonzero(outline.frame == frame.index):
            draw_circle(picture, outline.centre[seen], float(outline.radius[seen]), ball, brush)
    for moment in scene.moments:
        if frame.time >= moment.time - flash:
            ringed = abs(frame.time - moment.time) <= flash
            draw_moment(picture, moment.place, moment.words, brush, ringed=ringed)
