"""The contacts of side-scan logs: found with the vehicle's own frame, placed by what the estimator made of its track."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli import _core
from ssjs_cli.errors import UserError
from ssjs_cli.formats.contact_table import Contact, error_ellipse
from ssjs_cli.formats.mission import BodyPoints
from ssjs_cli.formats.number_table import FloatArray
from ssjs_cli.formats.run_directory import SNIPPETS_FOLDER, Estimate
from ssjs_cli.sonar.info import describe_problem
from ssjs_cli.sonar.log_blocks import PINGS_PER_BLOCK, open_log
from ssjs_cli.sonar.survey_record import PINGS_AROUND, SurveyRecord

# A sighting that lies farther from every landmark on the map was not used for it.
MATCH_DISTANCE_M = 5.0
MATCH_SIGMAS = 3.0


@dataclass(frozen=True)
class Sighting:
    """One contact in one pass: `found` as the survey measured it, in the log of this name; picture: its number in the SurveyRecord."""

    log: str
    found: Mapping[str, Any]
    picture: int | None = None


def contacts_in(
    log: _core.SonarLog, config: Mapping[str, float | int | bool | str | None], cascade: _core.HaarCascade | None = None
) -> Iterator[dict[str, Any]]:
    """As the survey measured them, to the end of the log. `cascade`: the model of that detector."""
    survey = _core.SideScanSurvey(config, cascade)
    while (contacts := survey.feed_log(log, most_pings=PINGS_PER_BLOCK)) is not None:
        yield from contacts
    yield from survey.finish()


def recorded_contacts(
    log: _core.SonarLog,
    name: str,
    config: Mapping[str, float | int | bool | str | None],
    record: SurveyRecord,
    cascade: _core.HaarCascade | None = None,
) -> Iterator[Sighting]:
    """The same, their pictures put aside in the record."""
    survey = _core.SideScanSurvey(config, cascade, pings_around=PINGS_AROUND)
    at_end = False
    while not at_end:
        contacts = survey.feed_log(log, most_pings=PINGS_PER_BLOCK)
        at_end = contacts is None
        contacts = survey.finish() if contacts is None else contacts
        record.add_blocks(name, survey.take_blocks(), contacts)
        for contact in contacts:
            yield Sighting(name, contact, record.keep(contact.pop("picture")))


def sightings_in(
    logs: Sequence[Path],
    config: Mapping[str, float | int | bool | str | None],
    lost: list[str],
    cascade: _core.HaarCascade | None = None,
    record: SurveyRecord | None = None,
) -> list[Sighting]:
    """In the order of time; `lost` is told of the data that could not be read, the record of what the pings look like."""
    found: list[Sighting] = []
    for path in logs:
        log = open_log(path)
        try:
            if record is None:
                found += [Sighting(path.name, contact) for contact in contacts_in(log, config, cascade)]
            else:
                found += recorded_contacts(log, path.name, config, record, cascade)
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
    """One contact a confirmed landmark. What the sonar measured of it is that of its most trusted sighting. Its number is the landmark's;
    of two that the source calls by one name, known twice and not found to be one, the second gets a new number."""
    landmarks = estimate.landmarks
    taken: set[int] = set()
    best = best_sightings(estimate, sightings)
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
        number = int(landmarks.ids[index])
        if number in taken:
            number = max(int(landmarks.ids.max()), *taken) + 1
        taken.add(number)
        if index in best and best[index].picture is not None:
            sonar["snippet"] = f"{SNIPPETS_FOLDER}/{snippet_name(number)}"
        contacts.append(Contact(number, float(x), float(y), (xx, xy, yy), seen, depth_m=depth, **sonar))
    return contacts


def snippet_name(number: int) -> str:
    return f"contact-{number:04d}.png"


def best_sightings(estimate: Estimate, sightings: Sequence[Sighting]) -> dict[int, Sighting]:
    """The most trusted sighting of each landmark, by its row, among those that the final track puts nearest to it."""
    best: dict[int, Sighting] = {}
    for sighting, row in zip(sightings, nearest_landmarks(estimate, sightings), strict=True):
        if row is not None and (row not in best or sighting.found["confidence"] > best[row].found["confidence"]):
            best[row] = sighting
    return best


def nearest_landmarks(estimate: Estimate, sightings: Sequence[Sighting]) -> list[int | None]:
    """For each sighting the row of the landmark nearest to where the final track puts it; None beyond MATCH_DISTANCE_M, or beyond three
    sigma of a landmark that is known worse than that."""
    positions = estimate.landmarks.position
    if not len(positions):
        return [None] * len(sightings)
    sigma_m = [error_ellipse(covariance)[0] for covariance in estimate.landmarks.covariance]
    limit_m = np.maximum(MATCH_DISTANCE_M, MATCH_SIGMAS * np.array(sigma_m))
    rows: list[int | None] = []
    for sighting in sightings:
        distance_m = np.linalg.norm(positions - _on_map(estimate, sighting), axis=1)
        nearest = int(np.argmin(distance_m))
        rows.append(nearest if distance_m[nearest] <= limit_m[nearest] else None)
    return rows


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
