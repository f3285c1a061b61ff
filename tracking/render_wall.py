"""What stands still in a recording: the textured wall, the ruler, the plate; and the noise over all of it."""

import cv2
import numpy as np
from numpy.typing import NDArray

from tracking.render_ball import Image
from tracking.render_scene import Colour, DropScene

WALLS: tuple[Colour, ...] = (
    (128, 164, 134),  # sage paint
    (166, 146, 122),  # blue-grey paint
    (126, 138, 150),  # warm plaster
    (104, 118, 160),  # brick red
    (104, 100, 92),  # dark curtain
)
"""Mean colours (blue, green, red) of the walls a seed can choose."""
MARK = 0.010
"""Distance of the ruler's marks, m; every fifth is long."""
FONT = cv2.FONT_HERSHEY_SIMPLEX
TILE_MARGIN = 48
"""The noise tile is this much larger than the picture, so that it can be shifted from frame to frame."""


def clouds(rng: np.random.Generator, size: tuple[int, int], cells: tuple[int, ...]) -> Image:
    """Smooth random texture of about unit amplitude, shape (rows, columns): octaves of these cell sizes."""
    width, height = size
    texture = np.zeros((height, width), np.float32)
    for octave, cell in enumerate(cells):
        coarse = rng.standard_normal((height // cell + 2, width // cell + 2)).astype(np.float32)
        texture += cv2.resize(coarse, (width, height), interpolation=cv2.INTER_CUBIC) / (octave + 1)
    return texture


def paint_wall(scene: DropScene, rng: np.random.Generator) -> Image:
    """Wall, ruler and plate as a picture of grey levels, shape (rows, columns, 3)."""
    width, height = scene.size_px
    colour = np.array(WALLS[int(rng.integers(len(WALLS)))], np.float32)
    light = 1 + 0.035 * clouds(rng, (width, height), (90, 34, 11, 4))
    across, down = np.linspace(-1, 1, width, dtype=np.float32), np.linspace(-1, 1, height, dtype=np.float32)
    slope = rng.uniform(-0.10, 0.10, 2)
    light = light * (1 + slope[0] * across + slope[1] * down[:, np.newaxis])
    tint = 1 + 0.012 * clouds(rng, (width, height), (140, 60))
    wall = light[..., np.newaxis] * colour
    wall[..., 0] *= tint
    _draw_ruler(wall, scene, rng)
    _draw_plate(wall, scene, rng)
    vignette = 1 - 0.14 * (across**2 + down[:, np.newaxis] ** 2) / 2
    return np.asarray(wall * vignette[..., np.newaxis], np.float32)


def _draw_ruler(wall: Image, scene: DropScene, rng: np.random.Generator) -> None:
    """Stand a tape with marks and numbers on the plate, beside the path of the balls."""
    width, _ = scene.size_px
    scale = scene.camera.metres_per_pixel
    left = int(width * (0.12 if rng.random() < 0.5 else 0.80))
    strip = wall[: scene.floor_row, left : left + 26]
    strip[:] = np.array([170, 205, 214], np.float32) * (rng.uniform(0.72, 0.95) * strip.mean() / 130)
    ink = np.zeros(strip.shape[:2], np.uint8)
    for number in range(1, int(scene.floor_row * scale / MARK)):
        row = scene.floor_row - 0.5 - number * MARK / scale
        long = number % 5 == 0
        # sixteenths of a pixel, so that the marks keep their distance
        cv2.line(
            ink, (0, round(16 * row)), (16 * (15 if long else 8), round(16 * row)), 255, 1, cv2.LINE_AA, 4
        )
        if long:
            cv2.putText(ink, str(number), (3, round(row) - 3), FONT, 0.33, 255, 1, cv2.LINE_AA)
    strip *= 1 - (0.7 / 255) * ink[..., np.newaxis].astype(np.float32)


def _draw_plate(wall: Image, scene: DropScene, rng: np.random.Generator) -> None:
    """Plexiglass: the wall goes on below it, darker and mirrored a little, with a bright upper edge."""
    top = scene.floor_row
    rows = wall.shape[0] - top
    mirrored = wall[top - rows : top][::-1]
    colour = np.array([96, 84, 70], np.float32) * rng.uniform(0.8, 1.15)
    wall[top:] = 0.62 * colour + 0.25 * cv2.GaussianBlur(mirrored, (0, 0), 2.0)
    wall[top : top + 2] += np.array([26, 26, 24], np.float32)
    wall[-3:] *= 0.7


def noise_tiles(
    size: tuple[int, int], level: float, rng: np.random.Generator
) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Sensor noise to add and to subtract, larger than the picture by `TILE_MARGIN` each way."""
    width, height = size
    shape = (height + TILE_MARGIN, width + TILE_MARGIN, 3)
    noise = np.rint(level * rng.standard_normal(shape, dtype=np.float32))
    return np.maximum(noise, 0).astype(np.uint8), np.maximum(-noise, 0).astype(np.uint8)


def add_noise(
    picture: NDArray[np.uint8], tiles: tuple[NDArray[np.uint8], NDArray[np.uint8]], rng: np.random.Generator
) -> NDArray[np.uint8]:
    """Lay the noise tile at a random place over a picture, which is overwritten; the sum is a new array."""
    rows, columns = picture.shape[:2]
    down, right = rng.integers(TILE_MARGIN, size=2)
    more, less = (tile[down : down + rows, right : right + columns] for tile in tiles)
    cv2.add(picture, more, picture)
    return np.asarray(cv2.subtract(picture, less))
