import math
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from ssjs_cli.config import layer_from_tables, resolve
from ssjs_cli.errors import UserError
from ssjs_cli.formats import victoria_park
from ssjs_cli.formats.victoria_park import SETTINGS, parse_laser_text, read_victoria_park

SCANS = 3


def laser_text(scans: int = SCANS, extra: str = "") -> str:
    """Scan k at 0.852 + 0.2 k s: beam i has the range 1 + k + i / 1000."""
    tokens = []
    for scan in range(scans):
        tokens.append(f"{0.852 + 0.2 * scan:.3f}")
        tokens += [f"{1 + scan + beam / 1000:.3f}" for beam in range(361)]
    return "\t".join(tokens) + extra


def data_directory(tmp_path: Path, *, laser: str | None = None, gps: bool = True) -> Path:
    tmp_path.mkdir(exist_ok=True)
    with zipfile.ZipFile(tmp_path / "victoria_park_ascii.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("LASER.txt", laser_text() if laser is None else laser)
    time_ms = np.array([[21940], [21965], [21990]], dtype=np.int32)
    savemat(tmp_path / "aa3_dr.mat", {"time": time_ms, "speed": np.array([[0.0], [1.0], [2.0]]), "steering": np.full((3, 1), 0.1)})
    if gps:
        savemat(
            tmp_path / "aa3_gpsx.mat", {"timeGps": time_ms[:2], "La_m": np.array([[-41.5], [-41.0]]), "Lo_m": np.array([[-67.5], [-67.0]])}
        )
    return tmp_path


def test_times_columns_and_angles(tmp_path: Path) -> None:
    mission = read_victoria_park(data_directory(tmp_path))
    assert mission.odometry.kind == "ackerman"
    assert mission.odometry.values.tolist() == [[21.94, 0.0, 0.1], [21.965, 1.0, 0.1], [21.99, 2.0, 0.1]]
    assert mission.scans is not None
    # 0.852 + 20.967 = 21.819 s on the clock of the .mat files
    assert mission.scans.time_s.tolist() == [21.819, 22.019, 22.219]
    assert mission.scans.range_m.shape == (3, 361)
    assert mission.scans.range_m[1, [0, 1, 360]].tolist() == [2.0, 2.001, 2.36]
    assert mission.scans.first_angle_rad == -math.pi / 2
    assert mission.scans.first_angle_rad + 360 * mission.scans.step_rad == pytest.approx(math.pi / 2)
    assert mission.reference.fixes is not None
    assert mission.reference.fixes.position_m.tolist() == [[-67.5, -41.5], [-67.0, -41.0]]


def test_the_recommended_settings_are_settings_of_the_estimator() -> None:
    values = resolve([layer_from_tables(SETTINGS, "victoria park")]).values
    assert values["vehicle.ackerman.lateral_sigma_m_s"] == 0.5
    assert values["sensor.bearing_offset_rad"] == math.radians(-1.0)
    assert (values["vehicle.ackerman.steering_scale"], values["vehicle.ackerman.steering_offset_rad"]) == (1.037, 0.0043)


def test_the_reference_is_compared_as_documented(tmp_path: Path) -> None:
    description = read_victoria_park(data_directory(tmp_path)).reference.description
    assert (description.lever_arm_forward_m, description.lever_arm_left_m) == (-0.09, -0.06)
    assert (description.outlier_m, description.alignment) == (10.0, "se2")


def test_an_unpacked_laser_file_serves_too(tmp_path: Path) -> None:
    directory = data_directory(tmp_path)
    (directory / "victoria_park_ascii.zip").unlink()
    (directory / "LASER.txt").write_text(laser_text())
    mission = read_victoria_park(directory)
    assert mission.scans is not None
    assert len(mission.scans.time_s) == SCANS


def test_an_incomplete_last_scan_is_dropped_and_said(tmp_path: Path) -> None:
    mission = read_victoria_park(data_directory(tmp_path, laser=laser_text(extra="\t1.452\t0.85\t0.86")))
    assert mission.scans is not None
    assert len(mission.scans.time_s) == SCANS
    assert mission.import_record is not None
    assert mission.import_record.lost == ["LASER.txt: the last scan is incomplete (3 of 362 numbers) and was dropped"]


def test_without_gps_the_mission_has_no_reference_and_says_so(tmp_path: Path) -> None:
    mission = read_victoria_park(data_directory(tmp_path, gps=False))
    assert mission.reference.is_empty
    assert mission.import_record is not None
    assert mission.import_record.lost == ["aa3_gpsx.mat is missing: the mission has no reference"]


@pytest.mark.parametrize(
    ("laser", "message"),
    [
        ("0.852\t1.0\tx1.0", r"LASER\.txt number 3 \(scan 0\) is b'x1\.0'; fetch the file again"),
        ("0.852\t1.0", r"LASER\.txt holds 2 numbers, less than one scan of 362"),
        (laser_text().replace("\t1.052\t2.000", "\t0.052\t2.000"), r"LASER\.txt scan 1 goes back in time"),
        (laser_text().replace("\t1.100", "\t-1.100", 1), r"LASER\.txt scan 0 holds a negative range"),
        (laser_text().replace("\t1.100", "\tnan", 1), r"LASER\.txt scan 0 holds NaN or infinity"),
    ],
)
def test_faulty_laser_text_is_refused(tmp_path: Path, laser: str, message: str) -> None:
    with pytest.raises(UserError, match=message):
        read_victoria_park(data_directory(tmp_path, laser=laser))


def test_a_truncated_archive_is_refused(tmp_path: Path) -> None:
    path = data_directory(tmp_path) / "victoria_park_ascii.zip"
    path.write_bytes(path.read_bytes()[:-300])
    with pytest.raises(UserError, match=r"ascii\.zip: is damaged or cut short, LASER\.txt cannot be read .* fetch the archive again"):
        read_victoria_park(tmp_path)


def test_a_damaged_member_is_refused(tmp_path: Path) -> None:
    path = data_directory(tmp_path) / "victoria_park_ascii.zip"
    data = bytearray(path.read_bytes())
    data[60:70] = bytes(10)
    path.write_bytes(bytes(data))
    with pytest.raises(UserError, match="is damaged or cut short"):
        read_victoria_park(tmp_path)


def test_an_archive_without_the_laser_names_what_it_holds(tmp_path: Path) -> None:
    data_directory(tmp_path)
    with zipfile.ZipFile(tmp_path / "victoria_park_ascii.zip", "w") as archive:
        archive.writestr("GPS.txt", "1 2 3")
    with pytest.raises(UserError, match=r"holds no LASER\.txt \(it holds GPS\.txt\)"):
        read_victoria_park(tmp_path)


def test_an_archive_that_unfolds_too_far_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    data_directory(tmp_path, laser="1 " * 500_000)
    monkeypatch.setattr(victoria_park, "MAX_LASER_BYTES", 100_000)
    with pytest.raises(UserError, match=r"LASER\.txt unfolds to more than the 100000 bytes allowed"):
        read_victoria_park(tmp_path)


def test_a_damaged_mat_file_is_refused(tmp_path: Path) -> None:
    (data_directory(tmp_path) / "aa3_dr.mat").write_bytes(b"no matlab file")
    with pytest.raises(UserError, match=r"aa3_dr\.mat: is damaged or no MATLAB file"):
        read_victoria_park(tmp_path)


def test_a_mat_file_without_the_variables_is_refused(tmp_path: Path) -> None:
    savemat(data_directory(tmp_path) / "aa3_dr.mat", {"time": np.array([1.0])})
    with pytest.raises(UserError, match=r"aa3_dr\.mat: the variable speed is missing"):
        read_victoria_park(tmp_path)


def test_a_directory_without_the_data_names_the_files(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"aa3_dr\.mat: is missing"):
        read_victoria_park(tmp_path)


def test_a_scan_may_be_parsed_from_any_white_space() -> None:
    scans = parse_laser_text(laser_text(1).replace("\t", " \n").encode(), Path("LASER.txt"), [])
    assert scans.range_m.shape == (1, 361)


def test_the_real_drive(data_set: Callable[[str], Path]) -> None:
    mission = read_victoria_park(data_set("victoria_park"))
    assert mission.import_record is not None
    assert mission.import_record.lost == []
    assert mission.import_record.counts == {"odometry_records": 61_945, "scans": 7_230, "gps_fixes": 4_466}
    assert mission.scans is not None
    # Beams 0-11 always see the vehicle itself, about 0.85 m away; about 83 % of the beams hit nothing.
    assert np.median(mission.scans.range_m[:, :12]) == pytest.approx(0.85, abs=0.05)
    assert float((mission.scans.range_m >= 80.0).mean()) == pytest.approx(0.83, abs=0.02)
    # The clock of the published detections: their first scans.
    assert mission.scans.time_s[:4].tolist() == [21.819, 22.033, 22.246, 22.46]
    assert (np.diff(mission.scans.time_s) > 0.0).all()
