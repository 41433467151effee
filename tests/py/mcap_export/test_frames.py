"""Down is down and north is north in a viewer that is z up."""

import math
from pathlib import Path

import numpy as np
import pytest
from exported_survey import Survey
from scipy.spatial.transform import Rotation

from ssjs_cli.formats.mission import Geodetic
from ssjs_cli.mcap_export import scene
from ssjs_cli.mcap_export.frames import map_R_world, quaternion_of, vehicle_R_base_link


def at(heading_deg: float, y_axis: str) -> Geodetic:
    return Geodetic(origin_latitude_deg=41.0, origin_longitude_deg=3.0, heading_deg=heading_deg, y_axis=y_axis)


def test_north_east_down_becomes_east_north_up() -> None:
    R = map_R_world(at(0.0, "right"), under_water=True)
    assert (R @ [1.0, 2.0, 3.0]).tolist() == pytest.approx([2.0, 1.0, -3.0])


def test_east_north_up_stays() -> None:
    assert map_R_world(at(90.0, "left"), under_water=False) == pytest.approx(np.eye(3))
    assert map_R_world(None, under_water=False) == pytest.approx(np.eye(3))


def test_a_planar_world_that_points_south_has_its_left_in_the_east() -> None:
    R = map_R_world(at(180.0, "left"), under_water=False)
    assert (R @ [1.0, 0.0, 0.0]).tolist() == pytest.approx([0.0, -1.0, 0.0])
    assert (R @ [0.0, 1.0, 0.0]).tolist() == pytest.approx([1.0, 0.0, 0.0])


@pytest.mark.parametrize("geodetic", [None, at(0.0, "right"), at(33.0, "left"), at(217.0, "right")])
@pytest.mark.parametrize("under_water", [True, False])
def test_frames_are_right_handed(geodetic: Geodetic | None, under_water: bool) -> None:
    R = map_R_world(geodetic, under_water=under_water)
    assert np.linalg.det(R) == pytest.approx(1.0)
    assert np.linalg.det(vehicle_R_base_link(under_water=under_water)) == pytest.approx(1.0)
    assert Rotation.from_quat(quaternion_of(R)).as_matrix() == pytest.approx(R)


def test_the_chain_of_transforms_puts_the_vehicle_below_the_surface_and_its_up_side_up(survey: Survey) -> None:
    (fixed,) = survey.recording.contents("/tf_static")
    turns = {entry["child_frame_id"]: entry for entry in fixed["transforms"]}
    assert turns["world"]["parent_frame_id"] == "map" and turns["base_link"]["parent_frame_id"] == "vehicle"
    map_T_world, vehicle_T_base = (_rotation(turns[name]) for name in ("world", "base_link"))
    for content in survey.recording.contents("/tf")[::50]:
        moving = {entry["child_frame_id"]: entry for entry in content["transforms"]}
        vehicle = moving["vehicle"]
        assert vehicle["parent_frame_id"] == "world" and moving["dead_reckoning"]["parent_frame_id"] == "world"
        map_p_vehicle = map_T_world.apply([vehicle["translation"][axis] for axis in "xyz"])
        assert -25.0 < map_p_vehicle[2] < 0.5  # the survey dives to 14 m
        map_R_base = map_T_world * _rotation(vehicle) * vehicle_T_base
        assert map_R_base.apply([0.0, 0.0, 1.0])[2] > math.cos(math.radians(60.0))


def _rotation(transform: dict[str, dict[str, float]]) -> Rotation:
    return Rotation.from_quat([transform["rotation"][axis] for axis in "xyzw"])


def test_positions_on_earth_are_north_where_x_is(survey: Survey) -> None:
    for content, fix in zip(survey.recording.contents("/pose/corrected"), survey.recording.contents("/position"), strict=True):
        north_m, east_m, depth_m = (content["pose"]["position"][axis] for axis in "xyz")
        # one degree of latitude is 111.1 km at 41.78 degrees, one of longitude 83.1 km
        assert (fix["latitude"] - 41.78) * 111_070.0 == pytest.approx(north_m, abs=0.5)
        assert (fix["longitude"] - 3.03) * 83_130.0 == pytest.approx(east_m, abs=0.5)
        assert fix["altitude"] == -depth_m


def test_the_covariance_of_a_position_is_east_north_up(survey: Survey) -> None:
    rows = (survey.run / "trajectory_covariance.csv").read_text().splitlines()
    names = rows[0].split(",")
    last = dict(zip(names, map(float, rows[-1].split(",")), strict=True))
    C = np.array(survey.recording.contents("/position")[-1]["position_covariance"]).reshape(3, 3)
    assert (
        C[0, 0] == pytest.approx(last["var_yy"]) and C[1, 1] == pytest.approx(last["var_xx"]) and C[2, 2] == pytest.approx(last["var_zz"])
    )
    assert C[0, 1] == pytest.approx(last["cov_xy"]) and C[0, 2] == pytest.approx(-last["cov_yz"])


def test_an_ellipsoid_has_the_axes_of_its_covariance() -> None:
    turn = Rotation.from_euler("zyx", [0.4, -0.3, 0.2]).as_matrix()
    covariance = turn @ np.diag([4.0, 1.0, 0.25]) @ turn.T
    shape = scene.ellipsoid((1.0, 2.0, 3.0), covariance, scene.LANDMARK)
    # 3 sigma to each side: 6 times 2, 1 and 0.5 m
    size = np.array([shape["size"][axis] for axis in "xyz"])
    assert sorted(size.tolist()) == pytest.approx([3.0, 6.0, 12.0])
    R = Rotation.from_quat([shape["pose"]["orientation"][axis] for axis in "xyzw"]).as_matrix()
    assert R @ np.diag((size / 6.0) ** 2) @ R.T == pytest.approx(covariance)
    assert [shape["pose"]["position"][axis] for axis in "xyz"] == [1.0, 2.0, 3.0]


def test_the_sigmas_to_plot_are_those_of_the_covariance_file(survey: Survey) -> None:
    rows = Path(survey.run / "trajectory_covariance.csv").read_text().splitlines()
    names = rows[0].split(",")
    for text, shown in list(zip(rows[1:], survey.recording.contents("/uncertainty"), strict=True))[::40]:
        row = dict(zip(names, map(float, text.split(",")), strict=True))
        assert shown["sigma_x_m"] == pytest.approx(math.sqrt(row["var_xx"]))
        assert shown["sigma_z_m"] == pytest.approx(math.sqrt(row["var_zz"]))
        assert shown["sigma_heading_rad"] == pytest.approx(math.sqrt(row["var_hh"]))
        trace, half_difference = row["var_xx"] + row["var_yy"], (row["var_xx"] - row["var_yy"]) / 2.0
        largest = trace / 2.0 + math.hypot(half_difference, row["cov_xy"])
        assert shown["sigma_major_m"] == pytest.approx(math.sqrt(largest), rel=1e-6, abs=1e-9)
