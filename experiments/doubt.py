"""Why a person should look at a measured impact before believing it."""

import numpy as np

from tracking.flight import STANDARD_GRAVITY
from tracking.pair_impact import PairImpact
from tracking.shot import Shot
from tracking.velocity import Impact

GRAVITY_TOLERANCE = 0.15  # fitted over expected gravity; beyond it scale or time base is wrong
SIDEWAYS_TOLERANCE = 0.2  # of the rebound speed: the hit was not central
VAGUE = 0.1  # of the approach speed: a velocity known no better tells nothing
MOMENTUM_TOLERANCE = 0.05  # of the momentum before; beyond it, and three sd, something else took part
USUAL_RATES = (25, 30, 50, 60, 100, 120, 240, 300, 480, 600, 960, 1000)  # frames/s


def find_doubt(impact: Impact, capture_fps: float) -> str:
    """Say what is wrong with an impact and what helps; empty if nothing is.

    Parameters
    ----------
    impact : Impact
        As measured.
    capture_fps : float
        Frames/s at which the recording is believed to be captured.
    """
    check, sd = impact.gravity_check, impact.gravity_check_sd
    if not abs(check - 1) <= max(GRAVITY_TOLERANCE, 3 * sd):
        return _wrong_gravity(check, capture_fps)
    approach, rebound = impact.velocities[:2]
    vague = float(np.nanmax(impact.sd))
    if not vague <= VAGUE * abs(approach):
        return (
            f"a velocity is known to ± {vague:.2g} m/s only; film the ball larger and sharper, "
            "with more frames before and after the impact"
        )
    sideways = abs(float(impact.sideways[1] - impact.sideways[0]))
    if sideways > SIDEWAYS_TOLERANCE * abs(rebound):
        return (
            f"the ball rebounds sideways ({sideways:.2f} m/s), so the hit was not central; "
            "drop it straight above the middle"
        )
    return ""


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


def _wrong_gravity(check: float, capture_fps: float) -> str:
    """Say what the fitted gravity tells of the time base or the scale."""
    fitted = f"fitted gravity is {check * STANDARD_GRAVITY:.2f} m/s²"
    rate = capture_fps / np.sqrt(check) if check > 0 else np.nan
    usual = [fps for fps in USUAL_RATES if abs(rate / fps - 1) < 0.08]
    if usual and abs(usual[0] / capture_fps - 1) > 0.2:
        return (
            f"{fitted}: this looks like {usual[0]} fps stored as {capture_fps:.4g}; "
            f"use --capture-fps {usual[0]}"
        )
    return f"{fitted}: check the scale (--ball-diameter, --metres-per-pixel) and the rate (--capture-fps)"
