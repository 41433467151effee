"""Short missions over one seabed, and how right their merged map is: the truth is the simulator's."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ssjs_cli import _core
from ssjs_cli.formats.geographic import from_longitude_latitude
from ssjs_cli.formats.mission import Geodetic
from ssjs_cli.studies.season_map import SeasonMap

CORNER = Geodetic(origin_latitude_deg=41.7, origin_longitude_deg=2.9, heading_deg=0.0, y_axis="right")
LINES = {"lines": 3, "line_length_m": 60.0, "line_spacing_m": 20.0, "cross_lines": 1}
SEABED = {"world_seed": 11, "north_m": 160.0, "east_m": 160.0, "landmarks": 120, "origin_sigma_m": 3.0}


def scenario_text(seabed: dict[str, float] | None = None, lines: dict[str, float] | None = None) -> str:
    """Of one mission of the season; the seed says which."""
    tables = [("season", {**SEABED, **(seabed or {})}), ("survey.lines", {**LINES, **(lines or {})})]
    text = 'scenario = "auv-survey"\nname = "dive"\n'
    for name, table in tables:
        text += f"[{name}]\n" + "".join(f"{key} = {value}\n" for key, value in table.items())
    return text


def true_objects(seabed: dict[str, float] | None = None) -> NDArray[np.float64]:
    """(n, 3) north, east of the corner, depth; the row is the identity."""
    found = _core.simulate_on_shared_seabed(1, {"duration_s": 1.0}, LINES, {**SEABED, **(seabed or {})})
    objects: NDArray[np.float64] = found["seabed_landmarks"]
    return objects


@dataclass
class Score:
    """Of sightings beyond the first of an object: merged with it, merged with another's, left apart. nees: of the merged contacts."""

    right: int = 0
    wrong: int = 0
    missed: int = 0
    nees: list[float] = field(default_factory=list)


def score(made: SeasonMap, objects: NDArray[np.float64], landmark_objects: dict[tuple[str, int], int]) -> Score:
    """landmark_objects: identity of every landmark, by run directory and number."""
    result = Score()
    pieces: dict[int, int] = {}
    for region in made.regions:
        corner = CORNER
        places = np.array([[corner.origin_longitude_deg, corner.origin_latitude_deg]])
        region_p_corner = from_longitude_latitude(places, region.origin)[0]
        for contact in region.contacts:
            of = [landmark_objects[seen] for seen in contact.seen_by]
            most = max(set(of), key=of.count)
            result.right += of.count(most) - 1
            result.wrong += len(of) - of.count(most)
            pieces[most] = pieces.get(most, 0) + 1
            if len(of) > 1 and of.count(most) == len(of):
                error = np.array(contact.position_m[:2]) - region_p_corner - objects[most, :2]
                xx, xy, yy = contact.covariance_m2
                result.nees.append(float(error @ np.linalg.solve(np.array([[xx, xy], [xy, yy]]), error)))
    result.missed = sum(count - 1 for count in pieces.values())
    return result


def identities(runs: Sequence[Path]) -> dict[tuple[str, int], int]:
    """The number of a landmark is that of its source where the simulator tells it."""
    found = {}
    for run in runs:
        rows = np.loadtxt(run / "landmarks.csv", delimiter=",", skiprows=1, usecols=0, ndmin=1).astype(int)
        found.update({(run.name, int(row)): int(row) for row in rows})
    return found
