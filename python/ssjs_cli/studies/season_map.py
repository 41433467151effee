"""One map of all missions of a season: their contacts merged, their tracks laid over each other. docs/math/season.md."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli import _core
from ssjs_cli.errors import UserError
from ssjs_cli.formats.geographic import from_longitude_latitude, to_longitude_latitude
from ssjs_cli.formats.mission import Geodetic
from ssjs_cli.formats.number_table import FloatArray
from ssjs_cli.studies.season_missions import ApartError, SeasonMission, read_season_mission

#: A plane that touches the earth serves so far: at its edge a length is 3 in 100,000 too long.
REGION_RADIUS_M = 50_000.0
NORTH_STEP_M = 100.0


@dataclass(frozen=True)
class SeasonContact:
    """An object as all missions together know it; in the frame of its region (north, east, depth). seen_by: by mission the number of its
    landmark there."""

    id: int
    position_m: tuple[float, float, float]
    covariance_m2: tuple[float, float, float]
    depth_sigma_m: float
    seen_by: tuple[tuple[str, int], ...]
    times_seen: int


@dataclass(frozen=True)
class PlacedMission:
    """frame: x (north), y (east), heading of its own frame in that of the region, by all missions; sigma_m of that position, and moved_m
    how far it lies from where its origin says. track_m (t, 2) in the region."""

    name: str
    site: int
    frame: tuple[float, float, float]
    sigma_m: float
    moved_m: float
    track_m: FloatArray


@dataclass
class Region:
    """origin: of its frame, x north, y east."""

    origin: Geodetic
    missions: list[PlacedMission] = field(default_factory=list)
    contacts: list[SeasonContact] = field(default_factory=list)


@dataclass
class SeasonMap:
    """apart: missions that are not on it, with the reason."""

    regions: list[Region] = field(default_factory=list)
    apart: list[tuple[str, str]] = field(default_factory=list)

    @property
    def contacts(self) -> list[SeasonContact]:
        return [contact for region in self.regions for contact in region.contacts]


def season_map(directories: Iterable[Path], progress: Callable[[float], bool] | None = None) -> SeasonMap:
    """Missions are joined in the order of time, those of one time in that of their names."""
    made = SeasonMap()
    missions = []
    for directory in directories:
        try:
            missions.append(read_season_mission(directory))
        except (ApartError, UserError) as error:
            made.apart.append((directory.name, str(error)))
    missions.sort(key=lambda mission: (mission.start_s, mission.name))
    for origin, members in _regions(missions):
        try:
            made.regions.append(_merged(origin, members, len(made.contacts), progress))
        except UserError as error:
            made.apart += [(mission.name, str(error)) for mission in members]
    made.apart.sort()
    return made


def _regions(missions: Sequence[SeasonMission]) -> list[tuple[Geodetic, list[SeasonMission]]]:
    regions: list[tuple[Geodetic, list[SeasonMission]]] = []
    for mission in missions:
        for origin, members in regions:
            if abs(mission.origin.origin_latitude_deg - origin.origin_latitude_deg) > 1.0:
                continue
            if math.hypot(*_frame_of(mission.origin, origin)[:2]) < REGION_RADIUS_M:
                members.append(mission)
                break
        else:
            regions.append((mission.origin, [mission]))
    return regions


def _frame_of(mission: Geodetic, region: Geodetic) -> tuple[float, float, float]:
    """Position and heading of the frame of a mission in that of the region, both north-east."""
    places = to_longitude_latitude(np.array([[0.0, 0.0], [NORTH_STEP_M, 0.0]]), mission)
    start, north = from_longitude_latitude(places, region)
    return float(start[0]), float(start[1]), math.atan2(north[1] - start[1], north[0] - start[0])


def _merged(origin: Geodetic, missions: Sequence[SeasonMission], first_id: int, progress: Callable[[float], bool] | None) -> Region:
    maps = _core.SeasonMaps()
    frames = [_frame_of(mission.origin, origin) for mission in missions]
    for mission, frame in zip(missions, frames, strict=True):
        variances = [mission.origin_sigma_m**2] * 2 + [math.radians(mission.heading_sigma_deg) ** 2]
        maps.add(np.array(frame), np.diag(variances), mission.position_m, mission.covariance_m2)
    try:
        season = _core.merge_missions(maps, {}, progress)
    except ValueError as error:
        raise UserError(f"the maps of the season do not fit together: {error}") from error
    region = Region(origin)
    for row, mission in enumerate(missions):
        x, y, heading = (float(value) for value in season["frames"][row])
        frame = (x, y, heading)
        covariance = season["frame_covariance"][row]
        region.missions.append(
            PlacedMission(
                mission.name,
                int(season["sites"][row]),
                frame,
                math.sqrt(float(np.linalg.eigvalsh([[covariance[0], covariance[1]], [covariance[1], covariance[3]]])[-1])),
                math.hypot(frame[0] - frames[row][0], frame[1] - frames[row][1]),
                _moved(mission.track_m, frame),
            )
        )
    region.contacts = _contacts(season, missions, first_id)
    return region


def _moved(points_m: FloatArray, frame: Sequence[float]) -> FloatArray:
    cosine, sine = math.cos(frame[2]), math.sin(frame[2])
    x, y = points_m.T
    return np.column_stack([frame[0] + cosine * x - sine * y, frame[1] + sine * x + cosine * y])


def _contacts(season: dict[str, Any], missions: Sequence[SeasonMission], first_id: int) -> list[SeasonContact]:
    """What a mission takes for an object, or what two of them saw."""
    contacts: list[SeasonContact] = []
    borders = np.searchsorted(season["sighting_contact"], np.arange(len(season["position"]) + 1))
    for row, (first, last) in enumerate(zip(borders[:-1].tolist(), borders[1:].tolist(), strict=True)):
        seen = list(zip(season["sighting_mission"][first:last].tolist(), season["sighting_landmark"][first:last].tolist(), strict=True))
        if len(seen) == 1 and not missions[seen[0][0]].confirmed[seen[0][1]]:
            continue
        x, y, depth = (float(value) for value in season["position"][row])
        xx, xy, _, yy, _, zz = (float(value) for value in season["covariance"][row])
        contacts.append(
            SeasonContact(
                first_id + len(contacts),
                (x, y, depth),
                (xx, xy, yy),
                math.sqrt(max(zz, 0.0)),
                tuple((missions[mission].name, int(missions[mission].ids[landmark])) for mission, landmark in seen),
                sum(int(missions[mission].times_seen[landmark]) for mission, landmark in seen),
            )
        )
    return contacts
