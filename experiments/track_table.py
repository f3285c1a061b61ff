"""The tracks of one recording as CSV."""

import csv
import io
from collections.abc import Sequence

from tracking.track import Track

COLUMNS = ("x", "y", "x_sd", "y_sd", "radius")


def track_table(tracks: Sequence[Track]) -> str:
    """Give one line a frame and ball: in metres, y up; or in pixels, y down, in columns that end in _px."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    unit = "_px" if tracks[0].unit == "px" else ""
    writer.writerow(["frame", "time", "ball", *(f"{name}{unit}" for name in COLUMNS)])
    for track in tracks:
        for frame, time, *numbers in zip(
            track.frame, track.time, track.x, track.y, track.x_sd, track.y_sd, strict=True
        ):
            written = [f"{number:.6g}" for number in (*numbers, track.radius)]
            writer.writerow([int(frame), f"{time:.6f}", track.ball, *written])
    return text.getvalue()
