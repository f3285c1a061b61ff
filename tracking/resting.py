"""A ball that rests and is struck: frames → its rim in each, wherever it went.

Before it is struck many frames are looked through at once; then one by one, each from where the ball was
going. Where it is missed, or its rim is much less clear than before, it is looked for all about.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from tracking.circle import MARGIN_PX, Guess, find_rims, fit_circles
from tracking.limb import Limb
from tracking.partial import OTHER_BALL
from tracking.recording import Recording
from tracking.sharp import limb_of, sharpened
from tracking.sight import MEMORY, NARROW, half_width, sight_once
from tracking.sighting import Cutting, Cuttings, Sighting, cut_out, together
from tracking.video import revisit

FloatArray = npt.NDArray[np.float64]

MOVING_PX = 0.3  # a frame: what moves less rests
SURPRISE_PX = 1.5  # a ball this far from where it was expected is expected anew
LONGEST_STRIDE = 32  # frames looked through at once
DOUBTFUL = 2.0  # times the usual scatter of a rim: it may not be the ball's
DOUBTFUL_PX = 0.06  # ... and at least this
ABOVE = 1.5  # radii above where it is expected from which a resting ball is looked for,
SPACING, ACROSS = 0.25, (-0.25, 0.0, 0.25)  # ... radii up and down between those places, and across
BELOW = 2.0  # radii below count as one above: the other ball's fall is not always seen to its end
ABOUT = np.linspace(-1.25, 1.0, 10)  # radii up and down, in which a struck ball is looked for
SINKING = 0.1  # radii: no ball goes deeper into the plate; what is seen there is its mirror image


@dataclass(slots=True, kw_only=True)
class _Watch:
    """A ball that is watched: where it is expected (px), what was seen of it, and the frames that wait.

    `vague` is how far its rims scattered when they were first seen, px.
    `highest` is the least y, px, that it can have in each frame: there it touches the ball above it.
    """

    guess: Guess
    highest: FloatArray
    limb: Limb = field(default_factory=Limb)
    seen: list[Sighting] = field(default_factory=list)
    waiting: list[Cutting] = field(default_factory=list)
    vague: list[float] = field(default_factory=list)
    stride: int = 1

    def expected(self, frame: int) -> Guess:
        """Expect a ball that moves to go on as it did from the frame before the last."""
        if len(self.seen) < 2 or self.seen[-1].frame - self.seen[-2].frame > 1:
            return self.guess
        before, last = self.seen[-2].circle, self.seen[-1].circle
        step = np.array([last.x - before.x, last.y - before.y])
        if np.hypot(*step) < MOVING_PX:
            return self.guess
        x, y = (last.x, last.y) + step * (frame - self.seen[-1].frame)
        return float(x), float(y), self.guess[2]

    def take(self, sighting: Sighting) -> None:
        """Believe a sighting."""
        self.seen.append(sighting)
        radius = np.median([each.circle.radius for each in self.seen[-MEMORY:]])
        self.guess = (sighting.circle.x, sighting.circle.y, float(radius))

    def is_doubtful(self, sighting: Sighting | None) -> bool:
        """Tell whether the ball was missed, or is where it cannot be, or its rim is much less clear."""
        if sighting is None or not self.is_possible(sighting):
            return True
        usual = float(np.median(self.vague[-MEMORY:])) if self.vague else np.inf
        return sighting.circle.vagueness > max(DOUBTFUL * usual, DOUBTFUL_PX)

    def is_possible(self, sighting: Sighting) -> bool:
        """Tell whether the ball can be there: not within the plate, nor within the ball above."""
        deepest = self.seen[0].circle.y + SINKING * self.guess[2] if self.seen else np.inf
        return bool(self.highest[sighting.frame] <= sighting.circle.y <= deepest)


def find_resting(recording: Recording, frame: int, expected: Guess) -> Guess:
    """Find a ball that rests about where it is expected (x, y and radius, px) in one frame, or below.

    Of the outlines found it has a clear one, and one near: its mirror image in the plate lies further down.
    """
    (view,) = revisit(recording, {frame})
    x, highest, radius = expected[0], expected[1] - ABOVE * expected[2], expected[2]
    lowest = max(view.size[0] - 1.0, highest + radius)
    cutting = cut_out(view, (x, (highest + lowest) / 2), (lowest - highest) / 2 + half_width(radius, 0.0))
    down = np.arange(highest, lowest, SPACING * radius).tolist()
    guesses: list[Guess] = [(x + aside * radius, y, radius) for y in down for aside in ACROSS]
    seen = sight_once(together([cutting]).take([0] * len(guesses)), guesses, np.zeros(len(guesses)))
    circles = [sighting.circle for sighting in seen if sighting is not None]
    possible = [c for c in circles if abs(c.radius / radius - 1) < OTHER_BALL and c.y > highest]
    below = np.array([circle.y - expected[1] for circle in possible]) / radius
    unlikely = [c.vagueness for c in possible] * (1 + (below / np.where(below > 0, BELOW, 1.0)) ** 2)
    if not possible:
        return expected
    best = possible[int(np.argmin(unlikely))]
    rim = find_rims([cutting.patch], [(best.x, best.y, radius)], reach=NARROW * radius + MARGIN_PX)
    (again,) = fit_circles(rim, [(best.x, best.y, radius)], free_radius=False)
    return (best.x, best.y, radius) if again is None else (again.x, again.y, radius)


def sight_resting(recording: Recording, guess: Guess, highest: FloatArray) -> list[Sighting]:
    """See a ball that rests first and may be struck later.

    Parameters
    ----------
    recording : Recording
    guess : x, y and radius, px
    highest : the least y, px, that its centre can have in each frame of the file
    """
    watch = _Watch(guess=guess, highest=highest)
    half = 2 * guess[2] + half_width(guess[2], 0.0)
    for view in revisit(recording):
        if not watch.seen and not watch.waiting:
            first = together([cut_out(view, watch.guess[:2], half)])
            found = sight_once(first, [watch.guess], np.zeros(1))
            watch.limb = limb_of(first, [sighting for sighting in found if sighting is not None])
        watch.waiting.append(cut_out(view, watch.guess[:2], half))
        if len(watch.waiting) >= watch.stride:
            _advance(watch)
    while watch.waiting:
        _advance(watch)
    return watch.seen


def _advance(watch: _Watch) -> None:
    """See the ball in some of the frames that wait, up to the first in which it is not where expected."""
    batch = together(watch.waiting[: watch.stride])
    places = [watch.expected(frame) for frame in batch.frames]
    first = sight_once(batch, places, np.zeros(len(places)))
    doubtful = next((i for i, sighting in enumerate(first) if watch.is_doubtful(sighting)), len(first))
    if doubtful < len(first):
        batch = batch.take(range(doubtful + 1))
        del places[doubtful + 1 :], first[doubtful + 1 :]
        first[doubtful] = _look_about(watch, batch.take([doubtful]), places[doubtful])
    surprised = _take_as_expected(watch, batch, places, first)
    del watch.waiting[: surprised or len(first)]
    alone = surprised or doubtful < len(first)
    watch.stride = 1 if alone else min(2 * watch.stride, LONGEST_STRIDE)


def _take_as_expected(
    watch: _Watch, batch: Cuttings, places: Sequence[Guess], first: Sequence[Sighting | None]
) -> int:
    """Take sightings up to the first that surprises; give how many frames that makes, 0 if none does."""
    rough = {sighting.frame: sighting for sighting in first if sighting is not None}
    found = {sighting.frame: sighting for sighting in sharpened(batch, list(rough.values()), watch.limb)}
    for count, (place, frame) in enumerate(zip(places, batch.frames, strict=True), start=1):
        sighting = found.get(frame)
        if sighting is None:
            continue
        watch.take(sighting)
        watch.vague.append(rough[frame].circle.vagueness)
        if np.hypot(watch.guess[0] - place[0], watch.guess[1] - place[1]) > SURPRISE_PX:
            return count
    return 0


def _look_about(watch: _Watch, alone: Cuttings, place: Guess) -> Sighting | None:
    """Look for a struck ball above and below where it is expected, and take the clearest rim."""
    x, y, radius = place
    guesses = [place, *((x, y + shift, radius) for shift in ABOUT * radius)]
    found = sight_once(alone.take([0] * len(guesses)), guesses, np.zeros(len(guesses)))
    possible = (sighting for sighting in found if sighting is not None and watch.is_possible(sighting))
    return min(possible, key=lambda sighting: sighting.circle.vagueness, default=None)
