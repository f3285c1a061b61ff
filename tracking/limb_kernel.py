"""The compiled part of `limb_model`: levels along the rays of a circle, compared with the model."""

import numpy as np
import numpy.typing as npt

from tracking.kernel import compiled, inlined, part

FloatArray = npt.NDArray[np.float64]
Image = npt.NDArray[np.uint8]
SingleArray = npt.NDArray[np.float32]
Four = tuple[np.float32, np.float32, np.float32, np.float32]

COLOURS = 3
SHARPNESS = np.float32(-0.75)  # of cubic interpolation, as OpenCV has it
LEAST_LEFT = np.float32(1.0)
ZERO, ONE, TWO, THREE = np.arange(4, dtype=np.float32)  # of single precision, or all would be double
OUTER, INNER, SHARE, REST = 0, 1, 2, 4  # rows of the model


@compiled
def compare(
    image: Image,
    rays: tuple[FloatArray, FloatArray, FloatArray],
    model: tuple[SingleArray, SingleArray, SingleArray],
    seen: tuple[FloatArray, FloatArray, FloatArray],
) -> None:
    """Compare the levels along the rays of one circle with the model, and write what is `seen`.

    Parameters
    ----------
    image : (height, width, 3) array
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
        inside[ray] = _sample(image, rays[0], rays[1], rays[2][ray], line[ray])
        for colour in range(COLOURS):
            inner[ray, colour] = inside[ray] * _product(rows[ray, INNER], line[ray, colour])
            brightest[colour] += inner[ray, colour] / np.float32(count)
    products = np.empty((rows.shape[1], COLOURS), dtype=np.float32)
    for ray in range(count):
        information[ray], pull[ray], variance[ray] = 0.0, 0.0, np.inf
        if inside[ray]:
            left = np.float32(0)
            for colour in range(COLOURS):
                facing = min(max(inner[ray, colour] / max(brightest[colour], ONE), ZERO), ONE)
                missing, own = inner[ray, colour] * (ONE - facing * facing), line[ray, colour]
                for sample in range(samples):
                    own[sample] += missing * light[ray, sample]
                left += _product(own, own)
                for row in range(len(products)):
                    products[row, colour] = _product(rows[ray, row], own)
                left -= products[SHARE, colour] ** 2 + products[SHARE + 1, colour] ** 2
            variance[ray] = max(left, LEAST_LEFT) / (COLOURS * (samples - 2))
            _tell(products, gram[ray], information[ray], pull[ray])


@part
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


@inlined
def _product(one: SingleArray, other: SingleArray) -> np.float32:
    """Sum of the products of two rows."""
    total = np.float32(0)
    for k in range(len(one)):
        total += one[k] * other[k]
    return total


@part
def _sample(
    image: Image, circle: FloatArray, offsets: FloatArray, direction: FloatArray, line: SingleArray
) -> bool:
    """Interpolate levels (colours, samples) along a ray by cubic splines; false if it leaves the picture."""
    across, down = direction
    for sample in range(len(offsets)):
        distance = circle[2] + offsets[sample]
        x, y = circle[0] + across * distance, circle[1] + down * distance
        if not (1 <= x < image.shape[1] - 2 and 1 <= y < image.shape[0] - 2):
            return False
        i, j = int(y), int(x)
        a, b, c, d = _cubic(np.float32(x - j))
        first, second, third, fourth = _cubic(np.float32(y - i))
        near = image[i - 1 : i + 3, j - 1 : j + 3]
        for colour in range(COLOURS):
            line[colour, sample] = (
                first * _row(near, 0, colour, (a, b, c, d))
                + second * _row(near, 1, colour, (a, b, c, d))
                + third * _row(near, 2, colour, (a, b, c, d))
                + fourth * _row(near, 3, colour, (a, b, c, d))
            )
    return True


@inlined
def _row(near: Image, row: int, colour: int, weights: Four) -> np.float32:
    """Interpolate between four neighbours in a row."""
    return np.float32(
        weights[0] * np.float32(near[row, 0, colour])
        + weights[1] * np.float32(near[row, 1, colour])
        + weights[2] * np.float32(near[row, 2, colour])
        + weights[3] * np.float32(near[row, 3, colour])
    )


@inlined
def _cubic(beyond: np.float32) -> Four:
    """Weigh four neighbours, two to each side of a place a little `beyond` the second."""
    rest = ONE - beyond
    first = SHARPNESS * beyond * rest * rest
    second = ((SHARPNESS + TWO) * beyond - (SHARPNESS + THREE)) * beyond * beyond + ONE
    third = ((SHARPNESS + TWO) * rest - (SHARPNESS + THREE)) * rest * rest + ONE
    return first, second, third, ONE - first - second - third
