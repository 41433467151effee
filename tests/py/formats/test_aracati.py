from pathlib import Path

import numpy as np
import pytest

from ssjs_cli.config import layer_from_tables, resolve
from ssjs_cli.errors import UserError
from ssjs_cli.formats.aracati import SETTINGS, SPEED_SIGMA_M_S, WALK_SIGMA_M_SQRT_S, read_aracati
from ssjs_cli.formats.mission import read_mission, write_mission

# East for 1 m, a quarter turn to the left, then north for 2 m in 4 s.
KEYFRAMES = (
    "keyframe_id,time,dr_x,dr_y,dr_theta,dgps_x,dgps_y,compass_ned_theta\n"
    "0,100.0,5.0,3.0,0.0,0.0,0.0,2.1\n"
    f"1,103.0,6.0,3.0,{np.pi / 2},1.0,0.1,0.5\n"
    f"4,107.0,6.0,5.0,{np.pi / 2},1.1,2.0,0.5\n"
)
HITS = "keyframe_id,range_m,bearing_rad,intensity\n1,10.0,0.1,255\n1,11.0,-0.2,250\n4,12.0,0.3,255\n"


def source(tmp_path: Path, keyframes: str = KEYFRAMES, hits: str = HITS) -> Path:
    (tmp_path / "keyframes.csv").write_text(keyframes)
    (tmp_path / "sonar_points_body.csv").write_text(hits)
    return tmp_path


def test_increments_are_seen_from_the_keyframe_before(tmp_path: Path) -> None:
    odometry = read_aracati(source(tmp_path)).odometry
    assert odometry is not None
    assert odometry.kind == "increments"
    assert odometry.values[:, :4] == pytest.approx(
        np.array([[100.0, 0.0, 0.0, 0.0], [103.0, 1.0, 0.0, np.pi / 2], [107.0, 2.0, 0.0, 0.0]]), abs=1e-12
    )
    # 4 s of a wrong speed, and the walk of 4 s
    assert odometry.values[2, 4] == pytest.approx(np.sqrt((4.0 * SPEED_SIGMA_M_S) ** 2 + 4.0 * WALK_SIGMA_M_SQRT_S**2))


def test_hits_get_the_time_of_their_keyframe_and_the_reference_is_the_dgps(tmp_path: Path) -> None:
    mission = read_aracati(source(tmp_path))
    assert mission.sonar_hits is not None
    assert mission.sonar_hits.time_s.tolist() == [103.0, 103.0, 107.0]
    assert mission.sonar_hits.bearing_rad.tolist() == [0.1, -0.2, 0.3]
    assert mission.reference.fixes is not None
    assert mission.reference.fixes.position_m.tolist() == [[0.0, 0.0], [1.0, 0.1], [1.1, 2.0]]
    assert mission.import_record is not None
    assert mission.import_record.counts == {"keyframes": 3, "sonar_hits": 3, "sonar_images": 2, "dgps_fixes": 3}


def test_hits_in_any_order_of_the_keyframes(tmp_path: Path) -> None:
    lines = HITS.splitlines(keepends=True)
    mission = read_aracati(source(tmp_path, hits="".join([lines[0], lines[3], lines[1], lines[2]])))
    assert mission.sonar_hits is not None
    assert mission.sonar_hits.time_s.tolist() == [103.0, 103.0, 107.0]
    assert mission.sonar_hits.range_m.tolist() == [10.0, 11.0, 12.0]


def test_a_mission_with_sonar_hits_is_written_and_read_back(tmp_path: Path) -> None:
    mission = read_aracati(source(tmp_path))
    directory = tmp_path / "mission"
    directory.mkdir()
    write_mission(directory, mission)
    again = read_mission(directory)
    assert again.sonar_hits is not None and mission.sonar_hits is not None
    for name in ("time_s", "range_m", "bearing_rad", "intensity"):
        assert getattr(again.sonar_hits, name).tolist() == getattr(mission.sonar_hits, name).tolist()


def test_the_settings_are_settings_of_the_estimator() -> None:
    assert resolve([layer_from_tables(SETTINGS, "aracati")]).values["vehicle.kind"] == "increments"


@pytest.mark.parametrize(
    ("keyframes", "hits", "message"),
    [
        (KEYFRAMES, HITS.replace("4,12.0", "3,12.0"), r"sonar_points_body\.csv:4: keyframe 3 is not in keyframes\.csv"),
        (KEYFRAMES, HITS.replace("11.0", "-1.0"), r"sonar_points_body\.csv:3: .*range_m"),
        (KEYFRAMES, HITS.replace("11.0", "far"), r"sonar_points_body\.csv:3"),
        (KEYFRAMES, HITS.splitlines()[0] + "\n", r"sonar_points_body\.csv: holds no sonar hit"),
        (KEYFRAMES.replace("103.0", "99.0"), HITS, r"keyframes\.csv:3: time does not increase"),
        (KEYFRAMES.replace("4,107.0", "1,107.0"), HITS, r"keyframes\.csv:4: keyframe_id does not increase"),
        (KEYFRAMES.replace("dr_x", "dr_east"), HITS, r"keyframes\.csv.*dr_x"),
        ("\n".join(KEYFRAMES.splitlines()[:2]) + "\n", HITS, r"keyframes\.csv: holds 1 keyframes"),
    ],
)
def test_bad_input_is_named(tmp_path: Path, keyframes: str, hits: str, message: str) -> None:
    with pytest.raises(UserError, match=message):
        read_aracati(source(tmp_path, keyframes, hits))


def test_missing_files_are_named(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"keyframes\.csv: is missing"):
        read_aracati(tmp_path)
    with pytest.raises(UserError, match=r"nowhere: is no directory"):
        read_aracati(tmp_path / "nowhere")
