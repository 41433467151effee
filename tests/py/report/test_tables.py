import math

import pytest

from ssjs_cli.report.map_figure import MapAxes, SubmapColours
from ssjs_cli.report.result_files import Submaps
from ssjs_cli.report.tables import MAX_REFUSED_ROWS, configuration_sections, loop_rows, submap_columns, submap_rows

AXES = MapAxes(("x", "y"), north_up=False)


def submap(index, **more):
    return {"index": index, "base_pose": [10.0 * index, 5.0, math.pi / 2.0], **more}


def texts(row):
    return [cell.text for cell in row.cells]


def test_submap_row():
    # variances 9 and 1 turned by 30 degrees (7, 2 sqrt 3, 3): sigma along the larger axis 3 m; heading variance (1 degree)^2
    covariance = [7.0, 2.0 * math.sqrt(3.0), 0.0, 3.0, 0.0, math.radians(1.0) ** 2]
    entry = submap(2, start_time_s=4.0, end_time_s=10.5, landmarks=15, live_map=1, base_covariance=covariance, closed_because="landmarks")
    (row,) = submap_rows(Submaps([entry], [], []), AXES, SubmapColours({2: 0}))
    assert texts(row) == ["2", "4.0", "6.5", "15", "1", "20.00", "5.00", "90.0", "3.000", "1.000", "landmarks"]
    assert (row.x, row.y) == (20.0, 5.0)


def test_submap_row_without_details():
    (row,) = submap_rows(Submaps([submap(0)], [], []), AXES, SubmapColours({0: 0}))
    assert texts(row) == ["0", "–", "–", "–", "–", "0.00", "5.00", "90.0", "–", "–", "–"]


def test_base_columns_carry_the_names_of_the_axes():
    assert submap_columns(MapAxes(("north", "east"), north_up=True))[5:7] == ["base north [m]", "base east [m]"]


def test_loop_row_lies_between_its_bases():
    loop = {
        "time_s": 12.0, "from": 3, "to": 1, "accepted": True, "reason": "joined", "pairs": 7, "wrong_pairs": 1, "chi2": 22.0, "dof": 11,
    }  # fmt: skip
    (row,), note = loop_rows(Submaps([submap(1), submap(3)], [], [loop]), AXES)
    assert texts(row) == ["12.0", "3", "1", "joined", "7", "1", "22.0", "11", "2.00", "joined"]
    assert (row.x, row.y, row.wrong, row.refused, note) == (20.0, 5.0, True, False, "")


def test_many_refused_pairs_are_thinned_and_no_accepted_one_is_lost():
    refused = [{"from": 0, "to": 1, "accepted": False, "reason": f"reason {number}"} for number in range(2 * MAX_REFUSED_ROWS)]
    accepted = [{"from": 0, "to": 1, "accepted": True} for _ in range(5)]
    rows, note = loop_rows(Submaps([], [], refused + accepted), AXES)
    assert sum(row.refused for row in rows) == MAX_REFUSED_ROWS
    assert sum(not row.refused for row in rows) == 5
    assert note == "One refused pair in 2 of 2,000 is listed."


def test_configuration_by_section():
    config = {
        "method": "ssjs",
        "vehicle": {"kind": "ackerman", "ackerman": {"wheelbase_m": 2.83}},
        "joining": {"on": True, "list": [1, 2.5]},
    }
    sections = {section.name: section.entries for section in configuration_sections(config)}
    assert sections == {
        "": [("method", "ssjs")],
        "vehicle": [("kind", "ackerman")],
        "vehicle.ackerman": [("wheelbase_m", "2.83")],
        "joining": [("on", "true"), ("list", "1, 2.5")],
    }


@pytest.mark.parametrize("triangle", [None, [1.0], [1.0, 0.0, 0.0, 1.0, 0.0, None], "text"])
def test_unusable_covariance_is_a_dash(triangle):
    (row,) = submap_rows(Submaps([submap(0, base_covariance=triangle)], [], []), AXES, SubmapColours({0: 0}))
    assert texts(row)[8:10] == ["–", "–"]
