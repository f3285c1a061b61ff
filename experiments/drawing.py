"""The one way this project draws: colours, sizes, and files that are the same, byte for byte, every time."""

import io
from collections.abc import Sequence
from contextlib import AbstractContextManager
from pathlib import Path

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from calibrate.files import write_whole

UPPER, LOWER = "#0072B2", "#D55E00"  # blue and vermilion of Okabe and Ito: told apart by colour-blind eyes
QUIET, DARK = "#8a8a8a", "#222222"
SEGMENTS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00")
_NAMELESS = {
    "svg": {"Date": None, "Creator": None},
    "png": {"Software": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}


def new_figure(
    width: float, height: float, rows: int = 1, columns: int = 1, *, shares: Sequence[float] | None = None
) -> tuple[Figure, list[list[Axes]]]:
    """Make a figure of a size in inches with a grid of axes, by row and column; `shares`: rows' heights."""
    with _settings():
        figure = Figure(figsize=(width, height), layout="constrained")
        grid = figure.subplots(rows, columns, squeeze=False, height_ratios=shares)
    return figure, [list(row) for row in grid]


def save_figure(figure: Figure, path: str | Path) -> Path:
    """Write a figure, whole or not at all; its suffix (svg, png, pdf) says as what.

    Raises
    ------
    ValueError
        If the suffix is another one.
    """
    path = Path(path)
    kind = path.suffix.lower().removeprefix(".")
    if kind not in _NAMELESS:
        raise ValueError(f"plot must be a file name ending in .svg, .png or .pdf, got {path.name!r}")
    content = io.BytesIO()
    with _settings():
        figure.savefig(content, format=kind, dpi=150, metadata=_NAMELESS[kind])
    return write_whole(path, content.getvalue())


def save_both(figure: Figure, out: Path, name: str) -> None:
    """Write a figure as SVG and PNG."""
    for suffix in ("svg", "png"):
        save_figure(figure, out / f"{name}.{suffix}")


def label(axes: Axes, texts: Sequence[str]) -> None:
    """Set x label, y label and title."""
    horizontal, vertical, title = texts
    axes.set_xlabel(horizontal)
    axes.set_ylabel(vertical)
    axes.set_title(title, loc="left")


def _settings() -> AbstractContextManager[None]:
    return matplotlib.rc_context(
        {
            "font.size": 9.0,
            "axes.spines.top": False,
            "axes.spines.right": False,
            "axes.titlesize": 10.0,
            "svg.hashsalt": "impactlab",
        }
    )
