"""The hand that lets the ball go, and the fingers that hold the lower ball."""

from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tracking.render_ball import Image
from tracking.render_scene import Colour
from tracking.render_wall import clouds

Joint = tuple[float, float, float]
"""A point of a limb and its half width."""

SKINS: tuple[Colour, ...] = ((122, 152, 205), (98, 130, 186), (70, 98, 150), (46, 66, 104))
"""Colours (blue, green, red) of the hands a seed can choose."""
FINGER = 0.0085
"""Half the width of a finger, m."""
OPENING_SPEED = 0.35
"""Speed at which thumb and finger part, m/s, for `OPENING_TIME`."""
OPENING_TIME = 0.05
LIFT = 9.0
"""Acceleration with which the hand then goes away, m/s²."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """One piece of a hand: colours, cover (0 to 1), and where its upper left pixel is from the ball, px."""

    picture: Image
    cover: Image
    corner: tuple[int, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class Hand:
    """Finger behind the ball, thumb before it, palm and arm before both; the unit vector to the arm."""

    finger: Part
    thumb: Part
    palm: Part
    away: NDArray[np.float64]
    pixels_per_metre: float


def make_hand(rng: np.random.Generator, skin: Colour, radius: float, scale: float) -> Hand:
    """Draw a hand that holds a ball of this radius (m) from above; `scale` is in pixels a metre."""
    lean = rng.uniform(0.1, 0.7) * rng.choice([-1, 1])
    turn = np.array([[np.cos(lean), -np.sin(lean)], [np.sin(lean), np.cos(lean)]])
    side = radius + 0.6 * FINGER

    def limb(*joints: Joint) -> Part:
        points = [(*(turn @ (x, y) * scale), width * scale) for x, y, width in joints]
        return _draw_limb(points, skin, rng)

    bent = 1.2 * side
    finger = limb((-side, 0.004, 0.85 * FINGER), (-bent, -0.025, FINGER), (-0.010, -0.058, 1.2 * FINGER))
    thumb = limb((side, 0.004, FINGER), (bent, -0.022, 1.1 * FINGER), (0.010, -0.058, 1.4 * FINGER))
    palm = limb((0.002, -0.062, 0.020), (0.0, -0.085, 0.032), (0.0, -0.125, 0.026), (0.0, -0.17, 0.028))
    return Hand(finger=finger, thumb=thumb, palm=palm, away=turn @ (0.0, -1.0), pixels_per_metre=scale)


def make_grip(rng: np.random.Generator, skin: Colour, radius: float, scale: float) -> tuple[Part, Part]:
    """Draw two fingers that hold a ball of this radius (m) from left and right."""
    side, width = (radius + 0.6 * FINGER) * scale, FINGER * scale
    bent, far = side + 3 * width, 0.3 * scale
    left = [(-side, 0.0, 0.9 * width), (-bent, 0.1 * width, width), (-far, -0.8 * width, 1.3 * width)]
    right = [(side, 0.0, 0.95 * width), (bent, 0.0, 1.1 * width), (far, -width, 1.4 * width)]
    return _draw_limb(left, skin, rng), _draw_limb(right, skin, rng)


def draw_part(image: Image, part: Part, place: ArrayLike) -> None:
    """Lay a part over the image, in place, where the ball it belongs to is at (x, y) in pixels."""
    left, top = np.rint(np.asarray(place)).astype(int) + part.corner
    height, width = part.cover.shape
    rows = slice(max(top, 0), min(top + height, image.shape[0]))
    columns = slice(max(left, 0), min(left + width, image.shape[1]))
    if rows.stop <= rows.start or columns.stop <= columns.start:
        return
    own = slice(rows.start - top, rows.stop - top), slice(columns.start - left, columns.stop - left)
    behind = image[rows, columns]
    cover = np.ascontiguousarray(part.cover[own])
    image[rows, columns] = cv2.blendLinear(part.picture[own], behind, cover, 1 - cover)


def hand_places(hand: Hand, since_release: float) -> tuple[NDArray[np.float64], ...]:
    """Shifts (x, y) of finger, thumb and palm in pixels, by the time since the ball was let go (s)."""
    moving = max(since_release, 0.0)
    aside = np.array([-hand.away[1], hand.away[0]])
    lift = hand.away * LIFT / 2 * moving**2
    opening = aside * OPENING_SPEED * min(moving, OPENING_TIME)
    return tuple(hand.pixels_per_metre * shift for shift in (lift - opening, lift + opening, lift))


def _draw_limb(points: list[Joint], skin: Colour, rng: np.random.Generator) -> Part:
    """Round limb through points (x, y, half width; px): a row of discs, lit from the upper left."""
    spots = np.array([(x, y) for x, y, _ in points])
    widest = max(width for _, _, width in points) + 4
    corner = np.floor(spots.min(axis=0) - widest).astype(int)
    columns, rows = np.ceil(spots.max(axis=0) + widest).astype(int) - corner
    mask = np.zeros((rows, columns), np.uint8)
    for start, end in pairwise(points):
        for x, y, width in np.linspace(start, end, 40):
            centre = (int(16 * (x - corner[0])), int(16 * (y - corner[1])))
            cv2.circle(mask, centre, int(16 * width), 255, -1, cv2.LINE_AA, 4)
    depth = cv2.distanceTransform((mask > 127).astype(np.uint8), cv2.DIST_L2, 3)
    relief = cv2.GaussianBlur(np.minimum(depth, 0.9 * widest), (0, 0), 2.0)
    slope = cv2.Sobel(relief, cv2.CV_32F, 1, 0) + 1.4 * cv2.Sobel(relief, cv2.CV_32F, 0, 1)
    light = 0.88 + 0.028 * np.clip(slope, -8, 8) + 0.02 * clouds(rng, (int(columns), int(rows)), (13, 5))
    cover = np.asarray(cv2.GaussianBlur(mask, (0, 0), 0.7) / 255, np.float32)
    return Part(
        picture=light[..., np.newaxis] * np.array(skin, np.float32),
        cover=cover,
        corner=(int(corner[0]), int(corner[1])),
    )
