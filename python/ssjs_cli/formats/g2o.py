"""Pose graphs in the g2o text format: VERTEX_SE2 and EDGE_SE2.

The information of an edge belongs to g2o's error, which lies in the frame of the measured pose: an additive covariance, which
lies in the frame the edge starts from, is turned by the measured heading before it is inverted.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ssjs_cli.errors import UserError
from ssjs_cli.formats.number_table import FloatArray

VERTEX_FIELDS = 5
EDGE_FIELDS = 12


@dataclass(frozen=True)
class Vertex:
    """pose: x m, y m, heading rad, in the global frame."""

    id: int
    pose: tuple[float, float, float]


@dataclass(frozen=True)
class Edge:
    """measured_pose: `to` in the frame of `from`, x m, y m, heading rad.
    information: I11 I12 I13 I22 I23 I33 of (x, y, heading) in the frame of `to` as measured."""

    from_id: int
    to_id: int
    measured_pose: tuple[float, float, float]
    information: tuple[float, float, float, float, float, float]


@dataclass(frozen=True)
class PoseGraph:
    vertices: list[Vertex] = field(default_factory=list)
    edges: list[Edge] = field(default_factory=list)


def edge_information(from_T_to: Sequence[float], covariance: Sequence[float]) -> tuple[float, float, float, float, float, float]:
    """The upper triangle of the edge's information from the upper triangle of the additive covariance."""
    xx, xy, xh, yy, yh, hh = covariance
    additive: FloatArray = np.array([[xx, xy, xh], [xy, yy, yh], [xh, yh, hh]])
    cosine, sine = np.cos(from_T_to[2]), np.sin(from_T_to[2])
    to_R_from: FloatArray = np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    information = np.linalg.inv(to_R_from @ additive @ to_R_from.T)
    information = 0.5 * (information + information.T)
    i11, i12, i13, i22, i23, i33 = (float(information[row, column]) for row in range(3) for column in range(row, 3))
    return i11, i12, i13, i22, i23, i33


def g2o_text(graph: PoseGraph) -> str:
    lines = [f"VERTEX_SE2 {vertex.id} " + " ".join(map(repr, vertex.pose)) for vertex in graph.vertices]
    for edge in graph.edges:
        lines.append(f"EDGE_SE2 {edge.from_id} {edge.to_id} " + " ".join(map(repr, (*edge.measured_pose, *edge.information))))
    return "".join(line + "\n" for line in lines)


def read_g2o(path: Path) -> PoseGraph:
    graph = PoseGraph()
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        fields = line.split("#")[0].split()
        if not fields:
            continue
        where = f"{path}:{number}"
        if fields[0] == "VERTEX_SE2":
            values = _numbers(fields, VERTEX_FIELDS, 1, where)
            graph.vertices.append(Vertex(int(fields[1]), (values[0], values[1], values[2])))
        elif fields[0] == "EDGE_SE2":
            values = _numbers(fields, EDGE_FIELDS, 2, where)
            x, y, heading, i11, i12, i13, i22, i23, i33 = values
            graph.edges.append(Edge(int(fields[1]), int(fields[2]), (x, y, heading), (i11, i12, i13, i22, i23, i33)))
        elif fields[0] != "FIX":
            raise UserError(f"{where}: '{fields[0]}' is not known here; only VERTEX_SE2, EDGE_SE2 and FIX are read")
    return graph


def _numbers(fields: list[str], count: int, identities: int, where: str) -> list[float]:
    if len(fields) != count:
        raise UserError(f"{where}: {fields[0]} has {len(fields)} fields where {count} are needed; complete or remove the line")
    try:
        for text in fields[1 : 1 + identities]:
            int(text)
        return [float(text) for text in fields[1 + identities :]]
    except ValueError as error:
        raise UserError(f"{where}: {error}; correct or remove the line") from error
