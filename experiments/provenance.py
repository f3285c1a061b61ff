"""Where a result came from: versions, inputs and options, so that it can be made again."""

import hashlib
import json
import platform
import shlex
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from calibrate.files import write_whole

HOME = Path(__file__).resolve().parents[1]
ROOMS = ("tracking", "calibrate", "experiments")
"""What a recording passes through; the model of `impact` is not among it."""
_COMMANDS = "run.json"
_PACKAGES = ("impactlab", "numpy", "scipy", "lmfit", "numba", "pandas", "opencv-python-headless", "av")


def provenance(inputs: Sequence[Path], options: Mapping[str, Any]) -> dict[str, Any]:
    """Collect versions, the SHA-256 of every input, and the options that are set.

    Parameters
    ----------
    inputs : sequence of Path
        Files read.
    options : mapping
        Kept as they are; those that are None are left out.
    """
    return {
        "versions": versions(),
        "inputs": {path.name: sha256(path) for path in inputs},
        "options": {name: value for name, value in options.items() if value is not None},
    }


def versions() -> dict[str, str]:
    """Give the versions of Python and of the packages that results depend on."""
    return {"python": platform.python_version(), **{name: version(name) for name in _PACKAGES}}


@cache
def code_digest(home: Path = HOME) -> str:
    """Give one SHA-256 for all code that measures: two installations of one version may hold different code.

    Parameters
    ----------
    home : Path
        Folder of the rooms.
    """
    digest = hashlib.sha256()
    for path in sorted(path for room in ROOMS for path in (home / room).rglob("*.py")):
        digest.update(f"{path.relative_to(home).as_posix()} {sha256(path)}\n".encode())
    return digest.hexdigest()


def sha256(path: Path) -> str:
    """Give the SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def write_command(out: Path, verb: str) -> None:
    """Keep in `out`/run.json how this program was called, so that it can be called so again."""
    command = shlex.join(["impactlab", *sys.argv[1:]])
    told = {**read_commands(out), verb: {"command": command, "versions": versions()}}
    write_whole(out / _COMMANDS, json.dumps(told, indent=1, ensure_ascii=False) + "\n")


def read_commands(out: Path) -> dict[str, dict[str, Any]]:
    """Read what `write_command` kept: command and versions of each verb."""
    try:
        return dict(json.loads((out / _COMMANDS).read_text(encoding="utf-8")))
    except (OSError, ValueError):
        return {}
