"""What shifts all frames of a recording alike: the systematic part of an impact's uncertainty.

The scatter of frames around their flights tells nothing of an error they all have in common. Each such error
is therefore put in by itself, one standard deviation large, and what it does to the result is its effect: a
signed number, the same for all recordings with the same camera, balls and air.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from tracking.flight import Flight
from tracking.joint import Meeting, Side

GRAVITY_SD = 0.0015  # of standard gravity: it is 9.78 to 9.83 m/s² on the ground, depending on where
READOUT_SD = 0.1  # of a readout somebody told


@dataclass(frozen=True, slots=True, kw_only=True)
class Budget:
    """Standard uncertainties of what all frames have in common.

    Attributes
    ----------
    drag : float
        Of the drag coefficient, as a share of it; 0 in vacuum.
    air : Flight, optional
        How the balls may fly as well, where the mass is not known and air was left out.
    scale : float
        Of lengths, as a share.
    rate : float
        Of the frame rate, as a share.
    gravity : float
        Of gravity, as a share.
    readout : float
        Of the time between rows that are a metre apart, s/m; positive if upper rows are read first.

    Raises
    ------
    ValueError
        If a share is not within [0, 1).
    """

    drag: float = 0.0
    air: Flight | None = None
    scale: float = 0.0
    rate: float = 0.0
    gravity: float = GRAVITY_SD
    readout: float = 0.0

    def __post_init__(self) -> None:
        for name in ("drag", "scale", "rate", "gravity"):
            if not 0 <= getattr(self, name) < 1:
                raise ValueError(f"{name} must be within [0, 1), got {getattr(self, name)}")

    def changed(self, meeting: Meeting) -> Mapping[str, Meeting]:
        """Give what one standard deviation of each source makes of a meeting, by the source's name."""
        changes: dict[str, Callable[[Side], Side]] = {
            "drag": self._more_drag,
            "air": self._lighter,
            "scale": self._larger,
            "rate": self._slower,
            "gravity": self._heavier,
            "readout": self._later_below,
        }
        meetings = {
            name: replace(meeting, sides=tuple(change(side) for side in meeting.sides))
            for name, change in changes.items()
        }
        if meeting.gap is not None:
            meetings["scale"] = replace(meetings["scale"], gap=meeting.gap * (1 + self.scale))
        return meetings

    def _more_drag(self, side: Side) -> Side:
        flight = side.flight
        slower = flight.terminal_speed / (1 + self.drag) ** 0.5
        return replace(side, flight=Flight(gravity=flight.gravity, terminal_speed=slower))

    def _lighter(self, side: Side) -> Side:
        return replace(side, flight=self.air or side.flight)

    def _larger(self, side: Side) -> Side:
        return replace(side, height=side.height * (1 + self.scale))

    def _slower(self, side: Side) -> Side:
        return replace(side, time=side.time * (1 + self.rate))

    def _heavier(self, side: Side) -> Side:
        more, flight = 1 + self.gravity, side.flight
        return replace(
            side,
            flight=Flight(gravity=flight.gravity * more, terminal_speed=flight.terminal_speed * more**0.5),
        )

    def _later_below(self, side: Side) -> Side:
        return replace(side, time=side.time - self.readout * side.height)


NOTHING_SHARED = Budget(gravity=0.0)
"""As if scale, time base, air and gravity were known exactly: what is left is the frames' own error."""
