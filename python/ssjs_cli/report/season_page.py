"""The page of a season of missions: a table with what stands out on top, and one map of all contacts."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ssjs_cli.formats.season_contacts import season_rows
from ssjs_cli.report.page_parts import Plot, shown_failures
from ssjs_cli.report.season_map_figure import MAX_ELLIPSES, season_figure
from ssjs_cli.report.sheet import Sheet, SheetColumn, sheet
from ssjs_cli.report.study_page import Section, StudyPage, render_study

if TYPE_CHECKING:
    from ssjs_cli.studies.season_map import Region, SeasonMap

SEASON_SHEET: tuple[SheetColumn, ...] = (
    ("mission", "mission", None, 1.0),
    ("run", "run directory", None, 1.0),
    ("outlier_score", "stands out", 1, 1.0),
    ("stands_out_by", "by", None, 1.0),
    ("warnings", "warnings", 0, 1.0),
    ("lost", "lost", 0, 1.0),
    ("landmarks", "landmarks", 0, 1.0),
    ("submaps", "submaps", 0, 1.0),
    ("loop_closures", "loop closures", 0, 1.0),
    ("nis_mean", "NIS / dof", 3, 1.0),
    ("trajectory_rmse_m", "RMSE [m]", 3, 1.0),
    ("dead_reckoning_rmse_m", "dead reckoning [m]", 2, 1.0),
    ("map_error_mean_m", "map error [m]", 3, 1.0),
    ("nees_mean", "pose NEES", 2, 1.0),
    ("time_total_s", "time [s]", 2, 1.0),
)
CONTACT_SHEET: tuple[SheetColumn, ...] = (
    ("id", "contact", 0, 1.0),
    ("missions", "missions", 0, 1.0),
    ("sightings", "sightings", 0, 1.0),
    ("latitude_deg", "latitude [°]", 6, 1.0),
    ("longitude_deg", "longitude [°]", 6, 1.0),
    ("depth_m", "depth [m]", 1, 1.0),
    ("sigma_major_m", "σ major [m]", 2, 1.0),
    ("sigma_minor_m", "σ minor [m]", 2, 1.0),
    ("seen_by", "seen by", None, 1.0),
)
APART_SHEET: tuple[SheetColumn, ...] = (("mission", "mission", None, 1.0), ("why", "on no map because it", None, 1.0))
NOTE = (
    "Missions that failed come first, then those that stand out: by how many robust standard deviations a mission is worse than the "
    "median of the season, in the logarithm of the column named."
)
#: A page of more would be slow to open and to sort; everything is in the files beside it.
MAX_ROWS = 2000
MAX_SEEN_BY = 6
MAX_MAPS = 6
MAX_SITES = 3
#: A mission that stands out by more is drawn so on the map.
OUTLIER_SCORE = 3.0


def season_page(title: str, rows: Sequence[Mapping[str, Any]], made: "SeasonMap") -> str:
    finished = [row for row in rows if not row["reason"]]
    contacts = made.contacts
    several = sum(len(contact.seen_by) > 1 for contact in contacts)
    page = StudyPage(
        kind="season of missions",
        title=title,
        facts=[
            ("missions", str(len(rows))),
            ("finished", str(len(finished))),
            *([("contacts", str(len(contacts))), ("seen by several missions", str(several))] if contacts else []),
            *([("missions on no map", str(len(made.apart)))] if made.apart and contacts else []),
        ],
        sheets=[_missions(rows), *_contacts(made), *_apart(made)],
        sections=_maps(rows, made),
        failures=shown_failures([(row["path"], row["reason"]) for row in rows if row["reason"]]),
    )
    return render_study(page)


def _missions(rows: Sequence[Mapping[str, Any]]) -> Sheet:
    shown = [{**row, "run": (row["directory"] or "").rpartition("/")[2] or None} for row in rows[:MAX_ROWS]]
    return sheet("season", "Missions", SEASON_SHEET, shown, note=_with_rest(NOTE, len(rows), "missions", "season.csv"))


def _contacts(made: "SeasonMap") -> list[Sheet]:
    """Those that most missions know first."""
    rows = [row for region in made.regions for row in season_rows(region.contacts, region.origin)]
    if not rows:
        return []
    rows.sort(key=lambda row: (-row["missions"], row["id"]))
    for row in rows[:MAX_ROWS]:
        seen = row["seen_by"].split(" ")
        row["seen_by"] = " ".join(seen[:MAX_SEEN_BY]) + (f" and {len(seen) - MAX_SEEN_BY} more" if len(seen) > MAX_SEEN_BY else "")
    note = "Contacts of all missions, one an object: pairs of missions by joint compatibility, with the errors of their frames."
    return [
        sheet("contacts", "Contacts", CONTACT_SHEET, rows[:MAX_ROWS], note=_with_rest(note, len(rows), "contacts", "season_contacts.csv"))
    ]


def _apart(made: "SeasonMap") -> list[Sheet]:
    rows = [{"mission": name, "reason": None, "why": reason} for name, reason in made.apart[:MAX_ROWS]]
    note = _with_rest("", len(made.apart), "missions", "season_map.json")
    return [sheet("apart", "Missions on no map", APART_SHEET, rows, note=note)] if rows else []


def _with_rest(note: str, count: int, what: str, file: str) -> str:
    rest = f"{MAX_ROWS:,} of {count:,} {what} are shown; all are in {file}." if count > MAX_ROWS else ""
    return " ".join(text for text in (note, rest) if text)


def _maps(rows: Sequence[Mapping[str, Any]], made: "SeasonMap") -> list[Section]:
    outliers = {row["directory"].rpartition("/")[2] for row in rows if row["directory"] and (row["outlier_score"] or 0.0) > OUTLIER_SCORE}
    regions = sorted((region for region in made.regions if region.missions), key=lambda region: -len(region.missions))
    plots = []
    for number, region in enumerate(regions[:MAX_MAPS]):
        origin = region.origin
        place = f"{origin.origin_latitude_deg:.5f}°, {origin.origin_longitude_deg:.5f}°"
        notes = [f"{len(region.missions)} missions, {len(region.contacts)} contacts; the origin is at {place}."]
        if len(region.contacts) > MAX_ELLIPSES:
            notes.append(f"Ellipses of {MAX_ELLIPSES} of them.")
        if len(regions) > MAX_MAPS and number == 0:
            notes.append(f"{len(regions) - MAX_MAPS} smaller regions are not drawn.")
        sites = _largest_sites(region)
        if sites:
            notes.append(f"Missions that might overlap are one site; the {len(sites)} with most missions follow.")
        plots.append(Plot("map" if number == 0 else f"map-{number + 1}", f"Region {number + 1}", season_figure(region, outliers), notes))
        for rank, site in enumerate(sites):
            text = f"{len(site.missions)} missions, {len(site.contacts)} contacts."
            heading = f"Region {number + 1}, site {site.missions[0].site + 1}"
            plots.append(Plot(f"map-{number + 1}-site-{rank + 1}", heading, season_figure(site, outliers), [text]))
    return [Section("maps", "Map" if len(plots) == 1 else "Maps", plots)] if plots else []


def _largest_sites(region: "Region") -> list["Region"]:
    """Each as a region of its own, none where there is one site alone."""
    counts = Counter(mission.site for mission in region.missions)
    if len(counts) == 1:
        return []
    site_of = {mission.name: mission.site for mission in region.missions}
    return [
        replace(
            region,
            missions=[mission for mission in region.missions if mission.site == site],
            contacts=[contact for contact in region.contacts if site_of[contact.seen_by[0][0]] == site],
        )
        for site, _ in sorted(counts.items(), key=lambda entry: (-entry[1], entry[0]))[:MAX_SITES]
    ]
