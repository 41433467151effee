import json
import math

import numpy as np
import pytest

from ssjs_cli.errors import UserError
from ssjs_cli.report.result_files import read_run_files


def write(run_dir, name, text):
    (run_dir / name).write_text(text, encoding="utf-8")


@pytest.fixture
def bare_run(tmp_path):
    write(tmp_path, "summary.json", "{}")
    return tmp_path


def test_only_the_summary_is_needed(bare_run):
    files = read_run_files(bare_run)
    absent = (files.trajectory, files.landmarks, files.submaps, files.errors, files.nees, files.nis, files.step_times, files.config)
    assert absent == (None,) * 8


def test_missing_summary_names_directory_and_mend(tmp_path):
    with pytest.raises(UserError, match=r"holds no summary\.json; name the directory of a finished run"):
        read_run_files(tmp_path)


def test_heading_is_the_yaw_of_the_quaternion(bare_run):
    # yaw 90 degrees: qz = qw = sqrt(1/2)
    half = math.sqrt(0.5)
    write(bare_run, "trajectory.tum", f"0 1 2 0 0 0 0 1\n0.5 3 4 0 0 0 {half} {half}\n")
    track = read_run_files(bare_run).trajectory
    assert track.heading == pytest.approx([0.0, math.pi / 2.0])
    assert track.position.tolist() == [[1.0, 2.0], [3.0, 4.0]]


@pytest.mark.parametrize(
    ("values", "expected"),
    [(range(1, 7), [1.0, 2.0, 4.0]), (range(1, 22), [1.0, 2.0, 7.0])],  # yy is the 4th of 6 and the 7th of 21 in the upper triangle
)
def test_position_covariance_in_the_plane_and_in_space(bare_run, values, expected):
    row = [str(value) for value in values]
    header = ",".join(["time_s", *(f"c{number}" for number in row)])
    write(bare_run, "trajectory_covariance.csv", f"{header}\n0.0,{','.join(row)}\n")
    assert read_run_files(bare_run).trajectory_covariance.covariance.tolist() == [expected]


def test_covariance_of_another_size_is_refused(bare_run):
    write(bare_run, "trajectory_covariance.csv", "time_s,a,b\n0,1,2\n")
    with pytest.raises(UserError, match=r"trajectory_covariance\.csv:1: has 3 columns"):
        read_run_files(bare_run)


def test_landmark_without_a_number(bare_run):
    write(
        bare_run, "landmarks.csv",
        "id,x_m,y_m,z_m,var_xx,cov_xy,cov_xz,var_yy,cov_yz,var_zz,times_seen,submap\n7,1,2,0,4,1,0,9,0,0,12,3\n,5,6,0,1,0,0,1,0,0,4,3\n",
    )  # fmt: skip
    landmarks = read_run_files(bare_run).landmarks
    assert landmarks.id == ["7", ""]
    assert landmarks.covariance.tolist() == [[4.0, 1.0, 9.0], [1.0, 0.0, 1.0]]
    assert landmarks.submap.tolist() == [3, 3]


def test_fault_names_file_and_line(bare_run):
    write(bare_run, "nees.csv", "time_s,nees,dof\n0.0,1.0,3\n0.1,oops,3\n")
    with pytest.raises(UserError, match=r"nees\.csv:3: .*oops"):
        read_run_files(bare_run)


@pytest.mark.parametrize("submap", [{"base_pose": [0, 0, 0]}, {"index": 0}, {"index": 0, "base_pose": [0, None, 0]}])
def test_submap_without_index_or_base_is_refused(bare_run, submap):
    write(bare_run, "submaps.json", json.dumps({"submaps": [submap], "live_maps": [], "loops": []}))
    with pytest.raises(UserError, match=r"submaps\.json: submaps\[0\] needs"):
        read_run_files(bare_run)


def test_calendar_clock_is_counted_from_the_first_step(bare_run):
    start = 1_288_971_842.25
    write(bare_run, "trajectory.tum", f"{start} 0 0 0 0 0 0 1\n{start + 1.5} 1 0 0 0 0 0 1\n")
    write(bare_run, "consistency.csv", f"time_s,nis,dof\n{start + 0.5},2.0,2\n")
    submap = {"index": 0, "base_pose": [0, 0, 0], "start_time_s": start, "end_time_s": start + 1.5}
    write(bare_run, "submaps.json", json.dumps({"submaps": [submap], "loops": [{"time_s": start + 1.0}]}))
    files = read_run_files(bare_run)
    assert files.time_origin_s == start
    assert files.trajectory.time_s.tolist() == [0.0, 1.5]
    assert files.nis["time_s"].tolist() == [0.5]
    assert (files.submaps.submaps[0]["start_time_s"], files.submaps.submaps[0]["end_time_s"]) == (0.0, 1.5)
    assert files.submaps.loops[0]["time_s"] == 1.0


def test_mission_clock_near_zero_is_left_alone(bare_run):
    write(bare_run, "trajectory.tum", "12.5 0 0 0 0 0 0 1\n13.5 1 0 0 0 0 0 1\n")
    files = read_run_files(bare_run)
    assert files.time_origin_s == 0.0
    assert np.array_equal(files.trajectory.time_s, [12.5, 13.5])
