"""The command line as a person meets it: what it prints, what it writes, how it refuses."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from experiments.cli import app
from experiments.verbs import announce_compilation

TABLE = """kind,approach_velocity,upper_rebound_velocity,lower_rebound_velocity,upper_mass,lower_mass
plate,-2.0,1.69,,,
plate,-2.5,2.12,,,
plate,-3.0,2.54,,,
held,-2.0,1.62,,,
held,-2.5,2.01,,,
held,-3.0,2.43,,,
two,-2.0,1.56,0.374,0.0027,0.0027
two,-3.0,2.34,0.558,0.0027,0.0027
two,-2.0,1.57,0.471,0.0054,0.0027
two,-3.0,2.35,0.704,0.0054,0.0027
"""


def impactlab(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture
def table(tmp_path: Path) -> Path:
    path = tmp_path / "typed.csv"
    path.write_text(TABLE)
    return path


def assert_refused(result: Result, *words: str) -> None:
    assert result.exit_code == 2, result.output
    assert all(word in result.stderr for word in words), result.stderr
    assert "Traceback" not in result.output


def test_help_loads_nothing_heavy() -> None:
    loaded = (
        "import sys; from experiments.cli import app; print(*{'numba', 'cv2', 'scipy'} & set(sys.modules))"
    )
    printed = subprocess.run(
        [sys.executable, "-c", loaded], check=True, capture_output=True, text=True
    ).stdout
    assert printed.strip() == ""


@pytest.mark.parametrize("verb", ["demo", "process", "fit", "report", "figures", "simulate"])
def test_every_verb_has_help_with_an_example(verb: str) -> None:
    path = [verb, "drop"] if verb == "simulate" else [verb]
    result = impactlab(*path, "--help")
    assert result.exit_code == 0
    assert "Example: impactlab" in result.output


def test_fit_of_a_typed_in_table_writes_everything_and_prints_the_verdict(
    table: Path, tmp_path: Path
) -> None:
    result = impactlab("fit", table, "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output
    assert "stiffness ratio" in result.stdout
    written = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"fit.json", "fig5.svg", "fig5.png", "profile.svg", "profile.png"} <= written
    fit = json.loads((tmp_path / "out" / "fit.json").read_text())
    assert {"value", "sd", "intervals_68", "intervals_95", "verdict"} <= set(fit["stiffness_ratio"])


def test_fit_names_a_missing_column(tmp_path: Path) -> None:
    path = tmp_path / "short.csv"
    path.write_text("kind,upper_rebound_velocity\nplate,1.7\n")
    assert_refused(impactlab("fit", path, "--out", tmp_path), "short.csv", "approach_velocity")


def test_fit_goes_on_without_the_row_that_holds_a_word(table: Path, tmp_path: Path) -> None:
    table.write_text(TABLE.replace("plate,-2.5,2.12", "plate,fast,2.12"))
    result = impactlab("fit", table, "--out", tmp_path / "out")
    assert result.exit_code == 1, result.output
    assert "line 3" in result.stderr
    assert "'fast'" in result.stderr
    assert (tmp_path / "out" / "fit.json").is_file()


def test_fit_flags_a_rebound_faster_than_the_approach(table: Path, tmp_path: Path) -> None:
    table.write_text(TABLE.replace("held,-2.0,1.62", "held,-2.0,2.62"))
    result = impactlab("fit", table, "--out", tmp_path / "out")
    assert result.exit_code == 1, result.output
    assert "line 5" in result.stderr


def test_fit_says_that_a_file_is_missing(tmp_path: Path) -> None:
    assert_refused(impactlab("fit", tmp_path / "nowhere.csv", "--out", tmp_path), "nowhere.csv")


@pytest.mark.parametrize(
    ("option", "value", "words"),
    [
        ("--ball-table", ("1.2", "0.01"), "within"),
        ("--exponent", ("0",), "exponent"),
    ],
)
def test_fit_refuses_impossible_options(
    table: Path, tmp_path: Path, option: str, value: tuple[str, ...], words: str
) -> None:
    assert_refused(impactlab("fit", table, option, *value, "--out", tmp_path), words)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nowhere.mp4", "--kind", "plate"], "nowhere.mp4"),
        ([__file__, "--ball-diameter", "0.04"], "--kind"),
        ([__file__, "--kind", "plate", "--ball-diameter", "0"], "diameter must be"),
        ([__file__, "--kind", "plate", "--ball-mass", "-1"], "mass must be"),
        ([__file__, "--kind", "sideways"], "kind must be one of"),
        ([__file__, "--kind", "plate", "--capture-fps", "-240"], "capture_fps"),
        ([__file__, "--kind", "plate", "--workers", "0"], "workers"),
        ([__file__, "--kind", "plate", "--timeout", "-1"], "timeout must be positive"),
        ([__file__, "--kind", "plate", "--memory", "0.1"], "memory"),
    ],
)
def test_process_refuses_wrong_use(arguments: list[str], words: str, tmp_path: Path) -> None:
    assert_refused(impactlab("process", *arguments, "--out", tmp_path / "out"), words)


def test_process_fails_a_trial_that_is_no_video_and_writes_the_row(tmp_path: Path) -> None:
    result = impactlab("process", __file__, "--kind", "plate", "--ball-diameter", "0.04", "--out", tmp_path)
    assert result.exit_code == 1, result.output
    assert "not a video" in result.stderr
    assert "failed" in (tmp_path / "trials.csv").read_text()


def test_process_prints_its_rows_as_json_and_nothing_else(tmp_path: Path) -> None:
    result = impactlab("process", __file__, "--kind", "plate", "--json", "--out", tmp_path)
    (row,) = json.loads(result.stdout)
    assert (row["status"], row["approach_velocity"]) == ("failed", None)
    assert result.exit_code == 1
    assert "not a video" in result.stderr


def test_process_heads_each_kind_with_its_own_columns(tmp_path: Path) -> None:
    named = ["--kind", "shot", "--no-overlays", "--out", tmp_path]
    result = impactlab("process", __file__, *named)
    assert result.stdout.split()[:5] == ["trial", "kind", "n", "speed", "direction"]
    assert {path.name for path in tmp_path.iterdir()} == {"trials.csv", "trials", "run.json", "report.html"}


def test_figures_print_ours_beside_the_printed_numbers(tmp_path: Path) -> None:
    result = impactlab("figures", "fig4", "fig5", "--out", tmp_path)
    assert result.exit_code == 0, result.output
    assert "1.2494" in result.stdout
    assert {"fig4.svg", "fig4.png", "fig5.svg", "fig5.png"} <= {path.name for path in tmp_path.iterdir()}


def test_figures_refuse_a_name_the_paper_does_not_have(tmp_path: Path) -> None:
    assert_refused(impactlab("figures", "fig99", "--out", tmp_path), "fig99", "fig4")


def test_simulate_refuses_a_restitution_above_one() -> None:
    assert_refused(
        impactlab("simulate", "drop", "--ball-ball", "1.2"), "restitution must be within [0, 1], got 1.2"
    )


def test_the_first_run_says_why_it_takes_long_and_no_later_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    announce_compilation(tmp_path)
    assert "the model is being compiled, once" in capsys.readouterr().err
    (tmp_path / "__pycache__").mkdir()
    (tmp_path / "__pycache__" / "diagram.run-75.py311.nbi").touch()
    announce_compilation(tmp_path)
    assert capsys.readouterr().err == ""
