import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from ssjs_cli.config import layer_from_tables, resolve
from ssjs_cli.errors import UserError
from ssjs_cli.formats.graph import graph_name, read_graph
from ssjs_cli.formats.mission import Mission

# Poses 0, 1, 3 and landmarks 2, 4 share one number space.
GRAPH = """\
ODOMETRY 0 1 1 0.5 0.1 0.04 0 0 0.01 0 0.0001
LANDMARK 1 2 3 4 0.4 0 0.4
ODOMETRY 1 3 1 0 0 0.04 0 0 0.01 0 0.0001
LANDMARK 3 2 2 0 0.4 0 0.4
LANDMARK 3 4 0 -2 0.4 0 0.4
"""


def graph_of(tmp_path: Path, text: str) -> Mission:
    path = tmp_path / "some_graph.txt"
    path.write_text(text)
    return read_graph(path)


def test_increments_carry_their_sigmas_and_times_are_positions_in_the_chain(tmp_path: Path) -> None:
    mission = graph_of(tmp_path, GRAPH)
    assert mission.odometry.kind == "increments"
    # sigma = sqrt(0.04), sqrt(0.01), sqrt(0.0001)
    expected = np.array([[1.0, 1.0, 0.5, 0.1, 0.2, 0.1, 0.01], [2.0, 1.0, 0.0, 0.0, 0.2, 0.1, 0.01]])
    assert mission.odometry.values == pytest.approx(expected)


def test_sightings_become_range_and_bearing_with_their_landmark(tmp_path: Path) -> None:
    observations = graph_of(tmp_path, GRAPH).observations
    assert observations is not None
    assert observations.time_s.tolist() == [1.0, 2.0, 2.0]
    assert observations.range_m.tolist() == [5.0, 2.0, 2.0]
    assert observations.bearing_rad == pytest.approx([math.atan2(4, 3), 0.0, -math.pi / 2])
    assert observations.landmark_id is not None
    assert observations.landmark_id.tolist() == [2, 2, 4]


def test_the_noise_is_that_of_the_published_reader(tmp_path: Path) -> None:
    mission = graph_of(tmp_path, GRAPH)
    values = resolve([layer_from_tables(mission.settings, "graph")]).values
    assert values["sensor.range_sigma_m"] == pytest.approx(0.632, abs=5e-4)
    assert values["sensor.bearing_sigma_rad"] == pytest.approx(0.2)
    assert values["association.method"] == "known"
    assert values["vehicle.kind"] == "increments"


def test_sightings_of_different_noise_keep_their_own(tmp_path: Path) -> None:
    mission = graph_of(tmp_path, GRAPH.replace("0 -2 0.4 0 0.4", "0 -2 0.9 0 0.9"))
    assert mission.observations is not None
    assert mission.observations.covariance is not None
    assert mission.observations.covariance == pytest.approx(np.array([[0.4, 0, 0.04], [0.4, 0, 0.04], [0.9, 0, 0.09]]))


def test_a_line_may_give_informations_instead_of_variances(tmp_path: Path) -> None:
    # The order of TORO: I11 I12 I22 I33 I13 I23; sigma = 1 / sqrt(I)
    mission = graph_of(tmp_path, "ODOMETRY 0 1 1 0 0 25 0 100 10000 0 0\n")
    assert mission.odometry.values[0, 4:] == pytest.approx([0.2, 0.1, 0.01])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"some_graph\.txt: the mission is empty: there is no ODOMETRY line"),
        ("EDGE2 0 1\n", r"some_graph\.txt:1: 'EDGE2' is neither ODOMETRY nor LANDMARK"),
        ("ODOMETRY 0 1 1 0 0 0.04 0 0 0.01 0\n", r"some_graph\.txt:1: ODOMETRY has 11 fields where 12 are needed"),
        ("ODOMETRY 0 1 1 0 nan 0.04 0 0 0.01 0 0.0001\n", r"some_graph\.txt:1: holds NaN or infinity"),
        ("ODOMETRY 0 1 1 0 x 0.04 0 0 0.01 0 0.0001\n", r"some_graph\.txt:1: .*'x'"),
        ("ODOMETRY 0 1 1 0 0 0 0 0 0.01 0 0.0001\n", r"some_graph\.txt:1: the six noise fields .* are no diagonal of positive variances"),
        ("ODOMETRY 0 1 1 0 0 -0.04 0 0 0.01 0 0.0001\n", r"some_graph\.txt:1: the six noise fields"),
        (GRAPH + "ODOMETRY 1 5 1 0 0 0.04 0 0 0.01 0 0.0001\n", r"some_graph\.txt:6: starts at pose 1, which is not the last one"),
        (GRAPH + "ODOMETRY 3 1 1 0 0 0.04 0 0 0.01 0 0.0001\n", r"some_graph\.txt:6: pose 1 exists already"),
        (GRAPH + "LANDMARK 9 2 1 1 0.4 0 0.4\n", r"some_graph\.txt:6: pose 9 is in no ODOMETRY line"),
        (GRAPH + "LANDMARK 3 1 1 1 0.4 0 0.4\n", r"some_graph\.txt:6: 1 is a pose, and poses and landmarks share their numbers"),
        (GRAPH + "LANDMARK 3 2 1 1 0 0 0\n", r"some_graph\.txt:6: the noise 0\.0 0\.0 0\.0 must be positive"),
    ],
)
def test_faults_name_the_line(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(UserError, match=message):
        graph_of(tmp_path, text)


def test_the_name_does_not_collide_with_the_raw_data_set() -> None:
    assert graph_name(Path("a/victoria_park.txt")) == "victoria-park-graph"
    assert graph_name(Path("a/some_graph.txt")) == "some-graph"


def test_the_real_graph(data_set: Callable[[str], Path]) -> None:
    mission = read_graph(data_set("victoria_park_graph") / "victoria_park.txt")
    assert mission.import_record is not None
    assert mission.import_record.counts == {"poses": 6_969, "observations": 3_640, "landmarks": 151}
