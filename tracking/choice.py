"""Which path through the candidates is the ball, and how large it is: as it was told, or measured."""

from collections.abc import Mapping

import numpy as np

from tracking.blob import Blob
from tracking.candidates import Candidates
from tracking.errors import RecordingError
from tracking.partial import is_unlike
from tracking.path import MISSING, best_path, guess_radius
from tracking.recording import Recording
from tracking.size import measure_radius

FEWEST_FRAMES = 8
KEPT = 0.55  # of the frames of a path are found again with the right radius,
NEARLY_ALL = 0.9  # and this share of them unless the patch that was followed is of another size by itself
CLEARER = 0.7  # times as vague: an outline that is believed rather than that of a patch by itself
ASTRAY = 0.02  # of the frames that two paths share
LIT = 1.8  # times the radius of its lit side: no ball is larger
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
    if radius is None:
        return _measured(*_find_ball(recording, candidates), candidates, around)
    return _told(recording, candidates, around, radius), radius


def _find_ball(
    recording: Recording, candidates: Candidates, radius: float | None = None
) -> tuple[dict[int, Blob], float]:
    """Choose the ball among the candidates of every frame, and its radius if it was not given."""
    radius = guess_radius(list(candidates.values())) if radius is None else radius
    path = {} if radius is None else choose_path(candidates, radius)
    if radius is None or not path:
        raise _none_found(recording)
    return path, radius


def _none_found(recording: Recording) -> RecordingError:
    """Say that there is no ball, and what helps."""
    return RecordingError(
        f"{recording.path.name}: no ball found that moves through the picture; film a plain ball against "
        "a background of another colour, whole and in focus, with more frames a second if it is very "
        "fast, and check --ball-diameter and the scale"
    )


def _told(recording: Recording, candidates: Candidates, around: Recording, radius: float) -> dict[int, Blob]:
    """Choose the path of a ball whose radius was told; it may be seen by patches of another size."""
    path = choose_path(candidates, radius)
    rough = guess_radius(list(candidates.values())) if not path or is_unlike(path.values(), radius) else None
    other = {} if rough is None else choose_path(candidates, rough)
    if rough is not None and len(other) > len(path):
        measured, _ = measure_radius(around, candidates, other, rough)
        if abs(measured / radius - 1) < OWN_SIZE:
            return other
    if not path:
        raise _none_found(recording)
    return path


def _measured(
    path: dict[int, Blob], rough: float, candidates: Candidates, recording: Recording
) -> tuple[dict[int, Blob], float]:
    """Measure the radius of the ball on a path, and choose the path again by it.

    A ball that is seen by patches of another size keeps its path if the other goes astray. A radius that
    loses the path is that of something else; and what is round and as large as its patch is not part of
    something larger, unless that is seen wherever it was, or far more clearly.
    """
    radius, scatter = measure_radius(recording, candidates, path, rough)
    again, unlike = choose_path(candidates, radius), is_unlike(path.values(), radius)
    kept = path if unlike and _strays(again, path, radius) else again
    if len(again) >= NEARLY_ALL * len(path):
        return kept, radius
    alone, vague = measure_radius(recording, candidates, path, rough, part=False)
    if len(again) >= KEPT * len(path) and abs(alone / rough - 1) > OWN_SIZE:
        return kept, radius
    if unlike and radius < LIT * rough and scatter < CLEARER * vague:
        return path, radius
    return _find_ball(recording, candidates, alone)


def _strays(path: Mapping[int, Blob], other: Mapping[int, Blob], radius: float) -> bool:
    """Whether a path leaves another one by more than a radius, px, in some frames, or altogether."""
    apart = [np.hypot(path[k].x - other[k].x, path[k].y - other[k].y) for k in path.keys() & other.keys()]
    return not apart or float(np.mean(np.array(apart) > radius)) > ASTRAY


def choose_path(candidates: Candidates, radius: float) -> dict[int, Blob]:
    """Choose the path of a ball of some radius, px; empty if it is seen in too few frames."""
    blobs = list(candidates.values())
    chosen = zip(candidates, blobs, best_path(blobs, radius), strict=True)
    path = {number: seen[index] for number, seen, index in chosen if index != MISSING}
    return path if len(path) >= FEWEST_FRAMES else {}
