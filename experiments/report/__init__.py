"""The page of a run: what was measured, what failed and why, what the fit says, and how to do it again.

================  ==========================================================
`contents`        the folder of a run → what the page shows, as `views`
`numbers`         columns of the trial table → words with units
`chart`           a track, its fit and what is left between them → drawings; `axis`: one axis of them
`templates/`      the page itself; whatever they print is escaped
================  ==========================================================
"""

import base64
import hashlib
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from calibrate.files import write_whole
from experiments.report.contents import contents_of

__all__ = ["write_report"]


def write_report(out: Path) -> Path:
    """Write `out`/report.html from what lies in `out`: one file, but for films and their sheets.

    Parameters
    ----------
    out : Path
        Folder of a run of `process`, of `fit`, or of both.

    Returns
    -------
    Path
        The page.

    Raises
    ------
    ExperimentError
        If the folder holds nothing to report.
    """
    templates = PackageLoader("experiments.report")
    pages = Environment(
        loader=templates,
        autoescape=True,  # names and reasons come from strangers' files
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    script, _, _ = templates.get_source(pages, "report.js")
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    page = pages.get_template("report.html").render(
        page=contents_of(out), script=Markup(script), script_hash=digest
    )
    return write_whole(out / "report.html", page)
