"""Generated side-scan pictures, and a cascade trained on them."""

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from side_scan_scenes import Scenes, make_scenes


@pytest.fixture(scope="session")
def scenes(tmp_path_factory: pytest.TempPathFactory) -> Scenes:
    return make_scenes(tmp_path_factory.mktemp("scenes"))


@pytest.fixture(scope="session")
def trained(scenes: Scenes, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The directory of one training on the scenes, on one thread."""
    from ssjs_cli.app import call

    out = tmp_path_factory.mktemp("trained") / "model"
    assert call(["cascade", "train", *map(str, scenes.options), "--recordings", r"(line\d\d)", "--jobs", "1", "--out", str(out)]) == 0
    return out


@pytest.fixture
def new_scenes(tmp_path: Path) -> Callable[..., Scenes]:
    """new_scenes(pictures=..., seed=...) -> scenes of their own."""
    return lambda **options: make_scenes(tmp_path / "own", **options)
