"""What the run of an underwater mission leaves beside its estimate: altitudes; of a sonar survey contacts, pictures and coverage."""

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli.contact_files import write_contacts
from ssjs_cli.formats.mission import Mission
from ssjs_cli.formats.number_table import EXACT, FloatArray, write_table
from ssjs_cli.formats.run_directory import ALTITUDE_FILE, COVERAGE_FILE, SIGHTINGS_FILE, Estimate
from ssjs_cli.sonar.contacts import Sighting, best_sightings, contacts_on_map, nearest_landmarks
from ssjs_cli.sonar.coverage import coverage, write_coverage
from ssjs_cli.sonar.survey_pictures import write_contact_pictures, write_waterfall
from ssjs_cli.sonar.survey_record import SurveyRecord

ALTITUDE_INTERVAL_S = 1.0
SIGHTING_COLUMNS = ("time_s", "log", "ping", "channel", "ground_range_m", "length_m", "width_m", "confidence", "contact")


def write_survey(
    directory: Path, mission: Mission, estimate: Estimate, sightings: Sequence[Sighting], record: SurveyRecord
) -> dict[str, Any]:
    """The answer: what summary.json says of it."""
    contacts = contacts_on_map(estimate, sightings)
    write_contacts(directory, mission.name, estimate.final.pose[:, :2], contacts, mission.geodetic)
    altitudes = _altitudes(mission, record)
    if altitudes is not None:
        write_table(directory / ALTITUDE_FILE, "time_s,altitude_m", list(altitudes), [EXACT, "%.3f"])
    if not record.pings:
        return {}
    best = best_sightings(estimate, sightings)
    numbers = {int(estimate.landmarks.ids[row]): sighting for row, sighting in best.items()}
    write_contact_pictures(directory, estimate.final, numbers, record)
    write_waterfall(directory, record)
    (directory / SIGHTINGS_FILE).write_text(_sightings_csv(estimate, sightings), encoding="utf-8")
    summary: dict[str, Any] = {"pings": record.pings, "sightings": len(sightings)}
    covered = coverage(estimate.final, record.reach())
    if covered is not None:
        write_coverage(directory / COVERAGE_FILE, covered)
        summary.update(covered.numbers())
    return summary


def _altitudes(mission: Mission, record: SurveyRecord) -> tuple[FloatArray, FloatArray] | None:
    """Of the vehicle's own altimeter; of the sonar, from its log or its bottom tracking, without one. At most one a second."""
    measured = None if mission.navigation is None else mission.navigation.altitude
    reach = record.reach()
    time_s, altitude_m = (reach.time_s, reach.altitude_m) if measured is None else (measured.time_s, measured.value)
    known = np.isfinite(altitude_m) & (altitude_m > 0.0)
    time_s, altitude_m = time_s[known], altitude_m[known]
    if not len(time_s):
        return None
    tick = np.floor(time_s / ALTITUDE_INTERVAL_S)
    first = np.concatenate(([True], tick[1:] != tick[:-1]))
    return time_s[first], altitude_m[first]


def _sightings_csv(estimate: Estimate, sightings: Sequence[Sighting]) -> str:
    """Everything that was detected, with the contact that it is a sighting of; none where the final track puts it near no landmark."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(SIGHTING_COLUMNS)
    for sighting, row in zip(sightings, nearest_landmarks(estimate, sightings), strict=True):
        found = sighting.found
        sizes = [f"{float(found[key]):.3f}" for key in ("ground_range_m", "length_m", "width_m")]
        contact = "" if row is None else int(estimate.landmarks.ids[row])
        head = [repr(float(found["time_s"])), sighting.log, int(found["ping"]), found["side"]]
        writer.writerow([*head, *sizes, f"{float(found['confidence']):.4f}", contact])
    return text.getvalue()
