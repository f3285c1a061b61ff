"""A recording → all that may be a ball in each frame, and a recording that remembers what is around that.

One that could not be kept in memory, because its camera moves or it is very long, is read again for this,
and then never more: only what differs from its background matters.
"""

from dataclasses import replace

import numpy as np

from tracking.blob import Blob
from tracking.boxes import boxes
from tracking.coarse import COARSE, coarsely
from tracking.detect import find_blobs, make_background
from tracking.keeper import BESIDE, MOST_BYTES
from tracking.kept import Kept, Part
from tracking.planes import Window, copied
from tracking.recording import Recording, View
from tracking.video import revisit

Candidates = dict[int, list[Blob]]
"""What differs from the background in each genuine frame, by its number."""


def find_candidates(recording: Recording) -> tuple[Candidates, Recording]:
    """List what differs from the background in each frame, and keep it if nothing is kept yet."""
    background = make_background(recording)
    if recording.kept:
        return {view.index: find_blobs(view, background) for view in revisit(recording)}, recording
    found: Candidates = {}
    kept, room = [Kept(picture=0)] * len(recording.times), MOST_BYTES
    for view in revisit(recording):
        blobs = found[view.index] = find_blobs(view, background)
        if room > 0:
            kept[view.index] = _around(view, blobs)
            room -= kept[view.index].bytes
    if room <= 0:
        return found, recording
    return found, replace(recording, pictures=(background.planes,), kept=tuple(kept), drift=None)


def _around(view: View, blobs: list[Blob]) -> Kept:
    """Keep what is around some patches of a picture."""
    marks = np.zeros([-(-side // COARSE) for side in view.size], dtype=np.uint8)
    for blob in blobs:
        top, left = blob.y - blob.height / 2, blob.x - blob.width / 2
        rows, columns = (
            slice(int(start / COARSE), int((start + side) / COARSE) + 1)
            for start, side in ((top, blob.height), (left, blob.width))
        )
        marks[rows, columns] = 1
    return Kept(picture=0, parts=tuple(_part(view, window) for window in boxes(marks, BESIDE, view.size)))


def _part(view: View, window: Window) -> Part:
    """Copy a part of a picture."""
    planes = copied(view.cut(window))
    return Part(window, planes, coarsely(planes))
