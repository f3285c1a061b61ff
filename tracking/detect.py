"""One image → where something ball-like differs from the background."""

from dataclasses import dataclass, replace

import numpy as np

from tracking.blob import Blob, Whole, blobs_in
from tracking.boxes import boxes
from tracking.coarse import COARSE, brightened, coarsely, gain_between, mark_changes
from tracking.differing import difference
from tracking.kept import Part, ever_changed, laid_over, usual_picture
from tracking.planes import Image, Planes, Window, copied, cut, everywhere
from tracking.recording import Recording, View, held_still

NOISE_FACTOR = 6.0  # a difference this many times the noise is an object
MINIMUM_DIFFERENCE = 10.0  # grey levels
COARSE_SHARE = 0.3  # of the threshold that the smallest object leaves in what is looked at first
BESIDE = 3  # coarse pixels around what a first look found


@dataclass(frozen=True, slots=True, kw_only=True)
class Background:
    """The scene without what moves: planes, a look at few of their pixels, and their noise, levels."""

    planes: Planes
    coarse: Planes
    noise: float

    @property
    def threshold(self) -> float:
        """Difference from which something is there, grey levels."""
        return max(MINIMUM_DIFFERENCE, NOISE_FACTOR * self.noise)


def make_background(recording: Recording) -> Background:
    """Take the median of pictures spread over the recording; what rests all the time stays in it.

    Where nothing ever changed, one picture is as good.
    """
    looks = _alike(recording)
    medians = [
        (window, usual_picture([cut(look, window) for look in looks])) for window in _ever_changed(recording)
    ]
    whole, deviations = laid_over(looks[len(looks) // 2], medians), []
    for window, usual in medians:
        box = 0, usual[0].shape[0], 0, usual[0].shape[1]
        for look in looks[::3]:
            apart = difference(copied(cut(look, window)), usual, box, (0, 0))
            deviations.append(float(np.median(apart[::3, ::3])))
    noise = 1.4826 * float(np.median(deviations or [0.0]))
    return Background(planes=whole, coarse=coarsely(whole), noise=noise)


def _alike(recording: Recording) -> list[Planes]:
    """Pictures spread over the recording, the camera's drift and all changes of brightness undone."""
    looks = list(recording.looks.values())
    if recording.drift is not None:
        looks = [held_still(look, recording.drift[number]) for number, look in recording.looks.items()]
    first = recording.pictures[0] if len(recording.pictures) == 1 else looks[len(looks) // 2]
    gains = [gain_between(_few(look), _few(first)) for look in looks]
    return [brightened(look, 1 / gain) for look, gain in zip(looks, gains, strict=True)]


def _few(look: Planes) -> Image:
    """Take few pixels of brightness, evenly spread."""
    return np.ascontiguousarray(look[0][::COARSE, ::COARSE])


def _ever_changed(recording: Recording) -> tuple[Window, ...]:
    """Windows outside of which no frame differs from any other; all of the picture if nobody looked."""
    if len(recording.pictures) != 1:
        return (everywhere(recording.size),)
    return ever_changed(recording.kept, recording.size)


def find_blobs(view: View, background: Background) -> list[Blob]:
    """List what differs from the background: each patch whole, and cut at half its own contrast.

    The whole patch is right for a ball whose shaded side is as bright as the wall; the cut one parts a ball
    from its fainter shadow or reflection.
    """
    parts = view.changed
    if parts is None:
        parts = (_whole(view),)
        background = _lit(background, gain_between(parts[0].coarse[0], background.coarse[0]))
    return [blob for part in parts for blob in _blobs_within(part, background)]


def _lit(background: Background, gain: float) -> Background:
    """Show a background as bright as a picture is."""
    planes, coarse = (brightened(look, gain) for look in (background.planes, background.coarse))
    return replace(background, planes=planes, coarse=coarse)


def _whole(view: View) -> Part:
    """Look at few pixels of a whole picture."""
    brightness, blue, red = (np.ascontiguousarray(plane) for plane in view.planes)
    planes = brightness, blue, red
    return Part(everywhere(view.size), planes, coarsely(planes))


def _blobs_within(part: Part, background: Background) -> list[Blob]:
    """List what differs from the background in a part of a picture where a coarse look shows something."""
    (rows, columns), seen, coarse = part
    marks, few = np.zeros_like(coarse[0]), (rows.start // COARSE, columns.start // COARSE)
    mark_changes(coarse, background.coarse, COARSE_SHARE * background.threshold, marks, 1, few)
    places = boxes(marks, BESIDE, seen[0].shape)
    if not places:
        return []
    base, blobs = cut(background.planes, part.window), []
    whole = Whole(background.planes[0].shape, seen, base, (columns.start, rows.start))
    for down, right in places:
        box = down.start, down.stop, right.start, right.stop
        apart = difference(seen, background.planes, box, (rows.start, columns.start))
        corner = columns.start + right.start, rows.start + down.start
        blobs += blobs_in(apart, background.threshold, whole, corner)
    return blobs
