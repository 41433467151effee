"""Work for the workers of the tests, importable by name in another process, and a scenario that takes a fraction of a second."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

SMALL_SCENARIO = """
name = "little"
[vehicle]
wheelbase_m = 0.6
encoder_offset_m = 0.0
reference_forward_m = 0.3
reference_left_m = 0.0
speed_m_s = 1.0
step_s = 0.1
speed_sigma_m_s = 0.1
steering_sigma_rad = 0.03
[sensor]
max_range_m = 4.5
range_sigma_m = 0.05
bearing_sigma_rad = 0.01
scan_period_s = 0.5
[landmarks.grid]
columns = 6
rows = 5
spacing_m = 4.0
jitter_m = 1.0
[path]
waypoints_m = [[2.0, 2.0], [18.0, 2.0], [18.0, 14.0], [2.0, 14.0]]
laps = 2
[settings.submap]
max_landmarks = 8
[settings.joining]
max_pairing_sigma_m = 0.6
"""


@pytest.fixture
def small_scenario(tmp_path: Path) -> Path:
    """Two laps of 56 m among thirty landmarks."""
    path = tmp_path / "little.toml"
    path.write_text(SMALL_SCENARIO)
    return path
