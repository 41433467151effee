from pathlib import Path

import numpy as np
import pytest

from ssjs_cli.errors import UserError
from ssjs_cli.formats.geographic import to_longitude_latitude
from ssjs_cli.formats.mission import Geodetic
from ssjs_cli.formats.navigation import PositionFixes, write_fixes
from ssjs_cli.formats.position_fixes import read_position_fixes

ORIGIN = Geodetic(origin_latitude_deg=41.97, origin_longitude_deg=3.2, heading_deg=0.0, y_axis="right")
FIXES = PositionFixes(np.array([0.0, 1.0, 60.5]), np.array([[0.1, -0.2], [1.5, 0.0], [350.0, 120.0]]), np.array([1.5, 1.5, 3.0]))


def test_what_is_written_reads_back_to_the_last_bit(tmp_path: Path) -> None:
    write_fixes(tmp_path / "fixes.csv", FIXES)
    read = read_position_fixes(tmp_path, None)
    assert read is not None
    np.testing.assert_array_equal(read.time_s, FIXES.time_s)
    np.testing.assert_array_equal(read.position_m, FIXES.position_m)
    np.testing.assert_array_equal(read.sigma_m, FIXES.sigma_m)


def test_a_mission_without_the_file_has_none(tmp_path: Path) -> None:
    assert read_position_fixes(tmp_path, ORIGIN) is None


def test_latitude_and_longitude_are_placed_by_the_origin(tmp_path: Path) -> None:
    geographic = to_longitude_latitude(FIXES.position_m, ORIGIN)
    lines = [f"{t!r},{lat!r},{lon!r},2.0" for t, (lon, lat) in zip(FIXES.time_s.tolist(), geographic.tolist(), strict=True)]
    (tmp_path / "fixes.csv").write_text("\n".join(["time_s,latitude_deg,longitude_deg,sigma_m", *lines]) + "\n")
    read = read_position_fixes(tmp_path, ORIGIN)
    assert read is not None
    np.testing.assert_allclose(read.position_m, FIXES.position_m, atol=1e-3)
    # A minute of arc northwards is about 1852 m.
    (tmp_path / "fixes.csv").write_text(f"time_s,latitude_deg,longitude_deg,sigma_m\n0,{41.97 + 1.0 / 60.0},3.2,2.0\n")
    north = read_position_fixes(tmp_path, ORIGIN)
    assert north is not None
    np.testing.assert_allclose(north.position_m, [[1851.0, 0.0]], atol=2.0)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("time_s,x_m,y_m\n0,0,0\n", r"fixes\.csv:1: column sigma_m is missing"),
        ("time_s,x_m,y_m,sigma_m\n", r"fixes\.csv: holds no fix; give"),
        ("time_s,x_m,y_m,sigma_m\n0,0,0,0\n", r"fixes\.csv:2: sigma_m = 0\.0 must be positive"),
        ("time_s,x_m,y_m,sigma_m\n1,0,0,1\n0,0,0,1\n", r"fixes\.csv:3: time_s = 0\.0 goes back"),
        ("time_s,x_m,y_m,sigma_m\n0,500000,6000000,1\n", r"fixes\.csv:2: the fix lies farther than 200 km .* national grid"),
        ("time_s,latitude_deg,longitude_deg,sigma_m\n0,41,3,1\n", r"latitude and longitude, and mission\.toml no origin"),
    ],
)
def test_a_fault_is_named_with_its_line_and_mend(tmp_path: Path, text: str, complaint: str) -> None:
    (tmp_path / "fixes.csv").write_text(text)
    with pytest.raises(UserError, match=complaint):
        read_position_fixes(tmp_path, None)


def test_a_latitude_that_cannot_be_is_named(tmp_path: Path) -> None:
    (tmp_path / "fixes.csv").write_text("time_s,latitude_deg,longitude_deg,sigma_m\n0,3,41,1\n1,97,3,1\n")
    with pytest.raises(UserError, match=r"fixes\.csv:3: latitude_deg = 97\.0 must lie between -90 and 90"):
        read_position_fixes(tmp_path, ORIGIN)
