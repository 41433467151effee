from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from ssjs_cli.config import layer_from_tables, resolve
from ssjs_cli.errors import UserError
from ssjs_cli.formats.mrclam import SETTINGS, read_mrclam

MEASUREMENTS = "# header\n100.5 61 2.5 0.1\n100.5 14 1.5 0.2\n101.0 72 3.5 -0.3\n"


def data_directory(tmp_path: Path, measurements: str = MEASUREMENTS) -> Path:
    """Robot 1 among two landmarks (barcodes 61 and 72) and robot 2 (barcode 14)."""
    (tmp_path / "Barcodes.dat").write_text("# Subject # Barcode #\n 1  5\n 2  14\n 14  61\n 19  72\n")
    (tmp_path / "Robot1_Odometry.dat").write_text("# t v w\n100.0 0.1 0.0\n100.7 0.2 0.5\n")
    (tmp_path / "Robot1_Measurement.dat").write_text(measurements)
    (tmp_path / "Robot1_Groundtruth.dat").write_text("# t x y h\n100.0 1.0 2.0 3.5\n101.0 1.5 2.0 -0.5\n")
    (tmp_path / "Landmark_Groundtruth.dat").write_text("# s x y sx sy\n14 1 2 0.001 0.001\n19 3 4 0.001 0.001\n")
    return tmp_path


def test_barcodes_become_landmarks_and_robots_are_dropped_and_counted(tmp_path: Path) -> None:
    mission = read_mrclam(data_directory(tmp_path), 1)
    assert mission.observations is not None
    assert mission.observations.landmark_id is not None
    assert mission.observations.landmark_id.tolist() == [14, 19]
    assert mission.observations.range_m.tolist() == [2.5, 3.5]
    assert mission.import_record is not None
    assert mission.import_record.counts == {
        "robot_sightings_dropped": 1,
        "unknown_barcodes_dropped": 0,
        "odometry_records": 2,
        "observations": 2,
    }
    assert mission.import_record.lost == []


def test_odometry_and_reference(tmp_path: Path) -> None:
    mission = read_mrclam(data_directory(tmp_path), 1)
    assert mission.odometry.kind == "unicycle"
    assert mission.odometry.values.tolist() == [[100.0, 0.1, 0.0], [100.7, 0.2, 0.5]]
    assert mission.reference.truth is not None
    assert mission.reference.truth.pose[:, 2] == pytest.approx([3.5 - 2.0 * np.pi, -0.5])
    assert mission.reference.landmarks is not None
    assert mission.reference.landmarks.ids.tolist() == [14, 19]


def test_the_settings_are_settings_of_the_estimator() -> None:
    assert resolve([layer_from_tables(SETTINGS, "mrclam")]).values["association.method"] == "known"


def test_an_unknown_barcode_names_the_file_and_the_line(tmp_path: Path) -> None:
    directory = data_directory(tmp_path, MEASUREMENTS + "101.5 52 1.0 0.0\n102.0 53 1.0 0.0\n")
    with pytest.raises(UserError, match=r"Robot1_Measurement\.dat:5: barcode 52 is not in Barcodes\.dat, the first of 2 measurements"):
        read_mrclam(directory, 1)


def test_unknown_barcodes_may_be_dropped_and_are_then_counted(tmp_path: Path) -> None:
    directory = data_directory(tmp_path, MEASUREMENTS + "101.5 52 1.0 0.0\n")
    mission = read_mrclam(directory, 1, skip_unknown_barcodes=True)
    assert mission.import_record is not None
    assert mission.import_record.counts["unknown_barcodes_dropped"] == 1
    assert mission.import_record.lost == ["Robot1_Measurement.dat: dropped 1 measurement with a barcode that Barcodes.dat does not hold"]


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("Robot1_Odometry.dat", "100.0 0.1 0.0\n99.0 0.1 0.0\n", r"Robot1_Odometry\.dat:2: time_s = 99\.0 goes back from 100\.0"),
        ("Robot1_Odometry.dat", "100.0 nan 0.0\n", r"Robot1_Odometry\.dat:1: speed_m_s is empty or NaN"),
        ("Robot1_Odometry.dat", "# nothing\n", r"Robot1_Odometry\.dat: holds no odometry"),
        ("Robot1_Measurement.dat", "100.5 61 2.5\n", r"Robot1_Measurement\.dat:1: has 3 fields where 4 are needed"),
        ("Robot1_Measurement.dat", "100.5 61.5 2.5 0\n", r"Robot1_Measurement\.dat:1: barcode = 61\.5 must be a whole number"),
        ("Barcodes.dat", "6 61\n7 61\n", r"Barcodes\.dat:2: barcode 61 is given twice"),
    ],
)
def test_faults_name_the_file_and_the_line(tmp_path: Path, name: str, text: str, message: str) -> None:
    (data_directory(tmp_path) / name).write_text(text)
    with pytest.raises(UserError, match=message):
        read_mrclam(tmp_path, 1)


def test_a_missing_robot_names_the_file(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"Robot4_Odometry\.dat: is missing"):
        read_mrclam(data_directory(tmp_path), 4)


def test_the_real_robot_1(data_set: Callable[[str], Path]) -> None:
    mission = read_mrclam(data_set("mrclam_dataset7"), 1)
    assert mission.import_record is not None
    counts = mission.import_record.counts
    assert counts["odometry_records"] == 58_598
    # 3,228 measurements in the file
    assert counts["observations"] + counts["robot_sightings_dropped"] == 3_228
    assert mission.observations is not None
    assert mission.observations.landmark_id is not None
    assert set(mission.observations.landmark_id.tolist()) <= set(range(6, 21))
    assert mission.reference.landmarks is not None
    assert sorted(mission.reference.landmarks.ids.tolist()) == list(range(6, 21))


def test_the_real_robot_3_holds_barcodes_that_nobody_has(data_set: Callable[[str], Path]) -> None:
    folder = data_set("mrclam_dataset7")
    with pytest.raises(UserError, match=r"Robot3_Measurement\.dat:241: barcode 52 is not in Barcodes\.dat, the first of 9 measurements"):
        read_mrclam(folder, 3)
    mission = read_mrclam(folder, 3, skip_unknown_barcodes=True)
    assert mission.import_record is not None
    assert mission.import_record.counts["unknown_barcodes_dropped"] == 9
