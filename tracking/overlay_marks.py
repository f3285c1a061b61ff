"""Strokes and letters of an overlay: each with a dark rim, sized for the picture."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil

import cv2
import numpy as np
import numpy.typing as npt

from tracking.planes import Image

FloatArray = npt.NDArray[np.float64]
Colour = tuple[int, int, int]

LEAST_SIDE = 360  # px of the shorter side: smaller pictures are enlarged by a whole factor,
MOST_SIDE = 720  # ... larger ones made smaller, which take long to encode;
MOST_LENGTH = 1920  # ... and so are longer ones, which not every browser plays
FINE_SHIFT = 4  # bits of a pixel's fraction that OpenCV takes
BALL_COLOURS: tuple[Colour, ...] = ((0, 159, 230), (233, 180, 86), (167, 121, 204))
"""Orange, sky blue, reddish purple (blue, green, red)."""
CURVE_COLOUR: Colour = (255, 255, 255)
MOMENT_COLOUR: Colour = (66, 228, 240)
DARK: Colour = (0, 0, 0)
LIGHT: Colour = (255, 255, 255)
FONT = cv2.FONT_HERSHEY_SIMPLEX
LETTER_SCALE = 0.5  # of the font, for a picture LEAST_SIDE wide
LINE_HEIGHT = 20  # px, likewise
RING, CROSS = 13, 5  # radius of a ring and half the width of a cross, in strokes
SHADOW = tuple((x, y) for x in (-1, 0, 1) for y in (-1, 0, 1) if (x, y) != (0, 0))


@dataclass(frozen=True, slots=True, kw_only=True)
class Brush:
    """How a picture is drawn upon.

    Attributes
    ----------
    zoom : float
        Pixels of the drawing in one of the recording.
    corner : tuple of float
        Pixel (x, y) of the recording at the upper left of the drawing.
    stroke : int
        Width of a stroke, px of the drawing.
    letters : float
        Size of letters; 1 is for a small picture.
    """

    zoom: float
    corner: tuple[float, float] = (0.0, 0.0)
    stroke: int = 1
    letters: float = 1.0

    def fine(self, places: FloatArray) -> npt.NDArray[np.int32]:
        """Give places (..., 2) of the recording in fine units of the drawing."""
        pixels = (np.asarray(places) - self.corner + 0.5) * self.zoom - 0.5
        return np.asarray(np.rint(pixels * 2**FINE_SHIFT), dtype=np.int32)

    def at(self, place: FloatArray) -> tuple[int, int]:
        """Give one place in fine units of the drawing."""
        column, row = self.fine(place).tolist()
        return column, row


def whole_brush(shape: tuple[int, ...]) -> Brush:
    """Fit a brush to all of a picture of this shape (rows, columns, ...)."""
    side, length = sorted(shape[:2])
    most = min(MOST_SIDE / side, MOST_LENGTH / length)
    zoom = min(ceil(LEAST_SIDE / side), int(most)) if most >= 1 else most
    shorter = zoom * side
    return Brush(zoom=zoom, stroke=max(1, round(shorter / 600)), letters=max(1.0, shorter / 480))


def resized(image: Image, brush: Brush) -> Image:
    """Copy a whole picture at a brush's size, with even sides as video needs them.

    It is as wide as text needs; there is nothing to the right of a narrower one.
    """
    rows, columns = (round(side * brush.zoom) for side in image.shape[:2])
    method = cv2.INTER_NEAREST if brush.zoom >= 1 else cv2.INTER_LINEAR
    copy = cv2.resize(image, (columns, rows), interpolation=method)
    even = cv2.copyMakeBorder(copy, 0, rows % 2, 0, columns % 2, cv2.BORDER_REPLICATE)
    if even.shape[1] < LEAST_SIDE:
        beside = LEAST_SIDE - even.shape[1]
        even = cv2.copyMakeBorder(even, 0, 0, 0, beside, cv2.BORDER_CONSTANT, value=DARK)
    return np.asarray(even, dtype=np.uint8)


def draw_circle(picture: Image, centre: FloatArray, radius: float, ball: int, brush: Brush) -> None:
    """Draw a ball's outline in its colour; a cross for what has no extent."""
    at, colour = brush.at(centre), BALL_COLOURS[ball % len(BALL_COLOURS)]
    if radius == 0:
        _cross(picture, at, CROSS * brush.stroke, colour, brush)
        return
    size = round(radius * brush.zoom * 2**FINE_SHIFT)
    for stroke, shade in ((brush.stroke + 3, DARK), (brush.stroke + 1, colour)):
        cv2.circle(picture, at, size, shade, stroke, cv2.LINE_AA, FINE_SHIFT)


def draw_trail(picture: Image, places: FloatArray, ball: int, brush: Brush) -> None:
    """Draw a dot where a ball was seen."""
    size = round(1.8 * brush.stroke * 2**FINE_SHIFT)
    for grown, shade in ((2**FINE_SHIFT, DARK), (0, BALL_COLOURS[ball % len(BALL_COLOURS)])):
        for at in brush.fine(places).tolist():
            cv2.circle(picture, at, size + grown, shade, -1, cv2.LINE_AA, FINE_SHIFT)


def draw_curve(picture: Image, places: FloatArray, brush: Brush) -> None:
    """Draw a fitted path."""
    known = places[np.isfinite(places).all(axis=1)]
    line = brush.fine(known).reshape(-1, 1, 2)
    for stroke, shade in ((brush.stroke + 2, DARK), (brush.stroke, CURVE_COLOUR)):
        cv2.polylines(picture, [line], False, shade, stroke, cv2.LINE_AA, FINE_SHIFT)


def draw_moment(picture: Image, place: FloatArray, words: str, brush: Brush, *, ringed: bool) -> None:
    """Mark a place with a cross, and a ring while it happens, and say what happens there."""
    at, ring = brush.at(place), RING * brush.stroke
    _cross(picture, at, CROSS * brush.stroke, MOMENT_COLOUR, brush)
    if ringed:
        for stroke, shade in ((brush.stroke + 3, DARK), (brush.stroke + 1, MOMENT_COLOUR)):
            cv2.circle(picture, at, ring << FINE_SHIFT, shade, stroke, cv2.LINE_AA, FINE_SHIFT)
    scale = LETTER_SCALE * brush.letters
    (width, _), _ = cv2.getTextSize(words, FONT, scale, _thickness(scale))
    column, row = (value >> FINE_SHIFT for value in at)
    left = column + ring if column + ring + width < picture.shape[1] else column - ring - width
    _write(picture, words, (left, row - ring), scale, MOMENT_COLOUR)


def add_strip(picture: Image, lines: Sequence[str], brush: Brush, room: tuple[int, Sequence[str]]) -> Image:
    """Put lines of text on a dark strip below the picture.

    Parameters
    ----------
    picture, lines, brush : what to put where
    room : int and sequence of str
        How many lines the strip has room for, and all the lines it must have width for.
    """
    rows, texts = room
    margin, scale = round(8 * brush.letters), LETTER_SCALE * brush.letters
    widest = max(cv2.getTextSize(text, FONT, scale, _thickness(scale))[0][0] for text in texts)
    scale *= min(1.0, (picture.shape[1] - 2 * margin) / widest)
    height = 2 * round((rows * LINE_HEIGHT * brush.letters + margin) / 2)
    strip = np.zeros((height, picture.shape[1], 3), np.uint8)
    for number, line in enumerate(lines, start=1):
        _write(strip, line, (margin, round(number * LINE_HEIGHT * brush.letters)), scale, LIGHT)
    return np.vstack((picture, strip))


def _write(picture: Image, text: str, at: tuple[int, int], scale: float, colour: Colour) -> None:
    """Write letters on a dark shadow all around, which is thick letters no font gives."""
    thickness = _thickness(scale)
    for step in SHADOW:
        shifted = at[0] + step[0] * thickness, at[1] + step[1] * thickness
        cv2.putText(picture, text, shifted, FONT, scale, DARK, thickness, cv2.LINE_AA)
    cv2.putText(picture, text, at, FONT, scale, colour, thickness, cv2.LINE_AA)


def _thickness(scale: float) -> int:
    """Width of the strokes of letters, px."""
    return max(1, round(1.6 * scale))


def _cross(picture: Image, at: tuple[int, int], half: int, colour: Colour, brush: Brush) -> None:
    """Draw a diagonal cross."""
    arm = half << FINE_SHIFT
    for stroke, shade in ((brush.stroke + 3, DARK), (brush.stroke + 1, colour)):
        for sign in (1, -1):
            ends = ((at[0] - arm, at[1] - sign * arm), (at[0] + arm, at[1] + sign * arm))
            cv2.line(picture, *ends, shade, stroke, cv2.LINE_AA, FINE_SHIFT)
