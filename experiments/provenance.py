"""Where a result came from: versions, inputs and options, so that it can be made again."""

import hashlib
import platform
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

_PACKAGES = ("impactlab", "numpy", "scipy", "lmfit", "numba", "pandas")


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
        "versions": {"python": platform.python_version(), **{name: version(name) for name in _PACKAGES}},
        "inputs": {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in inputs},
        "options": {name: value for name, value in options.items() if value is not None},
    }
