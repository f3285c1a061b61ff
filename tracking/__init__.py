"""Recordings → velocities just before and just after an impact, each with its uncertainty.

The way of a recording through the room, one file a step:

===============  ========================================================================
`decode`         the only file that decodes: a file → pictures as planes
`video`          frames with true time stamps and the capture rate; read once
`kept`           what changes from frame to frame, kept in memory
`steady`         the drift of a camera held in a hand, undone
`detect`         a picture → patches that differ from the background; `blob` describes them
`path`           patches of all pictures → the one path that is the ball's
`circle`         the ball's rim to a fraction of a pixel
`size`           how large a ball of unknown size is
`sight`          rims and circles in many frames at once; `resting` those of a ball that is struck
`kernel`         the door to the compiler: rims, limbs, paths and coarse looks are compiled loops
`track`          all of these → one `Track` per ball, in pixels
`depth`          motion towards the camera, seen in the ball's size and undone
`scale`          pixels, y down → metres, y up
`bounce`         where in a track the impacts lie
`flight`         how a ball flies through air, in closed form
`joint`          flights that meet at an impact, fitted together
`hop`            how fast a ball leaves the plate that hardly leaves it
`budget`         what scale, air, rate, gravity and readout may do to all frames alike
`velocity`       `Track` → `Impact`: velocities, covariance, gravity check
`strike`         a cue shot: the ball that is struck, and the cue's tip; `shot` measures it
`pair`           two discs that meet; `pair_impact` measures them
`overlay`        what was found, to be drawn on the recording; `overlay_film` draws it
`render`         synthetic recordings with known truth
===============  ========================================================================

>>> from tracking import Air, flight_of_ball, scale_from_metres_per_pixel
>>> print(round(flight_of_ball(0.0027, 0.020, Air()).gravity, 3), scale_from_metres_per_pixel(0.0008).source)
9.589 given: 0.8 mm/px

A measurement by hand::

    recording = open_recording("drop.mp4")
    (ball,) = track_balls(recording)
    ball = to_metres(ball, scale_from_ball(ball, 0.040))
    for impact in measure_impacts(ball, flight_of_ball(0.0027, 0.020, Air())):
        print(impact.velocities, impact.sd, impact.gravity_check)
"""

from tracking.errors import RecordingError
from tracking.flight import VACUUM, Air, Flight, flight_of_ball
from tracking.scale import (
    Scale,
    scale_from_ball,
    scale_from_corners,
    scale_from_metres_per_pixel,
    scale_from_points,
    to_metres,
)
from tracking.track import Track, track_balls
from tracking.velocity import Impact, measure_impacts, measure_two_ball_impact
from tracking.video import Frame, Recording, open_recording, read_frames

__all__ = [
    "VACUUM",
    "Air",
    "Flight",
    "Frame",
    "Impact",
    "Recording",
    "RecordingError",
    "Scale",
    "Track",
    "flight_of_ball",
    "measure_impacts",
    "measure_two_ball_impact",
    "open_recording",
    "read_frames",
    "scale_from_ball",
    "scale_from_corners",
    "scale_from_metres_per_pixel",
    "scale_from_points",
    "to_metres",
    "track_balls",
]
