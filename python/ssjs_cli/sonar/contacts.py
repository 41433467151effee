"""The contacts of side-scan logs: found with the vehicle's own frame, placed by what the estimator made of its track."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli import _core
from ssjs_cli.errors import UserError
from ssjs_cli.formats.contact_table import Contact
from ssjs_cli.formats.mission import BodyPoints
from ssjs_cli.formats.number_table import FloatArray
from ssjs_cli.formats.run_directory import Estimate
from ssjs_cli.sonar.info import describe_problem
from ssjs_cli.sonar.log_blocks import PINGS_PER_BLOCK, open_log

# A sighting that lies farther from every landmark on the map was not used for it.
MATCH_DISTANCE_M = 5.0


@dataclass(frozen=True)
class Sighting:
    """One contact in one pass: `found` as the survey measured it, in the log of this name."""

    log: str
    found: Mapping[str, Any]


def contacts_in(log: _core.SonarLog, config: Mapping[str, float | int | bool | str | None]) -> Iterator[dict[str, Any]]:
    """As the survey measured them, to the end of the log."""
    survey = _core.SideScanSurvey(config)
    while (contacts := survey.feed_log(log, most_pings=PINGS_PER_BLOCK)) is not None:
        yield from contacts
    yield from survey.finish()


def sightings_in(logs: Sequence[Path], config: Mapping[str, float | int | bool | str | None], lost: list[str]) -> list[Sighting]:
    """In the order of time; `lost` is told of the data that could not be read."""
    found = []
    for path in logs:
        log = open_log(path)
        try:
            found += [Sighting(path.name, contact) for contact in contacts_in(log, config)]
        except (ValueError, RuntimeError, MemoryError) as error:  # settings that each keep their rule and do not go together
            raise UserError(f"{path}: no contacts can be found with these settings sonar.*: {error}") from error
        lost += [f"{path}: {describe_problem(problem)}" for problem in log.info()["problems"] if problem["data_lost"]]
    return sorted(found, key=lambda sighting: float(sighting.found["time_s"]))


def body_points(sightings: Sequence[Sighting]) -> BodyPoints | None:
    if not sightings:
        return None
    covariance = np.array([sighting.found["body_covariance_m2"] for sighting in sightings]).reshape(-1, 9)
    return BodyPoints(
        np.array([float(sighting.found["time_s"]) for sighting in sightings]),
        np.array([sighting.found["body_position_m"] for sighting in sightings], dtype=np.float64),
        covariance_m2=covariance[:, [0, 1, 2, 4, 5, 8]],
    )


def contacts_on_map(estimate: Estimate, sightings: Sequence[Sighting]) -> list[Contact]:
    """One contact a confirmed landmark. What the sonar measured of it is that of its most trusted sighting."""
    landmarks = estimate.landmarks
    best = _best_sightings(estimate, sightings)
    contacts = []
    passes = landmarks.passes
    for index, (x, y) in enumerate(landmarks.position):
        if passes is not None and not passes.confirmed[index]:
            continue
        xx, xy, yy = (float(value) for value in landmarks.covariance[index])
        depth = None if landmarks.depth_m is None else float(landmarks.depth_m[index])
        seen = int(landmarks.times_seen[index])
        sonar = sonar_part(best[index]) if index in best else {}
        if passes is not None:
            sonar |= {
                "passes_seen": int(passes.seen[index]),
                "passes_expected": int(passes.expected[index]),
                "existence": float(passes.existence[index]),
            }
        contacts.append(Contact(int(landmarks.ids[index]), float(x), float(y), (xx, xy, yy), seen, depth_m=depth, **sonar))
    return contacts


def _best_sightings(estimate: Estimate, sightings: Sequence[Sighting]) -> dict[int, Sighting]:
    """By the landmark nearest to where the final track puts each sighting."""
    best: dict[int, Sighting] = {}
    positions = estimate.landmarks.position
    if not len(positions):
        return best
    for sighting in sightings:
        distance_m = np.linalg.norm(positions - _on_map(estimate, sighting), axis=1)
        nearest = int(np.argmin(distance_m))
        known = best.get(nearest)
        if distance_m[nearest] <= MATCH_DISTANCE_M and (known is None or sighting.found["confidence"] > known.found["confidence"]):
            best[nearest] = sighting
    return best


def _on_map(estimate: Estimate, sighting: Sighting) -> FloatArray:
    """x, y: the vehicle taken level, which moves a point by less than its own noise."""
    track, time_s = estimate.final, float(sighting.found["time_s"])
    x, y = (np.interp(time_s, track.time_s, track.pose[:, axis]) for axis in (0, 1))
    heading = np.interp(time_s, track.time_s, np.unwrap(track.pose[:, 2]))
    forward, starboard, _ = sighting.found["body_position_m"]
    cosine, sine = np.cos(heading), np.sin(heading)
    return np.array([x + cosine * forward - sine * starboard, y + sine * forward + cosine * starboard])


def sonar_part(sighting: Sighting) -> dict[str, Any]:
    """What a Contact holds of its sighting."""
    found = sighting.found
    navigation = found["navigation"]
    return {
        "time_s": known(found["time_s"]),
        "log": sighting.log,
        "ping": int(found["ping"]),
        "channel": found["side"],
        "slant_range_m": found["slant_range_m"],
        "ground_range_m": found["ground_range_m"],
        "altitude_m": known(navigation["altitude_m"]),
        "sonar_heading_deg": known(np.degrees(navigation["heading_rad"]) % 360.0),
        "sonar_depth_m": known(navigation["depth_m"]),
        "length_m": found["length_m"],
        "width_m": found["width_m"],
        "height_m": found["height_m"],
        "confidence": found["confidence"],
        "remark": "shadow cut off: height is a lower bound" if found["shadow_is_cut"] else "",
    }


def known(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
