"""A new mission directory and what is said about it."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ssjs_cli.exit_codes import DONE, PARTLY_DONE
from ssjs_cli.formats.atomic import new_directory
from ssjs_cli.formats.mission import Mission, why_not_a_mission, write_mission
from ssjs_cli.progress import working
from ssjs_cli.session import Session


def write_new_mission(directory: Path, make: Callable[[], Mission], *, force: bool, session: Session) -> Mission:
    """The output is refused before the work of `make` begins."""
    session.fault_log = directory.with_name(directory.name + ".fault.jsonl")
    kind = "mission directory"
    with new_directory(directory, force=force, why_not_ours=why_not_a_mission, kind=kind) as partial, working("making the mission"):
        mission = make()
        write_mission(partial, mission)
    return mission


def answer_mission(directory: Path, mission: Mission, session: Session) -> int:
    """Prints what the mission holds; exit code 3 when part of the source was lost."""
    reference = mission.reference
    time_s = mission.time_s
    velocity = None if mission.navigation is None else mission.navigation.velocity
    document: dict[str, Any] = {
        "mission_directory": str(directory),
        "name": mission.name,
        "odometry_kind": None if mission.odometry is None else mission.odometry.kind,
        "odometry_records": 0 if mission.odometry is None else len(mission.odometry.values),
        "observations": 0 if mission.observations is None else len(mission.observations.time_s),
        "scans": 0 if mission.scans is None else len(mission.scans.time_s),
        "sonar_hits": 0 if mission.sonar_hits is None else len(mission.sonar_hits.time_s),
        "frames": 0 if mission.frames is None else len(mission.frames.files),
        "attitudes": 0 if mission.navigation is None else len(mission.navigation.attitude.time_s),
        "bottom_velocities": 0 if velocity is None else len(velocity.time_s),
        "duration_s": round(float(time_s[-1] - time_s[0]), 6),
        "reference_poses": 0 if reference.truth is None else len(reference.truth.time_s),
        "reference_fixes": 0 if reference.fixes is None else len(reference.fixes.time_s),
        "reference_landmarks": 0 if reference.landmarks is None else len(reference.landmarks.ids),
        "counts": {} if mission.import_record is None else mission.import_record.counts,
        "lost": [] if mission.import_record is None else mission.import_record.lost,
    }
    for text in document["lost"]:
        session.message(f"lost: {text}")
    lines = [f"{directory}: mission '{mission.name}', {document['duration_s']:g} s, {document['odometry_records']} odometry records"]
    parts = (
        "observations",
        "scans",
        "sonar_hits",
        "frames",
        "attitudes",
        "bottom_velocities",
        "reference_poses",
        "reference_fixes",
        "reference_landmarks",
    )
    lines += [f"  {document[part]} {part.replace('_', ' ')}" for part in parts if document[part]]
    session.answer(document, "\n".join(lines))
    return PARTLY_DONE if document["lost"] else DONE
