"""What is said about a recording that cannot be used."""


class RecordingError(ValueError):
    """A recording cannot be used; the message names it, the reason and the remedy."""
