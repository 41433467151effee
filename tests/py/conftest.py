"""Fixtures of all Python tests: the command line as a function, a small mission, and the real data sets."""

import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from ssjs_cli.app import call


@dataclass(frozen=True)
class Answer:
    code: int
    out: str
    err: str


@pytest.fixture
def cli(capsys: pytest.CaptureFixture[str]) -> Callable[..., Answer]:
    """cli("run", mission, ...) -> exit code, stdout, stderr."""

    def run(*arguments: object) -> Answer:
        capsys.readouterr()
        code = call([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        return Answer(code, captured.out, captured.err)

    return run


@pytest.fixture(scope="session")
def data_set() -> Callable[[str], Path]:
    """The folder of a real data set under SSJS_DATA. Absent: skipped, or failed where SSJS_REQUIRE_DATA=1."""

    def find(name: str) -> Path:
        root = os.environ.get("SSJS_DATA")
        folder = None if root is None else Path(root) / name
        if folder is not None and folder.is_dir():
            return folder
        reason = f"the data set {name} is not there: SSJS_DATA is {'not set' if root is None else root}"
        if os.environ.get("SSJS_REQUIRE_DATA") == "1":
            pytest.fail(reason)
        pytest.skip(reason)

    return find


CIRCLE_RADIUS_M = 10.0
SPEED_M_S = 1.0
STEP_S = 0.1
STEPS = 1300
STEPS_PER_SCAN = 5
VIEW_M = 9.0


def circle_pose(time_s: float) -> tuple[float, float, float]:
    """From the origin, heading along +x, around a centre 10 m to the left, at 1 m/s."""
    angle = SPEED_M_S * time_s / CIRCLE_RADIUS_M
    heading = math.remainder(angle, 2.0 * math.pi)
    return CIRCLE_RADIUS_M * math.sin(angle), CIRCLE_RADIUS_M * (1.0 - math.cos(angle)), heading


@pytest.fixture
def circle_mission(tmp_path: Path) -> Path:
    """Two rounds of a circle among twenty landmarks, velocity commands, ids known, dense truth; small seeded noise."""
    directory = tmp_path / "circle"
    write_circle_mission(directory)
    return directory


def write_circle_mission(directory: Path) -> None:
    directory.mkdir()
    rng = np.random.default_rng(5)
    angles = [2.0 * math.pi * index / 20 for index in range(20)]
    radii = [6.0 if index % 2 else 14.0 for index in range(20)]
    landmarks = [(radius * math.sin(angle), 10.0 - radius * math.cos(angle)) for angle, radius in zip(angles, radii, strict=True)]
    odometry, observations, truth = ["time_s,speed_m_s,turn_rate_rad_s"], ["time_s,range_m,bearing_rad,landmark_id"], []
    for step in range(STEPS + 1):
        time_s = step * STEP_S
        x, y, heading = circle_pose(time_s)
        truth.append(f"{time_s!r} {x!r} {y!r} 0 0 0 {math.sin(heading / 2)!r} {math.cos(heading / 2)!r}")
        speed, turn_rate = SPEED_M_S + 0.02 * rng.standard_normal(), SPEED_M_S / CIRCLE_RADIUS_M + 0.02 * rng.standard_normal()
        odometry.append(f"{time_s!r},{speed!r},{turn_rate!r}")
        if step % STEPS_PER_SCAN == 0 and step > 0:
            for identity, (lx, ly) in enumerate(landmarks, 1):
                distance = math.hypot(lx - x, ly - y)
                if distance > VIEW_M:
                    continue
                bearing = math.remainder(math.atan2(ly - y, lx - x) - heading + 0.005 * rng.standard_normal(), 2.0 * math.pi)
                observations.append(f"{time_s!r},{distance + 0.05 * rng.standard_normal()!r},{bearing!r},{identity}")
    (directory / "odometry.csv").write_text("\n".join(odometry) + "\n")
    (directory / "observations.csv").write_text("\n".join(observations) + "\n")
    (directory / "truth_trajectory.tum").write_text("\n".join(truth) + "\n")
    rows = [f"{identity},{x!r},{y!r}" for identity, (x, y) in enumerate(landmarks, 1)]
    (directory / "truth_landmarks.csv").write_text("id,x_m,y_m\n" + "\n".join(rows) + "\n")
    (directory / "mission.toml").write_text(
        '[mission]\nname = "circle"\n\n[settings.vehicle]\nkind = "unicycle"\n\n'
        "[settings.vehicle.unicycle]\nspeed_sigma_m_s = 0.02\nturn_rate_sigma_rad_s = 0.02\nnoise_step_s = 0.1\n\n"
        "[settings.sensor]\nrange_sigma_m = 0.05\nbearing_sigma_rad = 0.005\n\n"
        '[settings.association]\nmethod = "known"\n\n[settings.submap]\nmax_landmarks = 6\n\n[reference]\nalignment = "none"\n'
    )
