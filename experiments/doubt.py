"""Why a person should look at a measured impact before believing it."""

import numpy as np

from experiments.known import PART_SEEN, TELL_SCALE
from tracking.depth import motion_in_depth
from tracking.flight import STANDARD_GRAVITY
from tracking.pair_impact import PairImpact
from tracking.shot import Shot
from tracking.sides import before_and_after
from tracking.track import Track
from tracking.velocity import Impact

GRAVITY_TOLERANCE = 0.15  # fitted over expected gravity; beyond it scale or time base is wrong
UNSEEN_TOLERANCE = 0.08  # ... where the scale is the size of a ball of which part is not seen,
LARGEST_MISTAKE = 0.4  # ... up to this: no size is misread so far
PROBABLE = 2.0  # standard deviations
SIDEWAYS_TOLERANCE = 0.2  # of the rebound speed: the hit was not central
CERTAIN = 3.0  # standard deviations
RAMP = 2.5  # half the rate makes gravity four times less; air alone makes it up to twice less
VAGUE = 0.1  # of the approach speed: a velocity known no better tells nothing
SWELLING = 0.12  # of a ball's size: more is no motion in depth that can be put right
TILTED = 0.25  # of a ball's size from top to bottom: more, and the slant of its path counts as well
RESTS, MOST_OF_REST = 0.1, (0.05, 0.95)  # radii that a ball at rest seems to move at most, most of the time
MOMENTUM_TOLERANCE = 0.05  # of the momentum before; beyond it, and three sd, something else took part


def find_doubt(
    impact: Impact, capture_fps: float, likely_fps: int | None = None, *, unseen_scale: bool = False
) -> str:
    """Say what is wrong with an impact and what helps; empty if nothing is.

    Parameters
    ----------
    impact : Impact
        As measured.
    capture_fps : float
        Frames/s at which the recording is believed to be captured.
    likely_fps : int, optional
        Frames/s at which it would show gravity as it is.
    unseen_scale : bool
        Whether the scale is the ball's size, and that is not seen well.
    """
    changed = _changing_rate(impact)
    if changed:
        return changed
    if unseen_scale and _size_is_wrong(impact):
        return f"{_fitted_gravity(impact)}: {PART_SEEN}; {TELL_SCALE}"
    if gravity_is_wrong(impact):
        return _wrong_gravity(impact, capture_fps, likely_fps)
    approach, rebound = impact.velocities[:2]
    vague = ~(impact.sd <= VAGUE * abs(approach)) & ~np.isnan(impact.velocities)
    if vague.any():
        return _vague_hop(impact, capture_fps) if not vague[:2].any() else _vague_fall(impact)
    apart = np.abs(impact.free_velocities - impact.velocities)
    if np.any(apart > CERTAIN * np.hypot(impact.free_sd, impact.sd)):
        free = ", ".join(f"{value:.3f}" for value in impact.free_velocities if np.isfinite(value))
        return (
            f"the frames by themselves tell {free} m/s, more than {CERTAIN:g} standard deviations from the "
            "flights; look at the overlay, and check mass, scale and rate"
        )
    sideways = abs(float(impact.sideways[1] - impact.sideways[0]))
    if sideways > SIDEWAYS_TOLERANCE * abs(rebound):
        return (
            f"the ball rebounds sideways ({sideways:.2f} m/s), so the hit was not central; "
            "drop it straight above the middle"
        )
    return ""


def _vague_fall(impact: Impact) -> str:
    """Say that the flight of the upper ball tells too little, and what helps."""
    return (
        f"a velocity is known to ± {np.nanmax(impact.sd):.2g} m/s only; film the ball larger and sharper, "
        "with more frames before and after the impact"
    )


def _vague_hop(impact: Impact, capture_fps: float) -> str:
    """Say that the hop of the lower ball tells too little, and what helps."""
    sd = float(impact.sd[2])
    fastest = float(impact.velocities[2]) + sd
    height, lasting = fastest**2 / (2 * STANDARD_GRAVITY), 2 * fastest / STANDARD_GRAVITY
    return (
        f"the lower ball's velocity is known to ± {sd:.2g} m/s only, for it hops low and briefly (up to "
        f"{1000 * height:.1f} mm, for {1000 * lasting:.0f} ms or {lasting * capture_fps:.1f} frames); record "
        "more frames a second, film it larger, drop from higher, or take another pair of masses"
    )


def find_size_doubt(ball: Track) -> str:
    """Say that a ball's size changes more than a drop's does; empty if not. The track is in px."""
    depth = motion_in_depth(ball)
    if depth.tilts and abs(depth.tilt) > TILTED:
        return (
            f"the ball's size changes by {abs(depth.tilt):.0%} with its height: the camera is tilted too "
            "far; set it level, at the height of the impact"
        )
    if not (depth.drifts and abs(depth.drift) > SWELLING):
        return ""
    return (
        f"the ball's size changes by {abs(depth.drift):.0%} along its path: either it falls far out of its "
        "plane, so let it go again, or part of its rim is as grey as the wall, so light it evenly or film it "
        "against a background of another colour"
    )


def find_rest_doubt(lower: Track, impact: Impact) -> str:
    """Say that the lower ball (track in metres) moves before it is struck; empty if it rests."""
    before, _ = before_and_after(lower, impact.time)
    if not before.size:
        return ""
    moved = max(float(np.ptp(np.quantile(place[before], MOST_OF_REST))) for place in (lower.x, lower.y))
    noise = float(np.median(np.maximum(lower.x_sd, lower.y_sd)))
    if moved <= max(2 * CERTAIN * noise, RESTS * lower.radius):
        return ""
    return (
        f"the lower ball moves by {1000 * moved:.1f} mm before the impact at {impact.time:.3f} s, where it "
        "has to rest: an earlier impact was missed, or it was touched; look at the overlay, film against a "
        "background of another colour, and let the lower ball come to rest"
    )


def find_shot_doubt(shot: Shot) -> str:
    """Say that a shot is known too vaguely and what helps; empty if not. `Shot.doubts` tells the rest."""
    speed, vague = float(np.hypot(*shot.velocity)), float(np.max(shot.velocity_sd))
    if vague <= VAGUE * speed:
        return ""
    return (
        f"the velocity is known to ± {vague / speed:.0%} only; film the ball larger and sharper, and show "
        "more of its way"
    )


def find_pair_doubt(impact: PairImpact) -> str:
    """Say what is wrong with an impact of two discs and what helps; empty if nothing is."""
    if impact.restitution - 1 > 3 * impact.restitution_sd:
        return (
            f"the discs part faster than they met (restitution {impact.restitution:.3f}); check that the "
            "camera looks straight down and nothing else touches them"
        )
    if not impact.restitution_sd <= VAGUE:
        return (
            f"the restitution is known to ± {impact.restitution_sd:.2g} only; record more frames a second, "
            "and more of the way before and after the impact"
        )
    gap, sd = np.abs(impact.momentum_gap), impact.momentum_gap_sd
    if np.any(gap > np.maximum(MOMENTUM_TOLERANCE, 3 * sd)):
        return (
            f"momentum does not close (it changes by {np.hypot(*gap):.0%}); check the masses of striker and "
            "struck, and that nothing else touches them"
        )
    return ""


def _changing_rate(impact: Impact) -> str:
    """Say that time runs differently before and after the impact: a slow-motion ramp; empty if not."""
    before, after = impact.free_gravity
    sd = float(np.hypot(*impact.free_gravity_sd))
    ratio = before / after if after > 0 else np.nan
    if abs(before - after) > CERTAIN * sd and not 1 / RAMP < ratio < RAMP:
        return (
            f"gravity is {before:.2g} m/s² before the impact and {after:.2g} after it, so the rate changes "
            "within the recording (a slow-motion ramp); export it at one rate throughout"
        )
    return ""


def gravity_is_wrong(impact: Impact) -> bool:
    """Tell whether the ball falls so wrongly that scale or time base must be off."""
    off = abs(impact.gravity_check - 1)
    return not off <= max(GRAVITY_TOLERANCE, CERTAIN * impact.gravity_check_sd)


def _size_is_wrong(impact: Impact) -> bool:
    """Tell whether the ball, whose size is the scale, falls as if it were larger or smaller than it seems."""
    off = abs(impact.gravity_check - 1)
    return max(UNSEEN_TOLERANCE, PROBABLE * impact.gravity_check_sd) < off < LARGEST_MISTAKE


def _wrong_gravity(impact: Impact, capture_fps: float, likely_fps: int | None) -> str:
    """Say what the fitted gravity tells of the time base or the scale."""
    fitted = _fitted_gravity(impact)
    if likely_fps is not None:
        return (
            f"{fitted}: this looks like {likely_fps} fps stored as {capture_fps:.4g}; "
            f"use --capture-fps {likely_fps}"
        )
    return f"{fitted}: check the scale (--ball-diameter, --metres-per-pixel) and the rate (--capture-fps)"


def _fitted_gravity(impact: Impact) -> str:
    """Say what gravity the flights show."""
    return f"fitted gravity is {impact.gravity_check * STANDARD_GRAVITY:.2f} m/s²"
