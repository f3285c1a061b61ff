"""Which round things move through a picture taken from above, and roughly where: chains of patches.

A thing that rests most of the time belongs to the median background and leaves a patch where it is *not*.
Such a patch does not move, so only chains that get somewhere count; `follow` then finds the rest of the way.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from tracking.blob import Blob
from tracking.detect import find_blobs, make_background
from tracking.video import Recording, revisit

ROUND_FILL = (0.7, 1.25)
LARGEST_ASPECT = 1.7  # smeared by motion, or with its shadow
SIZE_CHANGE = 0.35  # of the logarithm of the width, from one frame to the next
LONGEST_GAP = 3  # frames a chain may skip
FIRST_STEP = 2.5  # diameters a thing may go in the first frame after it was found
SURPRISE = 1.0  # diameters off the straight way at constant velocity
SHORTEST_CHAIN = 5
LEAST_WAY = 1.5  # diameters: what went less far did not move
SEED_WAY = 2.0  # diameters a thing has gone when it is taken up
LARGEST_WOBBLE = 0.5  # change of velocity over velocity, from frame to frame


@dataclass(frozen=True, slots=True, kw_only=True)
class Mover:
    """A round thing on its way: frame numbers in the file, and the patch seen in each."""

    frames: tuple[int, ...]
    blobs: tuple[Blob, ...]

    @property
    def way(self) -> float:
        """Distance between the ends, px."""
        first, last = self.blobs[0], self.blobs[-1]
        return float(np.hypot(last.x - first.x, last.y - first.y))

    @property
    def diameter(self) -> float:
        """Median width of the patches, px."""
        return float(np.median([min(blob.width, blob.height) for blob in self.blobs]))

    @property
    def taken_up(self) -> int:
        """Number of the patch from which it surely moves."""
        first = self.blobs[0]
        way = np.array([np.hypot(blob.x - first.x, blob.y - first.y) for blob in self.blobs])
        return int(np.flatnonzero(way >= min(SEED_WAY * self.diameter, self.way / 2))[0])

    @property
    def wobble(self) -> float:
        """How unsteady it goes once it moves: median change of the step over the median step."""
        moving = slice(max(0, self.taken_up - SHORTEST_CHAIN), None)
        place = np.array([(blob.x, blob.y) for blob in self.blobs[moving]])
        steps = np.diff(place, axis=0) / np.diff(self.frames[moving])[:, None]
        turns = np.hypot(*np.diff(steps, axis=0).T)
        return float(np.median(turns) / max(float(np.median(np.hypot(*steps.T))), 1e-9))


def find_movers(recording: Recording) -> list[Mover]:
    """Find the round things that move through a recording, the one that goes furthest first."""
    background = make_background(recording)
    seen = (
        (view.index, [blob for blob in find_blobs(view, background) if _round(blob)])
        for view in revisit(recording)
    )
    movers = [mover for chain in _link(seen) if (mover := _moving(chain)) is not None]
    return sorted(movers, key=lambda mover: -mover.way)


def _round(blob: Blob) -> bool:
    """Tell whether a patch could be a ball seen from above."""
    aspect = blob.width / blob.height
    return (
        not blob.at_border
        and ROUND_FILL[0] < blob.fill < ROUND_FILL[1]
        and 1 / LARGEST_ASPECT < aspect < LARGEST_ASPECT
    )


_Chain = list[tuple[int, Blob]]


def _link(frames: Iterable[tuple[int, Sequence[Blob]]]) -> list[_Chain]:
    """Join patches of successive frames into chains, each to the nearest that fits."""
    done: list[_Chain] = []
    alive: list[_Chain] = []
    for number, blobs in frames:
        alive, tired = _part(alive, number)
        done += tired
        taken: set[int] = set()
        pairs = [
            (misfit, place, index)
            for place, chain in enumerate(alive)
            for index, blob in enumerate(blobs)
            if (misfit := _misfit(chain, number, blob)) < 1
        ]
        grown: set[int] = set()
        for _, place, index in sorted(pairs):
            if place not in grown and index not in taken:
                alive[place].append((number, blobs[index]))
                grown.add(place)
                taken.add(index)
        alive += [[(number, blob)] for index, blob in enumerate(blobs) if index not in taken]
    return done + alive


def _part(chains: list[_Chain], number: int) -> tuple[list[_Chain], list[_Chain]]:
    """Tell chains that may go on from those that were lost too long."""
    alive = [chain for chain in chains if number - chain[-1][0] <= LONGEST_GAP]
    return alive, [chain for chain in chains if number - chain[-1][0] > LONGEST_GAP]


def _misfit(chain: _Chain, number: int, blob: Blob) -> float:
    """How badly a patch continues a chain; 1 or more: not at all."""
    last_number, last = chain[-1]
    size = abs(np.log(min(blob.width, blob.height) / min(last.width, last.height))) / SIZE_CHANGE
    x, y, reach = last.x, last.y, FIRST_STEP
    if len(chain) > 1:
        before_number, before = chain[-2]
        share = (number - last_number) / (last_number - before_number)
        x, y, reach = x + (x - before.x) * share, y + (y - before.y) * share, SURPRISE
    distance = np.hypot(blob.x - x, blob.y - y) / min(last.width, last.height)
    return float(np.hypot(size, distance / reach))


def _moving(chain: _Chain) -> Mover | None:
    """Keep a chain that is long, gets somewhere and does not jump about."""
    if len(chain) < SHORTEST_CHAIN:
        return None
    numbers, blobs = zip(*chain, strict=True)
    mover = Mover(frames=numbers, blobs=blobs)
    moves = mover.way > LEAST_WAY * mover.diameter and mover.wobble < LARGEST_WOBBLE
    return mover if moves else None
