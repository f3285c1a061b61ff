"""Strokes and letters of an overlay: each with a dark rim, sized for the picture."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil

import cv2
import numpy as np
import numpy.typing as npt

from tracking.video import Image

FloatArray = npt.NDArray[np.float64]
Colour = tuple[int, int, int]

LEAST_SIDE = 360  # px of the shorter side: smaller pictures are enlarged by a whole factor
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Brush:
    """How a picture is drawn upon: its whole-number enlargement, width of a stroke in px, size of letters."""

    zoom: int
    stroke: int
    letters: float

    @classmethod
    def for_picture(cls, shape: tuple[int, ...]) -> "Brush":
        """Fit the brush to a picture of this shape (rows, columns, ...)."""
        zoom = max(1, ceil(LEAST_SIDE / min(shape[:2])))
        shorter = zoom * min(shape[:2])
        return cls(zoom=zoom, stroke=max(1, round(shorter / 600)), letters=max(1.0, shorter / 540))

    def at(self, place: FloatArray) -> tuple[int, int]:
        """Give a place of the recording in fine units of the drawing."""
        fine = np.rint(((np.asarray(place) + 0.5) * self.zoom - 0.5) * 2**FINE_SHIFT).astype(int)
        return int(fine[0]), int(fine[1])


def enlarged(image: Image, brush: Brush) -> Image:
    """Copy a picture, enlarged, with even sides as video needs them (the last row and column repeat)."""
    rows, columns = (side * brush.zoom for side in image.shape[:2])
    large = cv2.resize(image, (columns, rows), interpolation=cv2.INTER_NEAREST)
    return np.asarray(
        cv2.copyMakeBorder(large, 0, rows % 2, 0, columns % 2, cv2.BORDER_REPLICATE), dtype=np.uint8
    )


def draw_circle(picture: Image, centre: FloatArray, radius: float, ball: int, brush: Brush) -> None:
    """Draw a ball's outline in its colour; a cross for what has no extent."""
    at, colour = brush.at(centre), BALL_COLOURS[ball % len(BALL_COLOURS)]
    if radius == 0:
        _cross(picture, at, 4 * brush.stroke, colour, brush)
        return
    size = round(radius * brush.zoom * 2**FINE_SHIFT)
    for stroke, shade in ((brush.stroke + 2, DARK), (brush.stroke, colour)):
        cv2.circle(picture, at, size, shade, stroke, cv2.LINE_AA, FINE_SHIFT)


def draw_trail(picture: Image, places: FloatArray, ball: int, brush: Brush) -> None:
    """Draw a dot where a ball was seen."""
    size = round(1.3 * brush.stroke * 2**FINE_SHIFT)
    for grown, shade in ((2**FINE_SHIFT, DARK), (0, BALL_COLOURS[ball % len(BALL_COLOURS)])):
        for place in places:
            cv2.circle(picture, brush.at(place), size + grown, shade, -1, cv2.LINE_AA, FINE_SHIFT)


def draw_curve(picture: Image, places: FloatArray, brush: Brush) -> None:
    """Draw a fitted path."""
    line = np.array([brush.at(place) for place in places], dtype=np.int32).reshape(-1, 1, 2)
    for stroke, shade in ((brush.stroke + 2, DARK), (brush.stroke, CURVE_COLOUR)):
        cv2.polylines(picture, [line], False, shade, stroke, cv2.LINE_AA, FINE_SHIFT)


def draw_moment(picture: Image, place: FloatArray, words: str, brush: Brush, *, ringed: bool) -> None:
    """Mark a place with a cross, and a ring while it happens, and say what happens there."""
    at = brush.at(place)
    if ringed:
        for stroke, shade in ((brush.stroke + 4, DARK), (brush.stroke + 2, MOMENT_COLOUR)):
            cv2.circle(picture, at, 14 * brush.stroke << FINE_SHIFT, shade, stroke, cv2.LINE_AA, FINE_SHIFT)
    _cross(picture, at, 7 * brush.stroke, MOMENT_COLOUR, brush)
    (width, _), _ = cv2.getTextSize(words, FONT, LETTER_SCALE * brush.letters, 1)
    column, row = (value >> FINE_SHIFT for value in at)
    beside = 17 * brush.stroke
    left = column + beside if column + beside + width < picture.shape[1] else column - beside - width
    _write(picture, words, (left, row - beside // 2), LETTER_SCALE * brush.letters, MOMENT_COLOUR)


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
    widest = max(cv2.getTextSize(text, FONT, scale, 1)[0][0] for text in texts)
    scale *= min(1.0, (picture.shape[1] - 2 * margin) / widest)
    height = 2 * round((rows * LINE_HEIGHT * brush.letters + margin) / 2)
    strip = np.zeros((height, picture.shape[1], 3), np.uint8)
    for number, line in enumerate(lines, start=1):
        _write(strip, line, (margin, round(number * LINE_HEIGHT * brush.letters)), scale, LIGHT)
    return np.vstack((picture, strip))


def _write(picture: Image, text: str, at: tuple[int, int], scale: float, colour: Colour) -> None:
    """Write light letters with a dark rim."""
    thickness = max(1, round(1.6 * scale))
    for stroke, shade in ((thickness + 3, DARK), (thickness, colour)):
        cv2.putText(picture, text, at, FONT, scale, shade, stroke, cv2.LINE_AA)


def _cross(picture: Image, at: tuple[int, int], half: int, colour: Colour, brush: Brush) -> None:
    """Draw a diagonal cross."""
    arm = half << FINE_SHIFT
    for stroke, shade in ((brush.stroke + 3, DARK), (brush.stroke + 1, colour)):
        for sign in (1, -1):
            ends = ((at[0] - arm, at[1] - sign * arm), (at[0] + arm, at[1] + sign * arm))
            cv2.line(picture, *ends, shade, stroke, cv2.LINE_AA, FINE_SHIFT)
