"""What every test may ask for."""

from pathlib import Path

import pytest
from clips import SMALL, Clip, film

from tracking.render import DropScene

SHARED_DATA = Path(__file__).resolve().parents[2] / "shared" / "data"


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder of real and rendered recordings and oracle numbers; a test that asks for it skips without it."""
    if not SHARED_DATA.is_dir():
        pytest.skip("no folder of shared recordings beside the project")
    return SHARED_DATA


@pytest.fixture(scope="session")
def clips(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder in which rendered recordings are kept for the session."""
    return tmp_path_factory.mktemp("clips")


@pytest.fixture(scope="session")
def plate_clip(clips: Path) -> Clip:
    """A ball on the plate."""
    return film(DropScene(kind="plate", drop_height=0.15, after=0.2, camera=SMALL), clips / "plate-00.mp4")


@pytest.fixture(scope="session")
def two_clip(clips: Path) -> Clip:
    """A ball on a ball at rest."""
    scene = DropScene(
        kind="two", drop_height=0.12, after=0.12, first_rebound=(0.78, 0.19), camera=SMALL, seed=5
    )
    return film(scene, clips / "two-00.mp4")
