"""What every test may ask for."""

from pathlib import Path

import pytest

SHARED_DATA = Path(__file__).resolve().parents[2] / "shared" / "data"


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder of real and rendered recordings and oracle numbers; a test that asks for it skips without it."""
    if not SHARED_DATA.is_dir():
        pytest.skip("no folder of shared recordings beside the project")
    return SHARED_DATA
