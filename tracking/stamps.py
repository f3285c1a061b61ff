"""Time stamps of stored frames → times of capture, and which stored frames are pictures of their own."""

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from tracking.errors import RecordingError

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

CAPTURE_RATE_TAGS = ("com.android.capture.fps", "com.apple.quicktime.capture-fps", "capture_fps")
FASTEST_CAMERA = 1e6  # frames/s
CLOCK_SD = 1e-4  # of a rate that time stamps tell: a camera's crystal, not trimmed
NOMINAL_RATE_SD = 2e-3  # of a rate that a person or a tag tells: "240" may be 239.76, or 240.5
RATE_TOLERANCE = 0.02  # a tag this close to the file's own rate says nothing new
REPEAT_LEVEL = 4.0  # grey levels: two encodings of one picture differ by less
REPEAT_SHARE = 0.2  # ... and by less than this share of what a genuine neighbour differs by
MOVING_LEVEL = 6.0  # grey levels: where nothing changes by more, nobody can tell
REPEATS_TO_BELIEVE = 0.1  # at the top of a bounce two pictures may look alike by chance


def fill_stamps(stamps: Sequence[float | None], name: str) -> tuple[FloatArray, list[str]]:
    """Fill missing time stamps from the regular interval.

    Parameters
    ----------
    stamps : time stamp of every stored frame, s; None where the file gives none
    name : what the recording is called

    Returns
    -------
    (n,) array, list of str
        Rising times, s, and what to say about them.

    Raises
    ------
    RecordingError
        If there are fewer than two stamps, or they do not rise.
    """
    times = np.array([np.nan if stamp is None else stamp for stamp in stamps])
    index = np.arange(len(times))
    known = np.flatnonzero(np.isfinite(times))
    if len(known) < 2:
        raise RecordingError(f"{name}: carries no time stamps; convert it once with a video tool")
    steps = np.diff(times[known]) / np.diff(known)
    if np.any(steps <= 0):
        raise RecordingError(f"{name}: its time stamps do not rise; convert it once with a video tool")
    if len(known) == len(times):
        return times, []
    first, last, step = known[0], known[-1], float(np.median(steps))
    times = np.interp(index, known, times[known])
    times[:first] = times[first] + step * (index[:first] - first)
    times[last:] = times[last] + step * (index[last:] - last)
    missing = len(times) - len(known)
    return times, [f"{missing} frames had no time stamp; filled in from the regular interval"]


def tagged_fps(tags: Mapping[str, str]) -> float | None:
    """Read the capture rate (frames/s) that phones write beside slow motion; None where there is none.

    Examples
    --------
    >>> tagged_fps({"com.android.capture.fps": "240.000000"})
    240.0
    """
    for name in CAPTURE_RATE_TAGS:
        try:
            rate = float(tags[name])
        except (KeyError, ValueError):
            continue
        if 0 < rate <= FASTEST_CAMERA:
            return rate
    return None


def time_factor(times: FloatArray, tagged: float | None, given: float | None) -> tuple[float, list[str]]:
    """Seconds of capture per second of the file, and what to say about it.

    Parameters
    ----------
    times : (n,) array
        Time stamps of the genuine frames, s.
    tagged, given : float or None
        Frames captured a second as a tag in the file and as the person tells it; the person is believed.

    Examples
    --------
    >>> time_factor(np.arange(5) / 30, 240.0, None)
    (0.125, ['captured at 240 frames/s (a tag in the file) but stored at 30'])
    """
    file_fps = float(1 / np.median(np.diff(times)))
    fps = given if given is not None else tagged
    if fps is None or abs(fps / file_fps - 1) < RATE_TOLERANCE:
        return 1.0, []
    source = "--capture-fps" if given is not None else "a tag in the file"
    return file_fps / fps, [f"captured at {fps:g} frames/s ({source}) but stored at {file_fps:.4g}"]


def find_genuine(changes: FloatArray) -> tuple[BoolArray, list[str]]:
    """Tell pictures from repeats: a repeat changes nothing while its neighbours change a lot.

    Parameters
    ----------
    changes : (n,) array
        How much each stored frame differs from the one before it, grey levels; the first is infinite.

    Returns
    -------
    (n,) array of bool, list of str
        False where a frame stores its predecessor's picture again; what to say about it.
    """
    padded = np.pad(np.where(np.isfinite(changes), changes, 0.0), 3)
    around = np.lib.stride_tricks.sliding_window_view(padded, 7).max(axis=1)
    repeats = (changes < REPEAT_LEVEL) & (changes < REPEAT_SHARE * around) & (around > MOVING_LEVEL)
    count, total = int(repeats.sum()), len(changes)
    if count < max(3, REPEATS_TO_BELIEVE * total):
        return np.ones(total, dtype=bool), []
    return ~repeats, [f"{count} of {total} frames store the picture before them again; they were left out"]
