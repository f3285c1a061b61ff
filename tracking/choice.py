"""Which path through the candidates is the ball, and how large it is: as it was told, or measured."""

from collections.abc import Mapping

import numpy as np

from tracking.blob import Blob
from tracking.candidates import Candidates
from tracking.errors import RecordingError
from tracking.fall import goes_on
from tracking.partial import is_unlike
from tracking.path import MISSING, best_path, guess_radius
from tracking.recording import Recording
from tracking.size import measure_radius

FEWEST_FRAMES = 8
KEPT = 0.55  # of the frames of a path are found again with the right radius,
NEARLY_ALL = 0.9  # and this share of them unless the patch that was followed is of another size by itself
CLEARER = 0.7  # times as vague: an outline that is believed rather than that of a patch by itself
LIT_SIDES = (0.85, 0.7, 0.55)  # of a ball's size: that of its lit side, where its dark one is like the wall
LIT = 1.8  # times the radius of its lit side: no ball is larger
ASTRAY = 0.02  # of the frames that two paths share: if they are apart in more, one leads to something else
MOSTLY = 0.9  # of the frames in which a path goes on: one along the same way is as good if it does in as many
OWN_SIZE = 0.1  # share by which a patch's own outline may differ from its width


def choose_ball(
    recording: Recording, candidates: Candidates, around: Recording, radius: float | None
) -> tuple[dict[int, Blob], float]:
    """Choose the patches that are the ball, by the number of the frame, and its radius, px.

    Parameters
    ----------
    recording : Recording
    candidates : all patches that differ from the background
    around : recording that remembers what is around them
    radius : float or None
        As it was told; measured if it was not.

    Raises
    ------
    RecordingError
        If nothing round moves through the picture.
    """
    rough = guess_radius(list(candidates.values()))
    if radius is None and rough is not None:
        radius = _measured(candidates, around, rough)
    path = {} if radius is None else _path_of(candidates, around, radius, rough)
    if radius is None or not path:
        raise RecordingError(
            f"{recording.path.name}: no ball found that moves through the picture; film a plain ball against "
            "a background of another colour, whole and in focus, with more frames a second if it is very "
            "fast, and check --ball-diameter and the scale"
        )
    return path, radius


def _path_of(
    candidates: Candidates, recording: Recording, radius: float, rough: float | None
) -> dict[int, Blob]:
    """Choose the path of a ball of some radius, which may be seen by patches of another size.

    Another ball rests, and stray patches leap about. So a path that goes on in more frames is the ball's, if
    what moves there is as large as the ball.
    """
    sizes = [share * radius for share in LIT_SIDES]
    sizes += [rough] if rough is not None and rough > radius / LIT else []
    path = choose_path(candidates, radius)
    for size in sizes:
        other = choose_path(candidates, size)
        if _is_rather_the_ball(other, path, radius):
            measured, _ = measure_radius(recording, candidates, other, size)
            path = other if abs(measured / radius - 1) < OWN_SIZE else path
    return path


def _measured(candidates: Candidates, recording: Recording, rough: float) -> float:
    """Measure the radius of the ball that goes through a recording in patches of a rough radius, px.

    A radius that loses the path is that of something else; and what is round and as large as its patch is not
    part of something larger, unless that is seen wherever it was, or far more clearly.
    """
    path = choose_path(candidates, rough)
    if not path:
        return rough
    radius, scatter = measure_radius(recording, candidates, path, rough)
    again = choose_path(candidates, radius)
    if len(again) >= NEARLY_ALL * len(path):
        return radius
    alone, vague = measure_radius(recording, candidates, path, rough, part=False)
    if len(again) >= KEPT * len(path) and abs(alone / rough - 1) > OWN_SIZE:
        return radius
    if is_unlike(path.values(), radius) and radius < LIT * rough and scatter < CLEARER * vague:
        return radius
    return alone


def _is_rather_the_ball(other: Mapping[int, Blob], path: Mapping[int, Blob], radius: float) -> bool:
    """Whether another path goes on in more frames than a path, or in many more if both are along one way."""
    if not other or not path:
        return bool(other)
    apart = [np.hypot(path[k].x - other[k].x, path[k].y - other[k].y) for k in path.keys() & other.keys()]
    elsewhere = not apart or float(np.mean(np.array(apart) > radius)) > ASTRAY
    return (1.0 if elsewhere else MOSTLY) * goes_on(other, radius) > goes_on(path, radius)


def choose_path(candidates: Candidates, radius: float) -> dict[int, Blob]:
    """Choose the path of a ball of some radius, px; empty if it is seen in too few frames."""
    blobs = list(candidates.values())
    chosen = zip(candidates, blobs, best_path(blobs, radius), strict=True)
    path = {number: seen[index] for number, seen, index in chosen if index != MISSING}
    return path if len(path) >= FEWEST_FRAMES else {}
