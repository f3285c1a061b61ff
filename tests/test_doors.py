"""The house keeps its doors: who may import whom, and what lies at the top."""

import ast
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

HOME = Path(__file__).resolve().parents[1]
SIBLINGS = {
    "impact": set[str](),
    "tracking": set[str](),
    "calibrate": {"impact"},
    "experiments": {"impact", "tracking", "calibrate"},
}
GIANTS = {
    "numba": ("impact/kernel.py", "tracking/kernel.py"),
    "cv2": ("tracking/",),
    "av": ("tracking/decode.py", "tracking/encode.py"),
    "lmfit": ("calibrate/",),
    "matplotlib": ("experiments/",),
    "typer": ("experiments/",),
    "joblib": ("experiments/",),
    "distributed": ("experiments/cluster.py",),
    "jinja2": ("experiments/report/",),
    "pandas": ("calibrate/", "experiments/"),
}
TOP = {
    *("pyproject.toml", "impact", "tracking", "calibrate", "experiments", "tests", "README.md"),
    *("LICENSE", "CITATION.cff", "CHANGELOG.md"),
}


def modules(room: str) -> list[Path]:
    return sorted((HOME / room).rglob("*.py"))


def imported(module: Path) -> Iterator[str]:
    """Full dotted names a module imports, at the top or inside a function."""
    for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{module.name}: imports are absolute"
            yield node.module or ""


@pytest.mark.parametrize("room", SIBLINGS)
def test_rooms_import_each_other_one_way_only(room: str) -> None:
    assert modules(room)
    for module in modules(room):
        rooms = {name.split(".")[0] for name in imported(module)} & set(SIBLINGS)
        assert rooms <= SIBLINGS[room] | {room}, module


@pytest.mark.parametrize("giant", GIANTS)
def test_each_giant_lives_behind_its_door(giant: str) -> None:
    users = {
        module.relative_to(HOME).as_posix()
        for room in SIBLINGS
        for module in modules(room)
        if giant in {name.split(".")[0] for name in imported(module)}
    }
    assert users
    assert all(user.startswith(GIANTS[giant]) for user in users), users


def test_nobody_imports_the_tests() -> None:
    names = {path.stem for path in (HOME / "tests").glob("*.py")} | {"tests"}
    for room in SIBLINGS:
        for module in modules(room):
            assert not names & {name.split(".")[0] for name in imported(module)}, module


def test_nothing_is_added_beside_the_rooms() -> None:
    if shutil.which("git") is None or not (HOME / ".git").exists():
        pytest.skip("not a checkout")
    listed = subprocess.run(
        ["git", "-C", str(HOME), "ls-files"], check=True, capture_output=True, text=True
    ).stdout
    top = {line.split("/")[0] for line in listed.splitlines()}
    assert {name for name in top if not name.startswith(".")} <= TOP
    assert {"pyproject.toml", "README.md", "LICENSE", "CITATION.cff", "CHANGELOG.md"} <= top
