"""The page of a run: the verdict first, every failure with its reason, nothing from outside, nothing run."""

import base64
import json
import os
import re
import shutil
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from clips import Clip
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

from calibrate.trials import check_trials, write_trials
from experiments.cli import app
from experiments.record import Record, write_record
from experiments.report import write_report
from experiments.report.axis import axis_around
from experiments.report.chart import chart_of
from experiments.rows import failed_row
from experiments.trial import Trial

SCRIPT = "<script>alert(1)<script>"
HOSTILE = f"{SCRIPT}#b%20?\"'"
TABLE = """kind,approach_velocity,upper_rebound_velocity
plate,-2.0,1.69
plate,-3.0,2.54
plate,-4.0,3.41
"""


def row(name: str, **told: Any) -> dict[str, Any]:
    trial = Trial(name=name, video=Path("x.mp4"), kind="plate")
    velocities = {"approach_velocity": -2.0, "upper_rebound_velocity": 1.7, "residual": 2e-5}
    return failed_row(trial, "") | velocities | {"status": "ok"} | told


def track_of(path: Path) -> pd.DataFrame:
    """A ball that falls and a second one that rests."""
    time = np.arange(40) / 240
    upper = pd.DataFrame({"time": time, "ball": "upper", "x": 0.1, "y": 1 - 4.9 * time**2})
    track = pd.concat([upper, upper.assign(ball="lower", y=0.0)])
    path.parent.mkdir(parents=True, exist_ok=True)
    track.to_csv(path, index=False)
    return track


@pytest.fixture
def out(tmp_path: Path, plate_clip: Clip) -> Path:
    """A run with a good trial of a nasty name, a suspect one, and a failed one whose reason is nasty."""
    rows = [
        row(HOSTILE),
        row("second", status="suspect", reason="gravity reads low; check the scale", approach_velocity=-10.5),
        row("third", status="failed", reason=f"{SCRIPT} is empty; copy it again", approach_velocity=None),
    ]
    write_trials(check_trials(pd.DataFrame(rows)), tmp_path / "trials.csv")
    track = track_of(tmp_path / "tracks" / f"{HOSTILE}.csv")
    upper = track[track["ball"] == "upper"]
    fit = {"ball": "upper"} | {name: upper[name].tolist() for name in ("time", "x", "y")}
    (tmp_path / "overlays").mkdir()
    shutil.copy(plate_clip.path, tmp_path / "overlays" / f"{HOSTILE}.mp4")
    files = [f"tracks/{HOSTILE}.csv", f"overlays/{HOSTILE}.mp4", "javascript:alert(1)"]
    told = {"sha256": "5ea1", "camera": {"readout": SCRIPT}, "version": "0.1.0"}
    write_record(
        Record(
            name=HOSTILE, kind="plate", told=told, rows=rows[:1], files=files, remarks=[SCRIPT], fits=[fit]
        ),
        tmp_path,
    )
    return tmp_path


class Page(HTMLParser):
    """Tags with their attributes, and all text."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        self.text += data


def test_the_page_counts_first_and_tells_every_reason(out: Path) -> None:
    text = Page(write_report(out)).text
    assert text.index("2 of 3 recordings measured") < text.index("What to look at") < text.index("Each trial")
    assert "▲ suspect second: gravity reads low; check the scale" in " ".join(text.split())
    assert "is empty; copy it again" in text
    assert "A State Transition Diagram for Simultaneous Collisions" in text


def test_names_and_reasons_of_strangers_stay_text(out: Path) -> None:
    page = Page(write_report(out))
    assert [tag for tag, _ in page.tags].count("script") == 1
    assert page.text.count(SCRIPT) >= 5
    links = [value for _, told in page.tags for name, value in told.items() if name in ("src", "href")]
    assert "overlays/%3Cscript%3Ealert%281%29%3Cscript%3E%23b%2520%3F%22%27.mp4" in links
    assert all(str(link).startswith(("overlays/", "tracks/", "#", "data:")) for link in links)
    assert not [name for _, told in page.tags for name in told if name.startswith("on")]


def test_the_page_needs_nothing_from_elsewhere(out: Path) -> None:
    text = write_report(out).read_text(encoding="utf-8")
    assert not re.search(r"https?://|@import|url\(", text)
    assert "connect-src 'none'" in text


def test_a_fit_comes_first_with_its_figures_within_the_page(tmp_path: Path) -> None:
    (tmp_path / "trials.csv").write_text(TABLE)
    (tmp_path / "fig5.svg").write_text("<svg xmlns='http://www.w3.org/2000/svg'/>")
    done = CliRunner().invoke(app, ["fit", str(tmp_path / "trials.csv"), "--out", str(tmp_path), "--json"])
    assert json.loads(done.stdout)["fit"]["restitution_ball_table"]["verdict"] == "one value"
    page = Page(tmp_path / "report.html")
    assert page.text.index("Stiffness ratio k₂/k₁") < page.text.index("3 of 3 recordings measured")
    pictures = [str(told["src"]) for tag, told in page.tags if tag == "img"]
    assert [base64.b64decode(picture.split(",")[1])[:4] for picture in pictures] == [b"<svg"]
    assert "impactlab" in json.loads((tmp_path / "run.json").read_text())["fit"]["command"]
    assert "another trials.csv" not in page.text
    (tmp_path / "trials.csv").write_text(TABLE + "plate,-3.0,2.55\n")
    assert "made from another trials.csv" in Page(write_report(tmp_path)).text


def test_a_record_of_another_run_is_not_shown_as_this_ones(out: Path) -> None:
    rows = [row(HOSTILE, status="failed", reason="it took longer than 3 s")]
    write_trials(check_trials(pd.DataFrame(rows)), out / "trials.csv")
    assert "video" not in [tag for tag, _ in Page(write_report(out)).tags]


def test_a_folder_without_results_is_refused(tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["report", str(tmp_path)])
    assert done.exit_code == 2
    assert "holds no results; name the folder that process or fit wrote to" in done.stderr


def test_the_same_run_gives_the_same_page(out: Path) -> None:
    assert write_report(out).read_bytes() == write_report(out).read_bytes()


def test_a_chart_shows_all_balls_and_what_is_left_between_seen_and_fitted(tmp_path: Path) -> None:
    track = track_of(tmp_path / "t.csv")
    upper = track[track["ball"] == "upper"]
    fit = {"ball": "upper", "time": upper["time"], "x": upper["x"], "y": upper["y"] + 0.001}
    chart = chart_of(track, [fit], "plate")
    assert list(chart.balls) == ["upper", "lower"]
    seen, left = chart.panels
    assert [ball for ball, _ in seen.dots] == [0, 1]
    assert left.titles[1] == "seen - fit [mm]"
    assert len({part.split()[1] for part in left.dots[0][1][1:].split("M")}) == 1
    assert "-1" in [text for _, text in left.ticks[1]]
    assert len(chart_of(track, [], "plate").panels) == 1
    on_table = chart_of(track.rename(columns={"x": "x_px", "y": "y_px"}), [], "shot").panels[0]
    assert on_table.titles == ("x [px]", "y [px]")


@given(st.lists(st.floats(-1e6, 1e6), max_size=5))
def test_an_axis_holds_its_numbers_and_marks_some(values: list[float]) -> None:
    axis = axis_around(np.array(values), 0.0, 100.0)
    assert all(0 <= place <= 100 for place in axis.places(np.array(values)))
    assert 1 <= len(axis.ticks()) <= 8
    assert all(-1e-6 <= place <= 100 + 1e-6 for place, _ in axis.ticks())


@pytest.fixture
def browser() -> Iterator[Any]:
    """A Chromium: playwright's own, one that is installed, or the one the variable CHROMIUM names."""
    playwright = pytest.importorskip("playwright.sync_api")
    names = ("chromium", "chromium-browser", "google-chrome", "chrome")
    found = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, names)), None)
    with playwright.sync_playwright() as running:
        try:
            chromium = running.chromium.launch(executable_path=found, args=["--no-sandbox"])
        except playwright.Error as error:
            pytest.skip(f"no browser: {str(error).splitlines()[0]}")
        yield chromium
        chromium.close()


@pytest.mark.slow
@pytest.mark.parametrize("width", [1280, 400])
def test_in_a_browser_it_is_quiet_sorts_plays_and_fits_the_width(out: Path, browser: Any, width: int) -> None:
    page = browser.new_page(viewport={"width": width, "height": 800})
    said: list[str] = []
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    page.on("dialog", lambda dialog: said.append(dialog.message))
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url.split(":")[0]))
    page.goto(write_report(out).as_uri())
    speeds = "[...document.querySelectorAll('tbody tr')].map(row => row.cells[4].textContent)"
    page.get_by_role("button", name="before m/s").click()
    assert page.evaluate(speeds) == ["-10.5000", "-2.0000", ""]
    page.get_by_role("button", name="before m/s").click()
    assert page.evaluate(speeds) == ["-2.0000", "-10.5000", ""]
    page.locator("tbody a").first.click()
    film = page.locator("details[open] video")
    moved = (
        "new Promise(done => film.addEventListener('timeupdate', () => film.currentTime > 0.05 && done(1)))"
    )
    assert film.evaluate(f"film => {{ const moved = {moved}; film.play(); return moved; }}") == 1
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert said == []
    assert set(asked) <= {"file", "data"}
