"""Tables of ours against the paper's numbers."""

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Compared:
    """One number of ours beside the paper's (or, where the paper shows only a curve, the reference's)."""

    quantity: str
    ours: float
    printed: float

    @property
    def difference(self) -> float:
        """Ours less printed."""
        return self.ours - self.printed


def comparison_text(title: str, rows: Sequence[Compared]) -> str:
    """Print a comparison as a table.

    Examples
    --------
    >>> print(comparison_text("Fig. 4", [Compared(quantity="energy loss [J]", ours=1.24936, printed=1.2494)]))
    Fig. 4                  ours     printed  difference
    energy loss [J]      1.24936      1.2494      -4e-05
    """
    width = max(16, len(title), *(len(row.quantity) for row in rows))
    lines = [f"{title:{width}} {'ours':>11} {'printed':>11} {'difference':>11}"]
    lines += [
        f"{row.quantity:{width}} {row.ours:>11.7g} {row.printed:>11.7g} {row.difference:>11.2g}"
        for row in rows
    ]
    return "\n".join(lines)
