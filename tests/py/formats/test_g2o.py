import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ssjs_cli.errors import UserError
from ssjs_cli.formats.g2o import Edge, PoseGraph, Vertex, edge_information, g2o_text, read_g2o

NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
POSES = st.tuples(NUMBERS, NUMBERS, NUMBERS)
IDS = st.integers(0, 10**9)
VERTICES = st.builds(Vertex, IDS, POSES)
EDGES = st.builds(Edge, IDS, IDS, POSES, st.tuples(*[NUMBERS] * 6))


@given(graph=st.builds(PoseGraph, st.lists(VERTICES, max_size=8), st.lists(EDGES, max_size=8)))
def test_graphs_read_back_the_same(graph: PoseGraph, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("g2o") / "graph.g2o"
    path.write_text(g2o_text(graph))
    assert read_g2o(path) == graph


def test_the_lines_of_the_format() -> None:
    graph = PoseGraph([Vertex(0, (0.0, 0.5, 1.0))], [Edge(0, 1, (1.0, 2.0, 3.0), (4.0, 0.0, 0.0, 5.0, 0.0, 6.0))])
    assert g2o_text(graph) == "VERTEX_SE2 0 0.0 0.5 1.0\nEDGE_SE2 0 1 1.0 2.0 3.0 4.0 0.0 0.0 5.0 0.0 6.0\n"


def test_without_a_turn_the_information_is_the_inverse_of_the_covariance() -> None:
    # diag(0.25, 4, 0.01) inverted is diag(4, 0.25, 100)
    assert edge_information((1.0, 2.0, 0.0), (0.25, 0.0, 0.0, 4.0, 0.0, 0.01)) == pytest.approx((4.0, 0.0, 0.0, 0.25, 0.0, 100.0))


def test_after_a_quarter_turn_the_axes_of_the_information_change_places() -> None:
    # The measured pose looks along the old y: what was uncertain along y is uncertain along its x.
    information = edge_information((1.0, 2.0, math.pi / 2), (0.25, 0.0, 0.0, 4.0, 0.0, 0.01))
    assert information == pytest.approx((0.25, 0.0, 0.0, 4.0, 0.0, 100.0), abs=1e-12)


def test_g2o_error_has_the_written_information() -> None:
    """The covariance of g2o's error, by differences: e = (R(h)' ((x, y) - (x0, y0)), heading - heading0)."""
    pose = (1.0, -2.0, 0.7)
    factor = np.array([[0.3, 0.0, 0.0], [0.1, 0.2, 0.0], [-0.05, 0.02, 0.04]])
    covariance = factor @ factor.T
    c, s = math.cos(pose[2]), math.sin(pose[2])
    J_error = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    expected = np.linalg.inv(J_error @ covariance @ J_error.T)
    upper = [covariance[row, column] for row in range(3) for column in range(row, 3)]
    assert edge_information(pose, upper) == pytest.approx([expected[row, column] for row in range(3) for column in range(row, 3)])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("VERTEX_SE2 0 0 0\n", r"graph\.g2o:1: VERTEX_SE2 has 4 fields where 5 are needed"),
        ("# c\nEDGE_SE2 0 1 a 0 0 1 0 0 1 0 1\n", r"graph\.g2o:2: .*'a'"),
        ("VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n", r"graph\.g2o:1: 'VERTEX_SE3:QUAT' is not known here"),
    ],
)
def test_faults_name_the_line(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "graph.g2o"
    path.write_text(text)
    with pytest.raises(UserError, match=message):
        read_g2o(path)
