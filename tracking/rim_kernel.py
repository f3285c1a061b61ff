"""The compiled part of `circle`: where the levels change most along each ray, and a circle through that."""

import numpy as np
import numpy.typing as npt

from tracking.kernel import compiled, part
from tracking.median import upper_median

FloatArray = npt.NDArray[np.float64]
SingleArray = npt.NDArray[np.float32]
Image = npt.NDArray[np.uint8]
Pair = tuple[float, float]

RAYS = 64
STEP_PX = 0.5  # along a ray
HOLLOW = 0.3  # radii: no rim is searched further in
PEAK_PX = 2.0  # a sharp rim is this wide to each side of its steepest place
FLANK = 0.25  # gradients below this share of the steepest are shading or texture, not rim
MINIMUM_STEEPNESS = 2.0  # grey levels a step: less is no edge
TUKEY = 4.685  # standard deviations at which a point no longer counts
LEAST_SCALE_PX = 0.05
MAXIMUM_ITERATIONS = 12
SETTLED_PX = 2e-3
MINIMUM_INLIERS = 0.4
ANGLES: FloatArray = np.arange(RAYS, dtype=np.float64) * (2 * np.pi / RAYS)
DIRECTIONS = np.column_stack((np.cos(ANGLES), np.sin(ANGLES)))


@compiled
def see_rim(image: Image, corner: FloatArray, circle: FloatArray, ways: Pair, points: FloatArray) -> float:
    """Find the steepest place on each ray from a circle's centre: `points` (rays, 2), NaN where none is.

    The image begins at a corner (x, y). The rim is searched within the radius ± the first of two `ways`, px,
    and smeared by the second up and down. Returns the median contrast on the rays that meet an edge, levels;
    infinity where none does.
    """
    x, y, radius = circle[0] - corner[0], circle[1] - corner[1], circle[2]
    reach, blur = ways
    points[:] = np.nan
    if not np.isfinite(x + y + radius + reach):
        return np.inf
    inner = max(radius - reach, HOLLOW * radius)
    count = int(np.ceil((radius + reach + STEP_PX - inner) / STEP_PX))
    furthest = inner + STEP_PX * (count - 1)
    expected = np.empty(count - 1, dtype=np.float32)
    for k in range(count - 1):
        expected[k] = np.exp(-0.5 * ((inner + STEP_PX * (k + 0.5) - radius) / (0.7 * reach)) ** 2)
    line = np.zeros((count, 3), dtype=np.float32)
    contrasts, seen = np.empty(RAYS), 0
    for ray in range(RAYS):
        across, down = DIRECTIONS[ray]
        end_x, end_y = x + across * furthest, y + down * furthest
        if not (0 <= end_x <= image.shape[1] - 1 and 0 <= end_y <= image.shape[0] - 1):
            continue
        _sample(image, (x + across * inner, y + down * inner), (across, down), line)
        edge = _steepest(line, expected, (PEAK_PX + blur / 2 * abs(down)) / STEP_PX)
        if np.isfinite(edge):
            distance = inner + STEP_PX * edge
            points[ray, 0] = corner[0] + (x + across * distance)
            points[ray, 1] = corner[1] + (y + down * distance)
            contrasts[seen] = np.sqrt(_square_apart(line, 0, count - 1))
            seen += 1
    return upper_median(contrasts[:seen]) if seen else np.inf


@part
def _sample(image: Image, start: Pair, direction: Pair, line: SingleArray) -> None:
    """Interpolate levels (samples, colours) along a ray, at even steps."""
    bottom, right = image.shape[0] - 1, image.shape[1] - 1
    for k in range(len(line)):
        x = min(max(start[0] + direction[0] * STEP_PX * k, 0.0), float(right))
        y = min(max(start[1] + direction[1] * STEP_PX * k, 0.0), float(bottom))
        i, j = int(y), int(x)
        below, beside = min(i + 1, bottom), min(j + 1, right)
        to_right, to_bottom = np.float32(x - j), np.float32(y - i)
        for colour in range(3):
            upper, lower = np.float32(image[i, j, colour]), np.float32(image[below, j, colour])
            upper += to_right * (np.float32(image[i, beside, colour]) - upper)
            lower += to_right * (np.float32(image[below, beside, colour]) - lower)
            line[k, colour] = upper + to_bottom * (lower - upper)


@part
def _square_apart(line: SingleArray, one: int, other: int) -> np.float32:
    """Square of the difference of two samples, whatever the colour, brighter or darker."""
    blue, green, red = (
        line[other, 0] - line[one, 0],
        line[other, 1] - line[one, 1],
        line[other, 2] - line[one, 2],
    )
    return np.float32(blue * blue + green * green + red * red)


@part
def _steepest(line: SingleArray, expected: SingleArray, half_width: float) -> float:
    """Centroid of the steepest part of a ray, in steps; what is flat beside it is shading or texture.

    NaN where nothing is steep.
    """
    count = len(line) - 1
    steep = np.empty(count, dtype=np.float32)
    highest, steepest, peak = np.float32(0), np.float32(0), 0
    for k in range(count):
        change = np.sqrt(_square_apart(line, k, k + 1))
        steepest = max(steepest, change)
        steep[k] = change * expected[k]
        if steep[k] > highest:
            highest, peak = steep[k], k
    if steepest < MINIMUM_STEEPNESS:
        return np.nan
    total, moment = 0.0, 0.0
    for k in range(max(0, int(np.ceil(peak - half_width))), min(count, int(peak + half_width) + 1)):
        weight = max(steep[k] - FLANK * highest, 0.0)
        total += weight
        moment += weight * k
    return moment / max(total, 1e-9) + 0.5


@compiled
def fit_rim(
    points: FloatArray, known: FloatArray, circle: FloatArray, free: int, agreement: FloatArray
) -> Pair:
    """Fit a circle to points by Gauss-Newton with Tukey weights times what is `known` of each (rays,).

    `circle` (x, y, radius) moves, the radius only if three are `free`; `agreement` (rays,), the Tukey
    weights, is written. Returns the variances of x and y, px².
    """
    offsets, seen = np.empty((RAYS, 3)), 0
    agreement[:] = 0.0
    for ray in range(RAYS):
        seen += np.isfinite(points[ray, 0])
    variance_x, variance_y = np.inf, np.inf
    for _ in range(MAXIMUM_ITERATIONS if seen >= MINIMUM_INLIERS * RAYS else 0):
        _weigh(points, circle, offsets, agreement)
        xx, xy, yy, xr, yr, rr, pull_x, pull_y, pull_r, squares = _sums(offsets, agreement, known)
        if free == 2:
            xr, yr, rr, pull_r = 0.0, 0.0, 1.0, 0.0
        ix, ixy, ixr = yy * rr - yr * yr, xr * yr - xy * rr, xy * yr - yy * xr  # inverse × determinant
        iy, iyr, ir = xx * rr - xr * xr, xy * xr - xx * yr, xx * yy - xy * xy
        determinant = xx * ix + xy * ixy + xr * ixr
        step_x = (ix * pull_x + ixy * pull_y + ixr * pull_r) / determinant
        step_y = (ixy * pull_x + iy * pull_y + iyr * pull_r) / determinant
        step_r = (ixr * pull_x + iyr * pull_y + ir * pull_r) / determinant
        circle[0], circle[1], circle[2] = circle[0] + step_x, circle[1] + step_y, circle[2] + step_r
        variance = squares / max(agreement.sum() - free, 1.0) / determinant
        variance_x, variance_y = ix * variance, iy * variance
        if not max(abs(step_x), abs(step_y), abs(step_r)) >= SETTLED_PX:
            break
    return variance_x, variance_y


@part
def _sums(offsets: FloatArray, agreement: FloatArray, known: FloatArray) -> tuple[float, ...]:
    """Add up for least squares: slopes times slopes (x, y, radius) and offsets, and offsets squared."""
    xx = yy = rr = 1e-9
    xy = xr = yr = pull_x = pull_y = pull_r = squares = 0.0
    for ray in range(RAYS):
        if agreement[ray] > 0:
            across, down, apart = offsets[ray]
            weight = agreement[ray] * known[ray]
            pull = weight * apart
            xx, xy, yy = xx + weight * across**2, xy + weight * across * down, yy + weight * down**2
            xr, yr, rr = xr + weight * across, yr + weight * down, rr + weight
            pull_x, pull_y, pull_r = pull_x + pull * across, pull_y + pull * down, pull_r + pull
            squares += pull * apart
    return xx, xy, yy, xr, yr, rr, pull_x, pull_y, pull_r, squares


@part
def _weigh(points: FloatArray, circle: FloatArray, offsets: FloatArray, agreement: FloatArray) -> None:
    """Write each point's direction and distance off a circle, and a weight that falls to nothing."""
    sizes, seen = np.empty(RAYS), 0
    for ray in range(RAYS):
        if np.isfinite(points[ray, 0]):
            across, down = points[ray, 0] - circle[0], points[ray, 1] - circle[1]
            distance = max(np.sqrt(across * across + down * down), 1e-9)
            offsets[ray, 0], offsets[ray, 1] = across / distance, down / distance
            offsets[ray, 2] = distance - circle[2]
            sizes[seen] = abs(offsets[ray, 2])
            seen += 1
    limit = TUKEY * max(1.4826 * upper_median(sizes[:seen]), LEAST_SCALE_PX)
    for ray in range(RAYS):
        agreement[ray] = 0.0
        if np.isfinite(points[ray, 0]):
            agreement[ray] = max(1 - (offsets[ray, 2] / limit) ** 2, 0.0) ** 2
