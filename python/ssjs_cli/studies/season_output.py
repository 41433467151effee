"""What a season ends with beside its tables: the merged contacts, the map, the page. Made anew only when a run, or a row, is another."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ssjs_cli.errors import UserError
from ssjs_cli.formats.run_directory import json_text, read_json
from ssjs_cli.formats.season_contacts import season_contacts_csv, season_geojson
from ssjs_cli.progress import interruptible
from ssjs_cli.studies.season_map import Region, SeasonMap, season_map
from ssjs_cli.studies.single_run import core_identity
from ssjs_cli.studies.study_folder import StudyFolder, key_of

REPORT_FILE = "report.html"
MAP_FILE = "season_map.json"
CONTACTS_CSV_FILE = "season_contacts.csv"
CONTACTS_GEOJSON_FILE = "season_contacts.geojson"


def write_season(out: Path, rows: Sequence[Mapping[str, Any]], folder: StudyFolder) -> None:
    """rows: of the season, those of finished missions with their run directory."""
    key = key_of({**core_identity(), "rows": list(rows)})
    files = (REPORT_FILE, CONTACTS_CSV_FILE, CONTACTS_GEOJSON_FILE)
    if _key_in(out / MAP_FILE) == key and all((out / name).is_file() for name in files):
        return
    directories = sorted(out / row["directory"] for row in rows if row["directory"])
    with interruptible("joining the missions") as progress:
        made = season_map(directories, progress)
    folder.write(CONTACTS_CSV_FILE, season_contacts_csv(made.regions))
    folder.write(CONTACTS_GEOJSON_FILE, season_geojson(made.regions))
    from ssjs_cli.report.season_page import season_page

    folder.write(REPORT_FILE, season_page(out.name, rows, made))
    folder.write(MAP_FILE, json_text({"key": key, **_document(made)}))  # last: with it all is there


def _key_in(path: Path) -> str | None:
    try:
        return str(read_json(path).get("key"))
    except (UserError, OSError):
        return None


def _document(made: SeasonMap) -> dict[str, Any]:
    return {
        "regions": [_region(region) for region in made.regions],
        "apart": [{"mission": name, "reason": reason} for name, reason in made.apart],
    }


def _region(region: Region) -> dict[str, Any]:
    return {
        "origin": region.origin.model_dump(exclude_none=True),
        "contacts": len(region.contacts),
        "seen_by_several": sum(len(contact.seen_by) > 1 for contact in region.contacts),
        "missions": [
            {
                "mission": mission.name,
                "site": mission.site,
                "north_m": round(mission.frame[0], 4),
                "east_m": round(mission.frame[1], 4),
                "heading_rad": round(mission.frame[2], 7),
                "sigma_m": round(mission.sigma_m, 4),
                "moved_m": round(mission.moved_m, 4),
            }
            for mission in region.missions
        ],
    }
