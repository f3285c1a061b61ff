"""The verbs fit, figures and simulate drop, as a person types them."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from experiments.cli import app

HEADER = "kind,approach_velocity,upper_rebound_velocity"


def impactlab(*words: str) -> Result:
    return CliRunner().invoke(app, list(words))


def table(folder: Path, *rows: str) -> str:
    path = folder / "trials.csv"
    path.write_text("\n".join([HEADER, *rows]) + "\n", encoding="utf-8")
    return str(path)


def test_fit_prints_its_verdict_and_writes_fit_json(tmp_path: Path) -> None:
    done = impactlab(
        "fit", table(tmp_path, "plate,-2,1.7", "plate,-3,2.54", "plate,-4,3.41"), "--out", str(tmp_path)
    )
    assert done.exit_code == 0
    assert "stiffness ratio k2/k1: not determined" in done.stdout
    written = json.loads((tmp_path / "fit.json").read_text(encoding="utf-8"))
    assert written["restitution_ball_table"]["verdict"] == "one value"
    assert set(written["provenance"]) == {"versions", "inputs", "options"}


def test_one_bad_trial_gives_exit_code_one_and_the_rest_is_fitted(tmp_path: Path) -> None:
    done = impactlab(
        "fit", table(tmp_path, "plate,-2,1.7", "plate,-3,2.54", "plate,fast,3.4"), "--out", str(tmp_path)
    )
    assert done.exit_code == 1
    assert "trials.csv, line 4: approach_velocity must be a number, got 'fast'" in done.stderr
    assert (tmp_path / "fit.json").exists()


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("fit", "missing.csv"), "missing.csv: No such file or directory"),
        (("figures", "fig9"), "got 'fig9'"),
        (("simulate", "drop", "--ball-ball", "1.2"), "restitution must be within [0, 1], got 1.2"),
        (("simulate", "drop", "--plot", "drop.doc"), "got 'drop.doc'"),
    ],
)
def test_wrong_use_is_one_sentence_and_exit_code_two(words: tuple[str, ...], sentence: str) -> None:
    done = impactlab(*words)
    assert done.exit_code == 2
    assert done.stderr.startswith("impactlab: ")
    assert sentence in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_simulate_drop_prints_states_and_velocities_and_draws(tmp_path: Path) -> None:
    plot = tmp_path / "drop.svg"
    done = impactlab("simulate", "drop", "--stiffness-ratio", "10", "--plot", str(plot))
    assert done.exit_code == 0
    assert "C2-C1-R2" in done.stdout
    assert "velocities after: upper 2.3" in done.stdout
    assert plot.stat().st_size > 1000


def test_figures_prints_ours_beside_printed(tmp_path: Path) -> None:
    done = impactlab("figures", "fig4", "--out", str(tmp_path))
    assert done.exit_code == 0
    assert "printed  difference" in done.stdout
    assert (tmp_path / "fig4.csv").exists()
