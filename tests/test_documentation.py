"""What the pages show is what happens: commands, programs, numbers and links."""

import contextlib
import io
import re
import shlex
from pathlib import Path
from shutil import copytree

import pytest
import typer
from clips import Clip
from documented import (
    EXPERIMENT_FILE,
    FILMING,
    FITTING,
    HOME,
    NOTES,
    PAGES,
    README,
    REPRODUCTION,
    blocks,
    commands,
    lay_out,
    programs,
)
from typer.testing import CliRunner

from calibrate.sentences import Note
from calibrate.setup import Setup
from calibrate.trials import read_trials
from experiments import fig4, fig5
from experiments.cli import app
from experiments.experiment import read_experiment
from experiments.process import measure
from experiments.trial import Body, Camera, Trial

PROCESS = "impactlab process drops/ --kind plate --ball-diameter 0.040 --ball-mass 0.0027"
QUICK = {
    f"{PROCESS} --out out",
    "impactlab report out",
    "impactlab simulate drop --stiffness-ratio 10 --plot drop.svg",
    "impactlab simulate shot --offset 0.3 -0.2 --elevation 20 --speed 2 --plot shot.svg",
    "impactlab simulate trials --stiffness-ratio 10 --mass-ratio 1 --mass-ratio 2 --out simulated.csv",
}
SLOW = {
    f"{PROCESS} --readout 0.004 --out out",
    f"{PROCESS} --start-px 100 120 --out out",
    f"{PROCESS.replace('drops/', 'slow/')} --capture-fps 240 --out out",
    "impactlab bench --coverage 200",
    "impactlab demo --out demo",
    "impactlab figures --out figures",
    "impactlab figures fig4 --out figures",
    "impactlab fit heights.csv --ball ping-pong=0.0027,0.040 --out out",
    "impactlab fit out/trials.csv --out out",
    "impactlab fit shots.csv --shot-ball 0.17 0.05715 --cue-mass 0.54 --fix tip_ball_friction=0.6 --out out",
    "impactlab fit trials.csv --ball-ball 0.807755 0.0212 --ball-table 0.846529 0.0208 --out out",
    "impactlab fit trials.csv --force-law --contours --bootstrap 200 --out out",
    "impactlab plan --mass 0.0027 --mass 0.0054",
    "impactlab plan --mass 0.0027 --mass 0.0054 --fps 240 --two 10 --held 8 --plate 8",
    "impactlab process experiment.toml --out out",
}
RUNS_THESE_TESTS = {"python -m pytest -n auto"}
GIVEN = Camera(scale={"metres_per_pixel": 0.0008})
LIGHTER = {"--coverage 200": "--coverage 1", "--bootstrap 200": "--bootstrap 3"}
"""Repetitions that cost time and show nothing new."""


@pytest.fixture(scope="module")
def files(plate_clip: Clip, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Small stand-ins for the files that the pages speak of."""
    folder = tmp_path_factory.mktemp("files")
    lay_out(folder, plate_clip)
    return folder


@pytest.fixture
def desk(files: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Folder to work in, with a copy of the files."""
    copytree(files, tmp_path / "desk")
    monkeypatch.chdir(tmp_path / "desk")
    return tmp_path / "desk"


def printed_by(command: str) -> str:
    for heavy, light in LIGHTER.items():
        command = command.replace(heavy, light)
    result = CliRunner().invoke(app, shlex.split(command)[1:])
    assert result.exit_code == 0, result.output
    return result.stdout


def printed_by_program(program: str) -> str:
    output = io.StringIO()
    with contextlib.redirect_stdout(output):
        exec(compile(program, "program of a page", "exec"), {"__name__": "page"})
    return output.getvalue()


def test_every_command_of_the_pages_is_known_and_none_is_forgotten() -> None:
    assert set(commands()) == QUICK | SLOW | RUNS_THESE_TESTS


@pytest.mark.usefixtures("desk")
@pytest.mark.parametrize("command", sorted(QUICK))
def test_command_does_what_the_page_says(command: str) -> None:
    assert printed_by(command)


@pytest.mark.slow
@pytest.mark.usefixtures("desk")
@pytest.mark.parametrize("command", sorted(SLOW))
def test_longer_command_does_what_the_page_says(command: str) -> None:
    assert printed_by(command)


@pytest.mark.parametrize("page", [README, EXPERIMENT_FILE], ids=lambda page: page.name)
def test_experiment_file_shown_is_understood(desk: Path, page: Path) -> None:
    (shown,) = blocks(page, "toml")
    (desk / "shown.toml").write_text(shown, encoding="utf-8")
    trials = {trial.name: trial for trial in read_experiment(desk / "shown.toml")}
    assert trials["heavy-1"].body("upper") == Body(mass=0.0054, diameter=0.040)
    assert trials["plate-1"].body("upper") == Body(mass=0.0027, diameter=0.040)


@pytest.mark.slow
def test_all_recordings_of_the_experiment_file_shown_are_measured(desk: Path) -> None:
    printed_by("impactlab process experiment.toml --out out")
    table = read_trials(desk / "out" / "trials.csv")
    assert table["status"].eq("ok").all(), table["reason"].tolist()
    assert table["trial"].tolist() == ["plate-1", "held-1", "equal-1", "heavy-1", "late"]


@pytest.mark.usefixtures("desk")
@pytest.mark.parametrize(
    ("program", "shown"),
    [
        pytest.param(*pair, marks=[pytest.mark.slow] if "fit_stiffness_ratio" in pair[0] else [])
        for pair in programs()
    ],
)
def test_program_runs_and_prints_what_is_shown_below_it(program: str, shown: str) -> None:
    printed = printed_by_program(program)
    assert printed
    assert not shown or printed == shown


def test_every_option_that_a_page_names_exists() -> None:
    others = {"--editable", "-vf"}
    for page in PAGES:
        named = set(re.findall(r"(?<![\w-])--[a-z][a-z-]*", page.read_text(encoding="utf-8")))
        assert named <= options_of(typer.main.get_command(app)) | others, page.name


def options_of(command: object) -> set[str]:
    own = {name for parameter in getattr(command, "params", ()) for name in parameter.opts}
    below = getattr(command, "commands", {}).values()
    return own.union(*(options_of(each) for each in below))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    links = re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8"))
    assert all((page.parent / link).exists() for link in links if "://" not in link)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_pages_are_short(page: Path) -> None:
    assert len(page.read_text(encoding="utf-8").splitlines()) <= (120 if page == README else 150)


def test_table_of_frame_rates_is_what_the_planner_reckons_with() -> None:
    rows = re.findall(r"^\| (0\.\d) m \| (\S+) m/s \| (.*) \|$", FILMING.read_text(encoding="utf-8"), re.M)
    assert len(rows) == 4
    for height, speed, cells in rows:
        drop = float(height)
        fall = (2 * 9.80665 * drop) ** 0.5
        assert speed == f"{fall:.2f}"
        for fps, cell in zip((60, 120, 240, 480), cells.split(" | "), strict=True):
            scatter = Setup(fps=fps, heights=(drop,), repeatability=1e-9).rebound_scatter((0.8, 0.2))[1] / 0.2
            assert cell == f"{1e3 * fall / fps:.0f} mm, {scatter:.2%}".replace("%", " %")


def test_comparisons_shown_are_those_that_figures_prints(tmp_path: Path) -> None:
    shown = blocks(REPRODUCTION, "text")
    assert shown == [f"{figure.main(tmp_path)}\n" for figure in (fig4, fig5)]


@pytest.mark.slow
def test_shares_of_table_1_are_those_that_figures_prints(tmp_path: Path) -> None:
    from experiments import table1

    printed = re.findall(r"([\d.]+)%  S", table1.main(tmp_path))
    rows = re.findall(r"^\| \w+ ((?:\| [\d.]+ % ){4})\|$", REPRODUCTION.read_text(encoding="utf-8"), re.M)
    assert [share for row in rows for share in re.findall(r"([\d.]+) %", row)] == printed


@pytest.mark.slow
def test_fits_shown_are_those_that_fit_prints(desk: Path) -> None:
    (shown,) = blocks(FITTING, "text")
    both = printed_by("impactlab fit trials.csv")
    assert re.findall(r"`(one value: .*?)`", FITTING.read_text(encoding="utf-8"))[0] in both
    lines = (desk / "trials.csv").read_text().splitlines(keepends=True)
    (desk / "trials.csv").write_text("".join(lines[:-2]))
    assert printed_by("impactlab fit trials.csv") == shown


@pytest.mark.slow
@pytest.mark.usefixtures("desk")
def test_addition_shown_is_the_one_that_plan_proposes() -> None:
    printed = printed_by("impactlab plan --mass 0.0027 --mass 0.0054")
    assert "add 3 trials of 0.0027 kg on 0.0054 kg and 3 trials of 0.0054 kg on 0.0027 kg; every" in printed


def test_complaints_are_quoted_in_the_words_of_the_tool() -> None:
    sources = [path for room in ("tracking", "experiments") for path in (HOME / room).rglob("*.py")]
    code = "\n".join(path.read_text(encoding="utf-8") for path in sources)
    spoken = re.sub(r'"\s*\n\s*f?"', "", code)
    table = FILMING.read_text(encoding="utf-8").split("| it says |")[1].split("\n\n")[0]
    for row in table.splitlines()[2:]:
        for words in row.split("|")[1].split("…"):
            assert words.strip(" :") in spoken, words


def test_every_note_of_a_fit_has_its_row_and_every_row_its_note() -> None:
    rows = re.findall(r"^\| ((?!note |---).*?) \|", NOTES.read_text(encoding="utf-8"), re.M)
    notes = [re.sub(r"{\w+}( {\w+})?", "…", note) for note in Note]
    assert len(rows) == len(notes)
    assert [note for note in notes if not any(note.startswith(row) for row in rows)] == []
    assert [row for row in rows if not any(note.startswith(row) for note in notes)] == []


def test_every_column_of_the_table_is_explained(two_clip: Clip) -> None:
    page = FILMING.read_text(encoding="utf-8")
    endings = re.findall(r"`…(_\w+)`", page)
    (row,) = measure(Trial(name="two", video=two_clip.path, kind="two", camera=GIVEN)).rows
    for column in row:
        plain = column.removesuffix("_sd")
        assert f"`{plain}`" in page or plain.endswith(tuple(endings)), column


def test_code_is_shown_in_blocks_that_are_looked_at() -> None:
    for page in PAGES:
        languages = set(re.findall(r"^```(\w+)$", page.read_text(encoding="utf-8"), re.M))
        assert languages <= {"sh", "python", "text", "toml", "csv"}, page.relative_to(HOME)
