"""The compiled part of `limb_model`: levels along the rays of a circle, compared with the model.

Brightness and colour are looked at apart: recordings keep a quarter of the colour, so its edges are softer.
"""

import numpy as np
import numpy.typing as npt

from tracking.kernel import compiled, inlined, part

FloatArray = npt.NDArray[np.float64]
Image = npt.NDArray[np.uint8]
SingleArray = npt.NDArray[np.float32]
Four = tuple[np.float32, np.float32, np.float32, np.float32]
Ray = tuple[FloatArray, FloatArray, FloatArray]
Flags = npt.NDArray[np.bool_]
Room = tuple[npt.NDArray[np.int64], SingleArray, SingleArray]

COLOURS = 3
BRIGHTNESS, COLOUR = 0, 1  # kinds of levels: the second are two, and more blurred
LUMA = np.array((0.114, 0.587, 0.299), dtype=np.float32)  # shares of blue, green and red in brightness
SCALE = np.array((1.73, 1.02, 1.12), dtype=np.float32)  # squares add up as those of blue, green and red do
SHARPNESS = np.float32(-0.75)  # of cubic interpolation, as OpenCV has it
LEAST_LEFT = np.float32(1.0)
ZERO, ONE, TWO, THREE = np.arange(4, dtype=np.float32)  # of single precision, or all would be double
OUTER, INNER, SHARE, REST = 0, 1, 2, 4  # what the levels on a ray are multiplied with
TOGETHER = 8  # products that a processor adds up at once


@compiled
def compare(
    image: Image,
    rays: Ray,
    model: tuple[SingleArray, SingleArray, SingleArray],
    seen: tuple[FloatArray, FloatArray, FloatArray],
) -> None:
    """Compare the levels along the rays of one circle with the model, and write what is `seen`.

    Parameters
    ----------
    image : (height, width × 3) array
    rays : the circle (3,); offsets from it (samples,) and directions (rays, 2)
    model : factors, gram and lit of `limb_model`, of one way
    seen : information (2, rays, kinds, kinds), pull (2, rays, kinds) and variance (rays,), as `Look` has
        them; zeros and infinity on rays that leave the picture
    """
    factors, gram, lit = model
    information, pull, variance = seen
    inside, products, squares = _seen_along(image, rays, factors)
    count, light = len(inside), REST + 2 * pull.shape[2]
    brightest = np.zeros(COLOURS, dtype=np.float32)
    for ray in range(count):
        for colour in range(COLOURS):
            brightest[colour] += products[ray, colour, INNER] / np.float32(count)
    for ray in range(count):
        if inside[ray]:
            left = np.float32(0)
            for colour in range(COLOURS):
                own, shaded = products[ray, colour], lit[min(colour, COLOUR), ray]
                facing = own[INNER] * brightest[colour] / max(brightest[colour] ** 2, ONE)
                missing = own[INNER] * (ONE - min(max(facing, ZERO), ONE) ** 3)
                left += squares[ray, colour] + missing * (TWO * own[light] + missing * shaded[light])
                for row in range(light):
                    own[row] += missing * shaded[row]
                left -= own[SHARE] ** 2 + own[SHARE + 1] ** 2
            variance[ray] = max(left, LEAST_LEFT) / (COLOURS * (factors.shape[2] - 2))
            for kind in range(COLOUR + 1):
                some = products[ray, :COLOUR] if kind == BRIGHTNESS else products[ray, COLOUR:]
                _tell(some, gram[kind, ray], information[kind, ray], pull[kind, ray])


@part
def _seen_along(image: Image, rays: Ray, factors: SingleArray) -> tuple[Flags, SingleArray, SingleArray]:
    """Multiply the levels along all rays with factors: which rays lie inside, products, sums of squares."""
    _, count, samples, width = factors.shape
    inside = np.empty(count, dtype=np.bool_)
    products = np.zeros((count, COLOURS, width), dtype=np.float32)
    squares = np.zeros((count, COLOURS), dtype=np.float32)
    levels, line = _singly(image), np.empty((COLOURS, samples), dtype=np.float32)
    near, weights = np.empty(4 * COLOURS, dtype=np.float32), np.empty((8, samples), dtype=np.float32)
    room = np.empty((2, samples), dtype=np.int64), weights, near
    for ray in range(count):
        inside[ray] = _sample(levels, (rays[0], rays[1], rays[2][ray]), room, line)
        if not inside[ray]:
            continue
        _set_apart(line)
        for colour in range(COLOURS):
            own = factors[min(colour, COLOUR), ray]
            squares[ray, colour] = _multiply(line[colour], own, products[ray, colour])
    return inside, products, squares


@part
def _multiply(levels: SingleArray, factors: SingleArray, products: SingleArray) -> np.float32:
    """Add up levels (samples,) times factors (samples, products); return the sum of their squares."""
    squares = np.float32(0)
    for first in range(0, len(products), TOGETHER):
        some = products[first : first + TOGETHER]
        for sample in range(len(levels)):
            own = factors[sample, first : first + TOGETHER]
            for k in range(TOGETHER):
                some[k] += levels[sample] * own[k]
    for sample in range(len(levels)):
        squares += levels[sample] * levels[sample]
    return squares


@part
def _tell(products: SingleArray, gram: SingleArray, information: FloatArray, pull: FloatArray) -> None:
    """Write what one ray tells: sums over levels, and over the slopes of outer and inner level's shapes."""
    kinds = len(pull)
    for end in range(INNER + 1):
        for kind in range(kinds):
            pull[kind] += _both(products, end, REST + 2 * kind + end)
        for other in range(INNER + 1):
            pair = _both(products, end, other)
            for kind in range(kinds):
                for second in range(kinds):
                    information[kind, second] += pair * gram[2 * end + other, kinds * kind + second]


@inlined
def _both(products: SingleArray, one: int, other: int) -> np.float32:
    """Sum over levels of two products, multiplied."""
    total = np.float32(0)
    for level in range(len(products)):
        total += products[level, one] * products[level, other]
    return total


@part
def _singly(image: Image) -> SingleArray:
    """Give levels as numbers of single precision."""
    levels = np.empty(image.shape, dtype=np.float32)
    for row in range(len(image)):
        for k in range(image.shape[1]):
            levels[row, k] = image[row, k]
    return levels


@part
def _set_apart(line: SingleArray) -> None:
    """Turn blue, green and red into brightness and two colours: what blue and red have more than that."""
    blues, greens, reds = line[0], line[1], line[2]
    for k in range(len(blues)):
        blue, red = blues[k], reds[k]
        bright = LUMA[0] * blue + LUMA[1] * greens[k] + LUMA[2] * red
        blues[k] = SCALE[0] * bright
        greens[k] = SCALE[1] * (blue - bright)
        reds[k] = SCALE[2] * (red - bright)


@part
def _sample(levels: SingleArray, ray: Ray, room: Room, line: SingleArray) -> bool:
    """Interpolate levels (colours, samples) along a ray by cubic splines; false if it leaves the picture.

    A ray is a circle (3,), offsets from it (samples,) and a direction (2,). `room` is for the corners (2,
    samples) and weights (8, samples) of the neighbours of each place, and for four columns of them.
    """
    circle, offsets, direction = ray
    corners, weights, near = room
    height, width = levels.shape[0], levels.shape[1] // COLOURS
    for sample in range(len(offsets)):
        distance = circle[2] + offsets[sample]
        x, y = circle[0] + direction[0] * distance, circle[1] + direction[1] * distance
        if not (1 <= x < width - 2 and 1 <= y < height - 2):
            return False
        i, j = int(y), int(x)
        corners[0, sample], corners[1, sample] = i - 1, COLOURS * (j - 1)
        weights[0, sample], weights[1, sample], weights[2, sample], weights[3, sample] = _cubic(
            np.float32(y - i)
        )
        weights[4, sample], weights[5, sample], weights[6, sample], weights[7, sample] = _cubic(
            np.float32(x - j)
        )
    for sample in range(len(offsets)):
        row, left, right = corners[0, sample], corners[1, sample], corners[1, sample] + len(near)
        above, own = levels[row, left:right], levels[row + 1, left:right]
        below, last = levels[row + 2, left:right], levels[row + 3, left:right]
        a, b, c, d = weights[0, sample], weights[1, sample], weights[2, sample], weights[3, sample]
        for k in range(4 * COLOURS):  # all colours of four columns at once
            near[k] = a * above[k] + b * own[k] + c * below[k] + d * last[k]
        a, b, c, d = weights[4, sample], weights[5, sample], weights[6, sample], weights[7, sample]
        for colour in range(COLOURS):
            line[colour, sample] = (
                a * near[colour]
                + b * near[COLOURS + colour]
                + c * near[2 * COLOURS + colour]
                + d * near[3 * COLOURS + colour]
            )
    return True


@inlined
def _cubic(beyond: np.float32) -> Four:
    """Weigh four neighbours, two to each side of a place a little `beyond` the second."""
    rest = ONE - beyond
    first = SHARPNESS * beyond * rest * rest
    second = ((SHARPNESS + TWO) * beyond - (SHARPNESS + THREE)) * beyond * beyond + ONE
    third = ((SHARPNESS + TWO) * rest - (SHARPNESS + THREE)) * rest * rest + ONE
    return first, second, third, ONE - first - second - third
