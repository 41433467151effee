"""One finished survey, exported once."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from ssjs_cli.app import call

sys.path.insert(0, str(Path(__file__).parent))

from exported_survey import Survey, read_recording


@pytest.fixture(scope="session")
def survey(tmp_path_factory: pytest.TempPathFactory) -> Survey:
    """A survey with sonar pictures and an origin on earth."""
    pytest.importorskip("mcap", reason="the extra 'mcap' is not installed")
    folder = tmp_path_factory.mktemp("survey")
    mission, run, path = folder / "mission", folder / "run", folder / "run.mcap"
    assert call(["simulate", "side-scan-survey", "--seed", "3", "--out", str(mission)]) == 0
    text = (mission / "mission.toml").read_text()
    origin = '[geodetic]\norigin_latitude_deg = 41.78\norigin_longitude_deg = 3.03\nheading_deg = 0.0\ny_axis = "right"\n'
    (mission / "mission.toml").write_text(text + "\n" + origin)
    assert call(["run", str(mission), "--out", str(run), "--no-report"]) == 0
    assert call(["export", "mcap", str(run), "--out", str(path)]) == 0
    return Survey(mission, run, path, read_recording(path))


@pytest.fixture
def circle_run(circle_mission: Path, tmp_path: Path, cli: Callable[..., Any]) -> Path:
    pytest.importorskip("mcap", reason="the extra 'mcap' is not installed")
    assert cli("run", circle_mission, "--out", tmp_path / "run", "--no-report").code == 0
    return tmp_path / "run"
