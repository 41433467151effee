"""The first row of cards of a survey's page: what an operator asks for before any number of the filter."""

from typing import Any

import numpy as np

from ssjs_cli.report.contact_cards import number_of
from ssjs_cli.report.coverage_figure import area_text
from ssjs_cli.report.headline import Card
from ssjs_cli.report.number_text import count_text, finite_number, metres_text, percent_text, seconds_text
from ssjs_cli.report.result_files import RunFiles


def survey_cards(files: RunFiles, duration_s: float | None) -> list[Card]:
    """Frames, contacts, area, depth, track: those that the run has. None of them for a vehicle in the plane."""
    if files.trajectory is None or files.trajectory.depth is None:
        return []
    cards = [_frames(files), _contacts(files), _area(files.summary), _depth(files), _track(files, duration_s)]
    return [card for card in cards if card is not None]


def _frames(files: RunFiles) -> Card | None:
    counts = {} if files.pictures is None else files.pictures.frames
    given, used, with_region = (counts.get(key) for key in ("given", "used", "with_region"))
    if given is None or used is None:
        return None
    lines = [f"of {count_text(given)} were used"]
    if with_region is not None and used:
        lines.append(f"{percent_text(with_region / used)} of them with a region of interest")
    return Card("Frames", count_text(used), lines)


def _contacts(files: RunFiles) -> Card | None:
    rows = files.survey.contacts
    if not rows or not files.shows_contacts:
        return None
    seen = np.array([number_of(row, "sightings") or 0.0 for row in rows])
    sigma_m = np.array([number_of(row, "sigma_major_m") or np.nan for row in rows])
    lines = [f"{count_text(int((seen > 1).sum()))} seen more than once"]
    if np.isfinite(sigma_m).any():
        lines.append(f"σ of the position {metres_text(float(np.nanmedian(sigma_m)))} (median)")
    return Card("Contacts", count_text(len(rows)), lines)


def _area(summary: dict[str, Any]) -> Card | None:
    covered, share, twice = (
        finite_number(summary.get(key)) for key in ("coverage_area_m2", "coverage_fraction", "coverage_twice_fraction")
    )
    if covered is None:
        return None
    lines = []
    surveyed = finite_number(summary.get("surveyed_area_m2"))
    if share is not None and surveyed is not None:
        lines.append(f"{percent_text(share)} of the surveyed {area_text(surveyed)}")
    if twice is not None:
        lines.append(f"{percent_text(twice)} twice or more")
    return Card("Seabed covered by the sonar", area_text(covered), lines)


def _depth(files: RunFiles) -> Card | None:
    assert files.trajectory is not None and files.trajectory.depth is not None
    depth = files.trajectory.depth
    lines = []
    if files.survey.altitudes is not None:
        lines.append(f"altitude {metres_text(float(np.median(files.survey.altitudes.altitude_m)))} (median)")
    return Card("Depth of the vehicle", f"{float(depth.min()):.1f} to {float(depth.max()):.1f} m", lines)


def _track(files: RunFiles, duration_s: float | None) -> Card | None:
    assert files.trajectory is not None
    length_m = float(np.linalg.norm(np.diff(files.trajectory.position, axis=0), axis=1).sum())
    text = f"{length_m / 1000.0:.2f} km" if length_m >= 1000.0 else f"{length_m:.0f} m"
    lines = [] if not duration_s else [f"in {seconds_text(duration_s)}, {length_m / duration_s:.2f} m/s"]
    return Card("Track", text, lines)
