"""Time stamps of stored frames → times of capture."""

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from tracking.errors import RecordingError

FloatArray = npt.NDArray[np.float64]

CAPTURE_RATE_TAGS = ("com.android.capture.fps", "com.apple.quicktime.capture-fps", "capture_fps")
FASTEST_CAMERA = 1e6  # frames/s
CLOCK_SD = 1e-4  # of a rate that time stamps tell: a camera's crystal, not trimmed
NOMINAL_RATE_SD = 2e-3  # of a rate that a person or a tag tells: "240" may be 239.76, or 240.5
RATE_TOLERANCE = 0.02  # a tag this close to the file's own rate says nothing new
RAMP = 1.2  # intervals that grow by more than this within a recording: a part of it is slow motion
RAMP_FRAMES = 9  # over which intervals are compared: single stamps are late or early
DROPPED = 1.6  # intervals: a longer pause means that a frame is missing


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


def time_factor(
    times: FloatArray, tagged: float | None, given: float | None, name: str
) -> tuple[float, list[str]]:
    """Seconds of capture per second of the file, and what to say about it.

    Parameters
    ----------
    times : (n,) array
        Time stamps of the genuine frames, s.
    tagged, given : float or None
        Frames captured a second as a tag in the file and as the person tells it; the person is believed.
    name : str
        What the recording is called.

    Raises
    ------
    RecordingError
        If only a part of the recording is slow motion: one rate of capture cannot be true of all of it.

    Examples
    --------
    >>> time_factor(np.arange(5) / 30, 240.0, None, "drop.mp4")
    (0.125, ['captured at 240 frames/s (a tag in the file) but stored at 30'])
    """
    file_fps = float(1 / np.median(np.diff(times)))
    fps = given if given is not None else tagged
    if fps is None or abs(fps / file_fps - 1) < RATE_TOLERANCE:
        return 1.0, []
    source = "--capture-fps" if given is not None else "a tag in the file"
    shortest, longest = _usual_intervals(times)
    if longest > RAMP * shortest:
        raise RecordingError(
            f"{name}: captured at {fps:g} frames/s ({source}), but its frames are stored "
            f"{1e3 * shortest:.3g} to {1e3 * longest:.3g} ms apart: a part of it is slow motion; export it "
            "at one rate throughout"
        )
    return file_fps / fps, [f"captured at {fps:g} frames/s ({source}) but stored at {file_fps:.4g}"]


def _usual_intervals(times: FloatArray) -> tuple[float, float]:
    """Shortest and longest interval, s, of medians over `RAMP_FRAMES`."""
    intervals = np.diff(times)
    width = min(RAMP_FRAMES, len(intervals))
    medians = np.median(np.lib.stride_tricks.sliding_window_view(intervals, width), axis=1)
    return float(medians.min()), float(medians.max())


def missing_frames(times: FloatArray) -> list[str]:
    """Say that frames are missing where single intervals are longer than the others.

    Examples
    --------
    >>> missing_frames(np.array([0, 1, 2, 3, 5, 6, 7]) / 30)
    ['1 frame is missing between the others; nothing was filled in']
    """
    intervals = np.diff(times)
    usual = float(np.median(intervals))
    pauses = intervals[intervals > DROPPED * usual]
    count = int(np.sum(np.round(pauses / usual) - 1))
    if not count or len(pauses) > max(1, 0.1 * len(intervals)):
        return []
    verb = "frame is" if count == 1 else "frames are"
    return [f"{count} {verb} missing between the others; nothing was filled in"]
