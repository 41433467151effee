"""From a run directory back to the mission that was run."""

from pathlib import Path

from ssjs_cli.errors import UserError
from ssjs_cli.formats.mission import MISSION_FILE
from ssjs_cli.formats.run_directory import MISSION_LINK_FILE, read_json


def linked_mission(directory: Path, mend: str) -> Path:
    """`mend` is what the user can do where the mission cannot be found."""
    link = directory / MISSION_LINK_FILE
    if not link.is_file():
        raise UserError(f"{link}: is missing, so that the mission of this run is unknown; {mend}")
    mission = (directory.resolve() / str(read_json(link).get("mission", ""))).resolve()
    if not (mission / MISSION_FILE).is_file():
        raise UserError(f"{directory}: its mission is no longer at {mission}; {mend}")
    return mission
