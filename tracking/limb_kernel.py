"""The compiled part of `limb_model`: levels along the rays of a circle, compared with the model.

Brightness and colour are looked at apart: recordings keep a quarter of the colour, so its edges are softer.
"""

import numpy as np
import numpy.typing as npt

from tracking.kernel import compiled, inlined, part
from tracking.single import patch_levels

FloatArray = npt.NDArray[np.float64]
LongArray = npt.NDArray[np.int64]
Image = npt.NDArray[np.uint8]
SingleArray = npt.NDArray[np.float32]
Four = tuple[np.float32, np.float32, np.float32, np.float32]
Ray = tuple[FloatArray, FloatArray, FloatArray]
Flags = npt.NDArray[np.bool_]
Room = tuple[LongArray, SingleArray, SingleArray]

COLOURS = 3
COLOUR = 1  # brightness and colour are kinds of levels: the second are two, and more blurred
LUMA = np.array((0.114, 0.587, 0.299), dtype=np.float32)  # shares of blue, green and red in brightness
SCALE = np.array((1.73, 1.02, 1.12), dtype=np.float32)  # squares add up as those of blue, green and red do
SHARPNESS = np.float32(-0.75)  # of cubic interpolation, as OpenCV has it
LEAST_LEFT = np.float32(1.0)
ZERO, ONE, TWO, THREE = np.arange(4, dtype=np.float32)  # of single precision, or all would be double
OUTER, INNER, SHARE, REST = 0, 1, 2, 4  # what the levels on a ray are multiplied with


@compiled
def compare_all(
    pictures: tuple[Image, LongArray],
    circles: FloatArray,
    expected: tuple[LongArray, FloatArray, FloatArray, SingleArray, SingleArray, SingleArray],
    seen: tuple[FloatArray, FloatArray, FloatArray],
    part_of: tuple[int, int],
) -> None:
    """Compare the levels along the rays of a circle in each picture with the model, and write what is `seen`.

    Parameters
    ----------
    pictures : levels and places of `Patches`
    circles : (n, 3) array
    expected : as `Expected` of `limb_model` has it, and directions (rays, 2) before its offsets
    seen : information (n, 2, rays, kinds, kinds), pull (n, 2, rays, kinds) and variance (n, rays)
        Zeros and infinity, as they stay on rays that leave the picture.
    part_of : number of the first picture, and of pictures to the next
    """
    way_of, directions, offsets, factors, gram, lit = expected
    information, pull, variance = seen
    circle = np.empty(3)
    for k in range(part_of[0], len(circles), part_of[1]):
        levels, left, top = patch_levels(pictures, k)
        circle[0], circle[1], circle[2] = circles[k, 0] - left, circles[k, 1] - top, circles[k, 2]
        way = way_of[k]
        rays, model = (circle, offsets[way], directions), (factors[way], gram[way], lit[way])
        _compare(levels, rays, model, (information[k], pull[k], variance[k]))


@part
def _compare(
    levels: SingleArray,
    rays: Ray,
    model: tuple[SingleArray, SingleArray, SingleArray],
    seen: tuple[FloatArray, FloatArray, FloatArray],
) -> None:
    """Do so in one picture (height, width, 3), with the model of one way.

    All rays are gone through at once, one product of each at a time: a processor multiplies many of a kind.
    """
    factors, gram, lit = model
    information, pull, variance = seen
    inside, lines = _levels_along(levels, rays, factors.shape[1])
    count, light = len(inside), REST + 2 * pull.shape[2]
    left, missing = np.zeros(count, dtype=np.float32), np.empty(count, dtype=np.float32)
    products = np.empty((factors.shape[2], count), dtype=np.float32)
    for colour in range(COLOURS):
        kind = min(colour, COLOUR)
        shaded = lit[kind]
        _multiply(lines[colour], factors[kind], products, left)
        _darken(products[INNER], missing)
        for ray in range(count):
            left[ray] += missing[ray] * (TWO * products[light, ray] + missing[ray] * shaded[light, ray])
        for row in range(light):
            for ray in range(count):
                products[row, ray] += missing[ray] * shaded[row, ray]
        for ray in range(count):
            left[ray] -= products[SHARE, ray] ** 2 + products[SHARE + 1, ray] ** 2
        _tell(products, gram[kind], information[kind], pull[kind])
    for ray in range(count):
        if inside[ray]:
            variance[ray] = max(left[ray], LEAST_LEFT) / (COLOURS * (factors.shape[1] - 2))


@part
def _levels_along(levels: SingleArray, rays: Ray, samples: int) -> tuple[Flags, SingleArray]:
    """Levels (colours, samples, rays): nothing on rays that leave the picture; and which do not."""
    circle, offsets, directions = rays
    inside = np.empty(len(directions), dtype=np.bool_)
    lines = np.zeros((COLOURS, samples, len(directions)), dtype=np.float32)
    pixels = levels.reshape((len(levels), -1))
    weights, near = np.empty((8, samples), dtype=np.float32), np.empty(4 * COLOURS, dtype=np.float32)
    room = np.empty((2, samples), dtype=np.int64), weights, near
    for ray in range(len(directions)):
        inside[ray] = _sample(pixels, (circle, offsets, directions[ray]), room, lines[:, :, ray])
    blues, greens, reds = lines[0].reshape(-1), lines[1].reshape(-1), lines[2].reshape(-1)
    for k in range(len(blues)):  # brightness, and what blue and red have more than that
        blue, red = blues[k], reds[k]
        bright = LUMA[0] * blue + LUMA[1] * greens[k] + LUMA[2] * red
        blues[k] = SCALE[0] * bright
        greens[k] = SCALE[1] * (blue - bright)
        reds[k] = SCALE[2] * (red - bright)
    return inside, lines


@part
def _multiply(levels: SingleArray, factors: SingleArray, products: SingleArray, squares: SingleArray) -> None:
    """Add up levels (samples, rays) times factors (samples, products, rays), and add their squares."""
    products[:] = ZERO
    for sample in range(len(levels)):
        line = levels[sample]
        for row in range(len(products)):
            own, sums = factors[sample, row], products[row]
            for ray in range(len(line)):
                sums[ray] += line[ray] * own[ray]
        for ray in range(len(line)):
            squares[ray] += line[ray] * line[ray]


@part
def _darken(inner: SingleArray, missing: SingleArray) -> None:
    """Tell what light the inner level of each ray lacks: what is darker faces away from the lamp."""
    brightest = np.float32(0)
    for ray in range(len(inner)):
        brightest += inner[ray] / np.float32(len(inner))
    share = brightest / max(brightest * brightest, ONE)
    for ray in range(len(inner)):
        facing = min(max(inner[ray] * share, ZERO), ONE)
        missing[ray] = inner[ray] * (ONE - facing * facing * facing)


@part
def _tell(products: SingleArray, gram: SingleArray, information: FloatArray, pull: FloatArray) -> None:
    """Add what one colour tells: sums over the slopes of outer and inner level's shapes."""
    count, kinds = pull.shape
    for ray in range(count):
        outer, inner = products[OUTER, ray], products[INNER, ray]
        squared, mixed, inmost = outer * outer, outer * inner, inner * inner
        for kind in range(kinds):
            row = REST + 2 * kind
            pull[ray, kind] += outer * products[row, ray] + inner * products[row + 1, ray]
            for other in range(kinds):
                pair = gram[kinds * kind + other]
                information[ray, kind, other] += (
                    squared * pair[0, ray] + mixed * pair[1, ray] + inmost * pair[2, ray]
                )


@part
def _sample(levels: SingleArray, ray: Ray, room: Room, line: SingleArray) -> bool:
    """Interpolate levels (colours, samples) along a ray by cubic splines; false if it leaves the picture.

    A ray is a circle (3,), offsets from it (samples,) and a direction (2,). `room` is for the corners (2,
    samples) and weights (8, samples) of the neighbours of each place, and for four columns of them.
    """
    circle, offsets, direction = ray
    corners, weights, near = room
    height, width = levels.shape[0], levels.shape[1] // COLOURS
    for end in (0, len(offsets) - 1):
        distance = circle[2] + offsets[end]
        x, y = circle[0] + direction[0] * distance, circle[1] + direction[1] * distance
        if not (1 <= x < width - 2 and 1 <= y < height - 2):
            return False
    for sample in range(len(offsets)):
        distance = circle[2] + offsets[sample]
        x, y = circle[0] + direction[0] * distance, circle[1] + direction[1] * distance
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
