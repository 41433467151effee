"""A short camera survey, simulated once: two lines of 5 m, a metre apart."""

from collections.abc import Callable
from pathlib import Path

import pytest

from ssjs_cli.app import call

SHORT_SURVEY = """
scenario = "camera-survey"
name = "short"
[survey.lines]
lines = 2
line_length_m = 5.0
line_spacing_m = 1.0
cross_lines = 0
"""


@pytest.fixture(scope="session")
def short_survey(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("camera")
    (folder / "short.toml").write_text(SHORT_SURVEY)
    assert call(["simulate", str(folder / "short.toml"), "--seed", "3", "--out", str(folder / "mission")]) == 0
    return folder / "mission"


@pytest.fixture
def copy_of(tmp_path: Path) -> Callable[[Path], Path]:
    import shutil

    def copy(mission: Path) -> Path:
        return Path(shutil.copytree(mission, tmp_path / "mission"))

    return copy
