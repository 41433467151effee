import math
import shutil
import zipfile
from pathlib import Path

import numpy as np
import pytest

from ssjs_cli.errors import UserError
from ssjs_cli.formats.mission import (
    UNKNOWN_LANDMARK,
    Fixes,
    Geodetic,
    ImportRecord,
    Mission,
    Observations,
    Odometry,
    Reference,
    ReferenceDescription,
    Scans,
    SurveyedLandmarks,
    input_digests,
    read_mission,
    why_not_a_mission,
    write_mission,
)
from ssjs_cli.formats.tum import PoseSeries

UNICYCLE = "time_s,speed_m_s,turn_rate_rad_s\n"
POLAR = "time_s,range_m,bearing_rad\n"
NAMED = "time_s,range_m,bearing_rad,landmark_id\n"

GOOD = {
    "mission.toml": '[mission]\nname = "a"\n',
    "odometry.csv": UNICYCLE + "0,1,0\n1,1,0\n2,1,0\n",
    "observations.csv": POLAR + "1,5,0.1\n1,6,-0.1\n2,4,0.1\n",
}


def mission_of(tmp_path: Path, **changes: str | None) -> Path:
    """A small valid mission with some files replaced or, by None, left out. Dots of the names are written __."""
    directory = tmp_path / "mission"
    directory.mkdir()
    for name, text in {**GOOD, **{key.replace("__", "."): value for key, value in changes.items()}}.items():
        if text is not None:
            (directory / name).write_text(text)
    return directory


def refused(tmp_path: Path, **changes: str | None) -> str:
    directory = mission_of(tmp_path, **changes)
    with pytest.raises(UserError) as caught:
        read_mission(directory)
    return str(caught.value).replace(str(directory) + "/", "").replace(str(directory), "mission")


def full_mission() -> Mission:
    return Mission(
        name="full",
        description="all parts",
        notes="a note",
        odometry=Odometry("increments", np.array([[1.0, 0.1, 0.2, 0.3, 0.01, 0.02, 0.03], [2.0, 0.1, 1 / 3, 0.3, 0.01, 0.02, 0.03]])),
        observations=Observations(
            np.array([1.0, 2.0]),
            np.array([3.0, 0.1 + 0.2]),
            np.array([-0.5, math.pi / 7]),
            np.array([[0.01, 0.001, 0.02], [0.01, -0.001, 0.02]]),
            np.array([7, 2**53 - 1]),
        ),
        scans=Scans(np.array([1.0, 2.0]), np.array([[1.0, 2.0, 80.0], [1.5, 2.5, 81.0]]), -1.5, 0.01),
        settings={"sensor": {"range_sigma_m": 0.2}},
        reference=Reference(
            ReferenceDescription(lever_arm_forward_m=0.5, outlier_m=10.0, alignment="se2"),
            PoseSeries(np.array([0.5, 1.5]), np.array([[1.0, 2.0, 0.0], [1.0, 2.0, 0.0]])),
            Fixes(np.array([0.5]), np.array([[1.0, 1 / 3]]), np.array([0.8])),
            SurveyedLandmarks(np.array([3, -1]), np.array([[1.0, 2.0], [3.0, 1 / 3]])),
        ),
        geodetic=Geodetic(origin_latitude_deg=-33.9, origin_longitude_deg=151.2, heading_deg=0.0),
        import_record=ImportRecord(format="csv", counts={"odometry_records": 2}, lost=["a line"], digests={"x.csv": "00"}),
    )


def test_a_mission_reads_back_the_same(tmp_path: Path) -> None:
    written = full_mission()
    write_mission(tmp_path, written)
    read = read_mission(tmp_path)
    assert (read.name, read.description, read.notes) == ("full", "all parts", "a note")
    assert read.settings == written.settings
    assert read.geodetic == written.geodetic
    assert read.import_record == written.import_record
    assert read.reference.description == written.reference.description
    assert read.odometry.kind == "increments"
    assert np.array_equal(read.odometry.values, written.odometry.values)
    for part in ("observations", "scans"):
        for name, value in vars(getattr(written, part)).items():
            assert np.array_equal(getattr(getattr(read, part), name), value), (part, name)
    assert read.reference.fixes is not None
    assert np.array_equal(read.reference.fixes.position_m, [[1.0, 1 / 3]])
    assert read.reference.landmarks is not None
    assert read.reference.landmarks.ids.tolist() == [3, -1]
    assert read.reference.truth is not None
    assert read.reference.truth.pose == pytest.approx(np.array([[1.0, 2.0, 0.0]] * 2))


def test_the_same_mission_gives_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        write_mission(tmp_path / name, full_mission())
    digests = input_digests(tmp_path / "a")
    assert len(digests) == 7
    assert digests == input_digests(tmp_path / "b")


def test_a_mission_may_be_named_by_its_file(tmp_path: Path) -> None:
    assert read_mission(mission_of(tmp_path) / "mission.toml").name == "a"


def test_observations_in_the_body_frame_become_range_and_bearing(tmp_path: Path) -> None:
    observations = read_mission(mission_of(tmp_path, observations__csv="time_s,x_m,y_m,landmark_id\n1,3,4,9\n")).observations
    assert observations is not None
    assert observations.range_m.tolist() == [5.0]
    assert observations.bearing_rad.tolist() == [math.atan2(4.0, 3.0)]
    assert observations.landmark_id is not None
    assert observations.landmark_id.tolist() == [9]


def test_an_unknown_landmark_is_an_empty_field(tmp_path: Path) -> None:
    directory = mission_of(tmp_path, observations__csv=NAMED + "1,5,0,3\n1,5,0,\n")
    mission = read_mission(directory)
    assert mission.observations is not None
    assert mission.observations.landmark_id is not None
    assert mission.observations.landmark_id.tolist() == [3, UNKNOWN_LANDMARK]
    write_mission(directory, mission)
    assert (directory / "observations.csv").read_text() == NAMED + "1.0,5.0,0.0,3\n1.0,5.0,0.0,\n"


def test_a_beam_without_return_may_be_infinite(tmp_path: Path) -> None:
    directory = mission_of(tmp_path, observations__csv=None)
    write_scans(directory, range_m=[[1.0, math.inf], [3.0, 4.0]])
    scans = read_mission(directory).scans
    assert scans is not None
    assert scans.range_m.tolist() == [[1.0, math.inf], [3.0, 4.0]]


def test_a_mission_without_observations_is_allowed(tmp_path: Path) -> None:
    assert read_mission(mission_of(tmp_path, observations__csv=None)).observations is None
    shutil.rmtree(tmp_path / "mission")
    assert read_mission(mission_of(tmp_path, observations__csv=POLAR)).observations is None


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"mission__toml": None}, "mission.toml: is missing; write one with a name in its [mission] table, or use `ssjs-cli import`"),
        ({"mission__toml": "[mission]\n"}, "mission.toml: key 'mission.name' is missing; add it"),
        ({"mission__toml": "[mission]\nname = 3\n"}, "mission.toml: mission.name = 3: Input should be a valid string"),
        (
            {"mission__toml": '[mission]\nname = "a"\ndescripton = "b"\n[refrence]\noutlier_m = 1.0\n'},
            "mission.toml: unknown key 'mission.descripton' (did you mean 'mission.description'?)\n"
            "mission.toml: unknown key 'refrence' (did you mean 'reference'?)",
        ),
        (
            {"mission__toml": '[mission]\nname = "a"\n[reference]\noutlier_m = 0.0\n'},
            "mission.toml: reference.outlier_m = 0.0: Input should be greater than 0",
        ),
        ({"odometry__csv": None}, "odometry.csv: is missing; a mission needs its odometry, with the columns "),
        (
            {"odometry__csv": UNICYCLE},
            "odometry.csv: the mission is empty: there is no line after the header; give at least one odometry record",
        ),
        ({"odometry__csv": UNICYCLE + "0,1,0\n1,nan,0\n"}, "odometry.csv:3: speed_m_s is empty or NaN; "),
        (
            {"odometry__csv": UNICYCLE + "0,1,0\n2,1,0\n1,1,0\n"},
            "odometry.csv:4: time_s = 1.0 goes back from 2.0; sort the lines by time",
        ),
        (
            {"odometry__csv": "time_s,speed_m_s,turn_rate_deg_s\n"},
            "odometry.csv:1: unknown column 'turn_rate_deg_s' (did you mean 'turn_rate_rad_s'?)",
        ),
        (
            {"odometry__csv": "time_s,speed_m_s,turn_rate_rad_s,steering_rad\n"},
            "odometry.csv:1: holds the columns of ackerman and unicycle odometry",
        ),
        (
            {"odometry__csv": "time_s,dx_m,dy_m,dheading_rad,sigma_x_m,sigma_y_m,sigma_heading_rad\n1,0,0,0,0.1,0,0.1\n"},
            "odometry.csv:2: sigma_y_m = 0.0 must be positive; give the noise of the sensor",
        ),
        ({"observations__csv": POLAR + "1,-5,0\n"}, "observations.csv:2: range_m = -5.0 must be positive; correct or remove the line"),
        ({"observations__csv": POLAR + "1,5,0\n0,5,0\n"}, "observations.csv:3: time_s = 0.0 goes back from 1.0"),
        (
            {"observations__csv": "time_s,range_m,bearing_deg\n1,5,0\n"},
            "observations.csv:1: unknown column 'bearing_deg' (did you mean 'bearing_rad'?)",
        ),
        (
            {"observations__csv": NAMED + "1,5,0,3\n1,5,0,-1\n"},
            "observations.csv:3: landmark_id must not be negative; leave it empty where the landmark is unknown",
        ),
        (
            {"observations__csv": NAMED + "1,5,0,3.5\n"},
            "observations.csv:2: landmark_id = 3.5 must be a whole number",
        ),
        (
            {"observations__csv": "time_s,range_m,bearing_rad,var_range_m2,cov_range_bearing,var_bearing_rad2\n1,5,0,-1,0,1\n"},
            "observations.csv:2: var_range_m2 = -1.0 must be positive",
        ),
        (
            {"observations__csv": "time_s,range_m,bearing_rad,var_range_m2,cov_range_bearing,var_bearing_rad2\n1,5,0,1,1,1\n"},
            "observations.csv:2: cov_range_bearing is too large for its variances; the covariance must be positive definite",
        ),
        (
            {"observations__csv": "time_s,range_m,bearing_rad,var_range_m2\n1,5,0,1\n"},
            "observations.csv:1: column cov_range_bearing,var_bearing_rad2 is missing",
        ),
        ({"reference_fixes__csv": "time_s,x_m,y_m,sigma_m\n1,0,0,0\n"}, "reference_fixes.csv:2: sigma_m = 0.0 must be positive"),
        (
            {"truth_landmarks__csv": "id,x_m,y_m\n1,0,0\n1,2,2\n"},
            "truth_landmarks.csv:3: landmark 1 appears twice; give each landmark one line",
        ),
        ({"truth_trajectory__tum": "0 0 0 0 0 0 0 2\n"}, "truth_trajectory.tum:1: qx qy qz qw has the length 2, not 1"),
    ],
)
def test_every_fault_names_the_file_the_line_and_the_mend(tmp_path: Path, changes: dict[str, str | None], message: str) -> None:
    assert refused(tmp_path, **changes).startswith(message)


def test_a_directory_that_does_not_exist_is_named(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"nowhere: is no mission directory; name the directory that holds mission\.toml"):
        read_mission(tmp_path / "nowhere")


def write_scans(directory: Path, **changes: object) -> None:
    arrays = {"time_s": [1.0, 2.0], "range_m": [[1.0, 2.0], [3.0, 4.0]], "first_angle_rad": -1.0, "step_rad": 0.1}
    np.savez(directory / "scans.npz", **{name: np.asarray(value) for name, value in {**arrays, **changes}.items()})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"time_s": [2.0, 1.0]}, r"scans\.npz: time_s of scan 1 goes back from 2\.0 to 1\.0; sort the scans"),
        ({"time_s": [1.0, 2.0, 3.0]}, r"scans\.npz: time_s \(3,\) and range_m \(2, 2\) must be \(n,\) and \(n, beams\)"),
        ({"range_m": [[1.0, math.nan], [3.0, 4.0]]}, r"scans\.npz: range_m of scan 0 is not a number; write no return as infinity"),
        ({"range_m": [["a", "b"], ["c", "d"]]}, r"scans\.npz: range_m holds <U1, not numbers"),
        ({"step_rad": math.inf}, r"scans\.npz: step_rad must be one finite number"),
        ({"range_m": np.array([{}, {}], dtype=object)}, r"scans\.npz: is damaged or no scan archive"),
    ],
)
def test_faulty_scans_are_refused(tmp_path: Path, changes: dict[str, object], message: str) -> None:
    directory = mission_of(tmp_path, observations__csv=None)
    write_scans(directory, **changes)
    with pytest.raises(UserError, match=message):
        read_mission(directory)


def test_a_truncated_scan_archive_is_refused(tmp_path: Path) -> None:
    directory = mission_of(tmp_path, observations__csv=None)
    write_scans(directory)
    path = directory / "scans.npz"
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(UserError, match=r"scans\.npz: is damaged or no scan archive"):
        read_mission(directory)


def test_a_scan_archive_that_unfolds_too_far_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from ssjs_cli.formats import mission

    directory = mission_of(tmp_path, observations__csv=None)
    with zipfile.ZipFile(directory / "scans.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("range_m.npy", b"\0" * 1_000_000)
    monkeypatch.setattr(mission, "MAX_SCANS_BYTES", 100_000)
    with pytest.raises(UserError, match=r"scans\.npz: unfolds to 1000000 bytes, more than the 100000 allowed"):
        read_mission(directory)


def test_what_is_no_mission_directory(tmp_path: Path) -> None:
    assert why_not_a_mission(tmp_path) == "it holds no mission.toml"
    directory = mission_of(tmp_path)
    assert why_not_a_mission(directory) is None
    (directory / "notes.txt").write_text("mine")
    assert why_not_a_mission(directory) == "it also holds notes.txt"
