"""The commands `import xtf` and `import jsf`."""

from pathlib import Path
from typing import Any

from ssjs_cli.exit_codes import DONE, PARTLY_DONE
from ssjs_cli.formats.atomic import new_directory
from ssjs_cli.formats.mission import why_not_a_mission
from ssjs_cli.formats.sonar_mission import read_sonar_mission, write_sonar_mission
from ssjs_cli.progress import working
from ssjs_cli.session import Session


def import_sonar_log(source: Path, kind: str, directory: Path, session: Session, *, force: bool) -> int:
    """Exit code 3 when part of the log was lost."""
    session.fault_log = directory.with_name(directory.name + ".fault.jsonl")
    with (
        new_directory(directory, force=force, why_not_ours=why_not_a_mission, kind="mission directory") as partial,
        working("making the mission"),
    ):
        mission = read_sonar_mission(source, kind)
        write_sonar_mission(partial, mission)
    record = mission.import_record
    duration_s = float(mission.pings["time_s"][-1] - mission.pings["time_s"][0]) if len(mission.pings["time_s"]) else 0.0
    navigation = mission.navigation
    document: dict[str, Any] = {
        "mission_directory": str(directory),
        "name": mission.name,
        "pings": record.counts.get("pings", 0),
        "duration_s": round(duration_s, 6),
        "origin_deg": None if mission.origin is None else [mission.origin.origin_latitude_deg, mission.origin.origin_longitude_deg],
        "imu_records": len(navigation.attitude.time_s),
        "dvl_records": 0 if navigation.velocity is None else len(navigation.velocity.time_s),
        "depth_records": 0 if navigation.depth is None else len(navigation.depth.time_s),
        "altitude_records": 0 if navigation.altitude is None else len(navigation.altitude.time_s),
        "counts": record.counts,
        "lost": record.lost,
    }
    for text in record.lost:
        session.message(text if text.startswith("lost: ") else f"lost: {text}")
    lines = [f"{directory}: mission '{mission.name}', {document['pings']} pings, {document['duration_s']:g} s"]
    for part in ("imu_records", "dvl_records", "depth_records", "altitude_records"):
        lines.append(f"  {document[part]} {part.replace('_', ' ')}")
    session.answer(document, "\n".join(lines))
    return PARTLY_DONE if record.lost else DONE
