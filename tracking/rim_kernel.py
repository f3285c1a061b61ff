"""The compiled part of `circle`: where the levels change most along each ray, and a circle through that."""

import numpy as np
import numpy.typing as npt

from tracking.kernel import compiled, part
from tracking.median import upper_median
from tracking.single import patch_levels

FloatArray = npt.NDArray[np.float64]
LongArray = npt.NDArray[np.int64]
SingleArray = npt.NDArray[np.float32]
Image = npt.NDArray[np.uint8]
Pair = tuple[float, float]

RAYS, COLOURS = 64, 3
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
def see_rims(
    pictures: tuple[Image, LongArray],
    circles: FloatArray,
    ways: FloatArray,
    points: FloatArray,
    part_of: tuple[int, int],
) -> None:
    """Find the steepest place on each ray from a circle's centre in each picture.

    Parameters
    ----------
    pictures : levels and places of `Patches`
    circles : (n, 3) array
    ways : (2, n) array
        The rim is searched within the radius ± the first of these, px, and smeared by the second up and down.
    points : (n, rays, 2) array
        Written; NaN where no edge is.
    part_of : number of the first picture, and of pictures to the next
    """
    for k in range(part_of[0], len(circles), part_of[1]):
        levels, left, top = patch_levels(pictures, k)
        _see_rim(levels, (left, top), circles[k], (ways[0, k], ways[1, k]), points[k])


@part
def _see_rim(
    levels: SingleArray, corner: tuple[int, int], circle: FloatArray, ways: Pair, points: FloatArray
) -> None:
    """Do so in one picture, which begins at a corner (x, y)."""
    x, y, radius = circle[0] - corner[0], circle[1] - corner[1], circle[2]
    reach, blur = ways
    points[:] = np.nan
    if not np.isfinite(x + y + radius + reach):
        return
    inner = max(radius - reach, HOLLOW * radius)
    count = int(np.ceil((radius + reach + STEP_PX - inner) / STEP_PX))
    furthest = inner + STEP_PX * (count - 1)
    expected = np.empty(count - 1, dtype=np.float32)
    for k in range(count - 1):
        expected[k] = np.exp(-0.5 * ((inner + STEP_PX * (k + 0.5) - radius) / (0.7 * reach)) ** 2)
    line = np.zeros((COLOURS, count), dtype=np.float32)
    for ray in range(RAYS):
        across, down = DIRECTIONS[ray]
        end_x, end_y = x + across * furthest, y + down * furthest
        if not (0 <= end_x <= levels.shape[1] - 1 and 0 <= end_y <= levels.shape[0] - 1):
            continue
        _sample(levels, (x + across * inner, y + down * inner), (across, down), line)
        edge = _steepest(line, expected, (PEAK_PX + blur / 2 * abs(down)) / STEP_PX)
        if np.isfinite(edge):
            distance = inner + STEP_PX * edge
            points[ray, 0] = corner[0] + (x + across * distance)
            points[ray, 1] = corner[1] + (y + down * distance)


@part
def _sample(levels: SingleArray, start: Pair, direction: Pair, line: SingleArray) -> None:
    """Interpolate levels (colours, samples) along a ray, at even steps."""
    bottom, right = levels.shape[0] - 1, levels.shape[1] - 1
    for k in range(line.shape[1]):
        x = min(max(start[0] + direction[0] * STEP_PX * k, 0.0), float(right))
        y = min(max(start[1] + direction[1] * STEP_PX * k, 0.0), float(bottom))
        i, j = int(y), int(x)
        below, beside = min(i + 1, bottom), min(j + 1, right)
        to_right, to_bottom = np.float32(x - j), np.float32(y - i)
        for colour in range(COLOURS):
            upper, lower = levels[i, j, colour], levels[below, j, colour]
            upper += to_right * (levels[i, beside, colour] - upper)
            lower += to_right * (levels[below, beside, colour] - lower)
            line[colour, k] = upper + to_bottom * (lower - upper)


@part
def _steepest(line: SingleArray, expected: SingleArray, half_width: float) -> float:
    """Centroid of the steepest part of a ray, in steps; what is flat beside it is shading or texture.

    NaN where nothing is steep.
    """
    blues, greens, reds = line[0], line[1], line[2]
    count = len(expected)
    changes, steep = np.empty(count, dtype=np.float32), np.empty(count, dtype=np.float32)
    for k in range(count):
        blue, green, red = blues[k + 1] - blues[k], greens[k + 1] - greens[k], reds[k + 1] - reds[k]
        changes[k] = np.sqrt(blue * blue + green * green + red * red)
        steep[k] = changes[k] * expected[k]
    highest, steepest, peak = np.float32(0), np.float32(0), 0
    for k in range(count):
        steepest = max(steepest, changes[k])
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
def fit_rims(
    rims: tuple[FloatArray, FloatArray],
    circles: FloatArray,
    free: int,
    told: tuple[FloatArray, FloatArray],
    part_of: tuple[int, int],
) -> None:
    """Fit circles to points by Gauss-Newton with Tukey weights times what is known of each.

    Parameters
    ----------
    rims : points (n, rays, 2) and what is known of them (n, rays)
    circles : (n, 3) array
        x, y and radius; they move, the radius only if three are `free`.
    free : 2 or 3
    told : agreement (n, rays) and variances (n, 2)
        Written: the Tukey weights, and the variances of x and y, px².
    part_of : number of the first rim, and of rims to the next
    """
    points, known = rims
    agreement, variances = told
    for k in range(part_of[0], len(circles), part_of[1]):
        variances[k, 0], variances[k, 1] = _fit_rim(points[k], known[k], circles[k], free, agreement[k])


@part
def _fit_rim(
    points: FloatArray, known: FloatArray, circle: FloatArray, free: int, agreement: FloatArray
) -> Pair:
    """Fit one circle; give the variances of x and y."""
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
