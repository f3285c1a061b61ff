"""`PairTrack` → the impact of two discs: velocities, restitution along the line of centres, momentum."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tracking.errors import RecordingError
from tracking.free_motion import upright
from tracking.kink import first_kink
from tracking.least import slopes
from tracking.pair import PairTrack, closeness
from tracking.pair_fit import (
    COUNT,
    TIME,
    Encounter,
    Leg,
    deceleration_of,
    fit_encounter,
    place_of,
    velocity_of,
)
from tracking.track import Track

FloatArray = npt.NDArray[np.float64]

SIDES = (False, True)  # before and after
WINDOW = 0.1  # s on each side of the impact
GAP_SHARE_SD = 0.02  # how well the outlines tell the distance of two discs that touch
FEWEST_FRAMES = 5
AT_REST = 0.1  # radii that a disc at rest seems to go at most
FIRST_FRAMES = 6  # frames next to the impact for the first guess


@dataclass(frozen=True, slots=True, kw_only=True)
class PairImpact:
    """One impact of two discs, in the unit of their tracks (m or px), x to the right and y up.

    Attributes
    ----------
    time, time_sd : float
        Moment of the impact, s.
    places : (2, 2) array
        Centres of the striker and of the struck disc at the impact.
    line_of_centres : (2,) array
        Unit vector from the striker to the struck disc at the impact.
    striker_before, striker_after, struck_before, struck_after : (2,) arrays
        Velocities just before and just after.
    covariance : (8, 8) array
        Of these velocities, one after the other.
    restitution, restitution_sd : float
        Speed of separation over speed of approach along the line of centres.
    momentum_gap, momentum_gap_sd : (2,) arrays
        Momentum after less momentum before, along and across the latter, as a share of it: 0 within its
        uncertainty if velocities and masses are right.
    deceleration : (2,) array
        By friction, of the striker and of the struck disc.
    frames : int
        Frames used.
    residual : float
        Root mean square distance of the frames from the paths.
    fitted : tuple of (n, 3) arrays
        Time and place (t, x, y) on the fitted paths: striker before and after, struck disc before and after.
    """

    time: float
    time_sd: float
    places: FloatArray
    line_of_centres: FloatArray
    striker_before: FloatArray
    striker_after: FloatArray
    struck_before: FloatArray
    struck_after: FloatArray
    covariance: FloatArray
    restitution: float
    restitution_sd: float
    momentum_gap: FloatArray
    momentum_gap_sd: FloatArray
    deceleration: FloatArray
    frames: int
    residual: float
    fitted: tuple[FloatArray, ...]


def measure_pair(pair: PairTrack, *, masses: tuple[float, float] = (1.0, 1.0)) -> PairImpact:
    """Measure the impact by one fit to both paths before and after it.

    Parameters
    ----------
    pair : PairTrack
        In metres or pixels.
    masses : two floats
        Of striker and struck disc; only their ratio matters.

    Raises
    ------
    RecordingError
        If a disc is seen in too few frames before or after the impact.
    """
    if not all(0 < mass < np.inf for mass in masses):
        raise ValueError(f"masses must be positive, got {masses}")
    tracks = [upright(track) for track in (pair.striker, pair.struck)]
    _, moment = closeness(*tracks)
    legs = tuple(_leg(track, disc, moment, after) for disc, track in enumerate(tracks) for after in SIDES)
    gap = pair.striker.radius + pair.struck.radius
    rests = tuple(_rests(leg, track.radius) for leg, track in zip(legs[::2], tracks, strict=True))
    encounter = Encounter(legs=legs, gap=gap, gap_sd=GAP_SHARE_SD * gap, rests=rests)
    fit = fit_encounter(encounter, _first_guess(encounter, moment))
    told = _told(fit.parameters, masses)
    slope = slopes(lambda parameters: _told(parameters, masses), fit.parameters)
    restitution_sd, *gap_sd = np.sqrt(np.diag(slope @ fit.covariance @ slope.T))
    places = [velocity_of(disc, after=after) for disc in (0, 1) for after in SIDES]
    velocities = [fit.parameters[place] for place in places]
    chosen = np.concatenate([np.arange(COUNT)[place] for place in places])
    return PairImpact(
        time=float(fit.parameters[TIME]),
        time_sd=float(np.sqrt(fit.covariance[TIME, TIME])),
        places=np.array([fit.parameters[place_of(disc)] for disc in (0, 1)]),
        line_of_centres=_line_of_centres(fit.parameters),
        striker_before=velocities[0],
        striker_after=velocities[1],
        struck_before=velocities[2],
        struck_after=velocities[3],
        covariance=fit.covariance[np.ix_(chosen, chosen)],
        restitution=float(told[0]),
        restitution_sd=float(restitution_sd),
        momentum_gap=told[1:],
        momentum_gap_sd=np.array(gap_sd),
        deceleration=fit.parameters[[deceleration_of(0), deceleration_of(1)]],
        frames=fit.frames,
        residual=fit.residual,
        fitted=fit.paths,
    )


def _leg(track: Track, disc: int, moment: float, after: bool) -> Leg:
    """Take a disc's free motion on one side of the impact, without the frame nearest to it."""
    half = float(np.median(np.diff(track.time))) / 2
    since = (track.time - moment) * (1 if after else -1)
    chosen = np.flatnonzero((since > half) & (since < WINDOW))
    ordered = chosen if after else chosen[::-1]
    place = np.column_stack((track.x, track.y))
    kink = first_kink(since[ordered], place[ordered], float(np.median(track.x_sd)), 0.0)
    ordered = ordered if kink is None else ordered[: kink - 1]
    if len(ordered) < FEWEST_FRAMES:
        raise RecordingError(
            f"the {track.ball} disc is seen in free motion in {len(ordered)} frames only "
            f"{'after' if after else 'before'} the impact, but {FEWEST_FRAMES} are needed; record more "
            "frames a second (or tell --capture-fps, if this is slow motion), let it go earlier, and keep "
            "both discs in the picture"
        )
    chosen = np.sort(ordered)
    sd = np.column_stack((track.x_sd, track.y_sd))
    return Leg(disc=disc, after=after, time=track.time[chosen], place=place[chosen], sd=sd[chosen])


def _rests(leg: Leg, radius: float) -> bool:
    """Tell whether a disc does not move before the impact."""
    return bool(np.ptp(leg.place, axis=0).max() < AT_REST * radius)


def _first_guess(encounter: Encounter, moment: float) -> FloatArray:
    """Start from straight lines through the frames nearest to the impact."""
    guess = np.zeros(COUNT)
    guess[TIME] = moment
    for leg in encounter.legs:
        nearest = slice(None, FIRST_FRAMES) if leg.after else slice(-FIRST_FRAMES, None)
        velocity, place = np.polyfit(leg.time[nearest] - moment, leg.place[nearest], 1)
        if leg.after or not encounter.rests[leg.disc]:
            guess[velocity_of(leg.disc, after=leg.after)] = velocity
        if not leg.after:
            guess[place_of(leg.disc)] = place
    return guess


def _line_of_centres(parameters: FloatArray) -> FloatArray:
    """Give the unit vector from the first disc to the second at the impact."""
    apart = parameters[place_of(1)] - parameters[place_of(0)]
    return np.asarray(apart / np.hypot(*apart))


def _told(parameters: FloatArray, masses: Sequence[float]) -> FloatArray:
    """Work out the restitution, and the momentum gap along and across."""
    before, after = ([parameters[velocity_of(disc, after=side)] for disc in (0, 1)] for side in (False, True))
    normal = _line_of_centres(parameters)
    restitution = -((after[1] - after[0]) @ normal) / ((before[1] - before[0]) @ normal)
    had, has = (masses[0] * v[0] + masses[1] * v[1] for v in (before, after))
    size = float(had @ had)
    gap = has - had
    across = np.array([-had[1], had[0]])
    return np.array([restitution, gap @ had / size, gap @ across / size])
