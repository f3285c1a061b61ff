"""The compiled part of `limb_model`: levels along the rays of one circle, and how they compare with the model."""

import numpy as np
import numpy.typing as npt

from tracking.kernel import compiled

FloatArray = npt.NDArray[np.float64]
SingleArray = npt.NDArray[np.float32]

COLOURS = 3
SHARPNESS = np.float32(-0.75)  # of cubic interpolation, as OpenCV has it
LEAST_LEFT = np.float32(1.0)
OUTER, INNER, SHARE, REST = 0, 1, 2, 4  # rows of the model


@compiled
def compare(
    levels: SingleArray,
    rays: tuple[FloatArray, FloatArray, FloatArray],
    model: tuple[SingleArray, SingleArray, SingleArray],
    seen: tuple[FloatArray, FloatArray, FloatArray],
) -> None:
    """Compare the levels along the rays of one circle with the model, and write what is `seen`.

    Parameters
    ----------
    levels : (height, width, 4) array
    rays : the circle (3,); offsets from it (samples,) and directions (rays, 2)
    model : rows, gram and light of `limb_model`
    seen : information (rays, kinds, kinds), pull (rays, kinds) and variance (rays,), as `Look` has them
    """
    rows, gram, light = model
    information, pull, variance = seen
    count, samples = light.shape
    line, inside = np.zeros((count, COLOURS, samples), dtype=np.float32), np.empty(count, dtype=np.bool_)
    inner, brightest = np.zeros((count, COLOURS), dtype=np.float32), np.zeros(COLOURS, dtype=np.float32)
    for ray in range(count):
        inside[ray] = _sample(levels, rays[0], rays[1], rays[2][ray], line[ray])
        for colour in range(COLOURS):
            inner[ray, colour] = inside[ray] * _product(rows[ray, INNER], line[ray, colour])
            brightest[colour] += inner[ray, colour] / np.float32(count)
    products = np.empty((rows.shape[1], COLOURS), dtype=np.float32)
    for ray in range(count):
        information[ray], pull[ray], variance[ray] = 0.0, 0.0, np.inf
        if inside[ray]:
            left = np.float32(0)
            for colour in range(COLOURS):
                facing = inner[ray, colour] / max(brightest[colour], np.float32(1))
                facing = min(max(facing, np.float32(0)), np.float32(1)) ** 2
                own = line[ray, colour]
                own += inner[ray, colour] * (1 - facing) * light[ray]
                left += _product(own, own)
                for row in range(len(products)):
                    products[row, colour] = _product(rows[ray, row], own)
                left -= products[SHARE, colour] ** 2 + products[SHARE + 1, colour] ** 2
            variance[ray] = max(left, LEAST_LEFT) / (COLOURS * (samples - 2))
            _tell(products, gram[ray], information[ray], pull[ray])


@compiled
def _tell(products: SingleArray, gram: SingleArray, information: FloatArray, pull: FloatArray) -> None:
    """Write what one ray tells: sums over colours, and over the slopes of outer and inner level's shapes."""
    kinds = len(pull)
    for end in range(INNER + 1):
        for kind in range(kinds):
            pull[kind] += _product(products[end], products[REST + 2 * kind + end])
        for other in range(INNER + 1):
            pair = _product(products[end], products[other])
            for kind in range(kinds):
                for second in range(kinds):
                    information[kind, second] += pair * gram[2 * end + other, kinds * kind + second]


@compiled
def _product(one: SingleArray, other: SingleArray) -> np.float32:
    """Sum of the products of two rows."""
    total = np.float32(0)
    for k in range(len(one)):
        total += one[k] * other[k]
    return total


@compiled
def _sample(
    levels: SingleArray, circle: FloatArray, offsets: FloatArray, direction: FloatArray, line: SingleArray
) -> bool:
    """Interpolate levels (colours, samples) along a ray by cubic splines; false if it leaves the picture."""
    height, width = levels.shape[0], levels.shape[1]
    across, down = np.empty(4, dtype=np.float32), np.empty(4, dtype=np.float32)
    for sample in range(len(offsets)):
        distance = circle[2] + offsets[sample]
        x, y = circle[0] + direction[0] * distance, circle[1] + direction[1] * distance
        if not (0 <= x <= width - 1 and 0 <= y <= height - 1):
            return False
        left, top = int(x), int(y)
        _cubic(np.float32(x - left), across)
        _cubic(np.float32(y - top), down)
        blue = green = red = np.float32(0)
        for i in range(4):
            row = min(max(top + i - 1, 0), height - 1)
            b = g = r = np.float32(0)
            for j in range(4):
                column = min(max(left + j - 1, 0), width - 1)
                b += across[j] * levels[row, column, 0]
                g += across[j] * levels[row, column, 1]
                r += across[j] * levels[row, column, 2]
            blue, green, red = blue + down[i] * b, green + down[i] * g, red + down[i] * r
        line[0, sample], line[1, sample], line[2, sample] = blue, green, red
    return True


@compiled
def _cubic(beyond: np.float32, weights: SingleArray) -> None:
    """Weigh four neighbours, two to each side of a place a little `beyond` the second."""
    rest = 1 - beyond
    weights[0] = SHARPNESS * beyond * rest * rest
    weights[1] = ((SHARPNESS + 2) * beyond - (SHARPNESS + 3)) * beyond * beyond + 1
    weights[2] = ((SHARPNESS + 2) * rest - (SHARPNESS + 3)) * rest * rest + 1
    weights[3] = 1 - weights[0] - weights[1] - weights[2]
