"""The command `sonar detect`: a log's contacts as operators exchange them, by the navigation in the log itself."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli.errors import UserError
from ssjs_cli.formats.atomic import check_writable, write_file
from ssjs_cli.formats.attitude import rotation
from ssjs_cli.formats.contact_table import Contact, contact_rows, contacts_csv
from ssjs_cli.formats.geographic import from_longitude_latitude
from ssjs_cli.formats.mission import Geodetic
from ssjs_cli.session import Session
from ssjs_cli.sonar.contacts import Sighting, contacts_in, known, sonar_part
from ssjs_cli.sonar.detector import MODEL_KEY, detector_model
from ssjs_cli.sonar.info import describe_problem, exit_code
from ssjs_cli.sonar.log_blocks import open_log


def detect_contacts(
    path: Path,
    out: Path | None,
    session: Session,
    *,
    config: Mapping[str, float | int | bool | str | None],
    layback: str,
    force: bool,
    model: Path | None = None,
) -> int:
    """`model`: of the detector that needs one."""
    used = detector_model({**config, MODEL_KEY: None if model is None else str(model)}, "--")
    target = out or Path("runs") / f"{path.stem}-contacts.csv"
    check_writable(target, [path], force=force)
    log = open_log(path, layback)
    found = list(contacts_in(log, config, None if used is None else used.cascade))
    info = log.info()
    if not info["pings"]:
        raise UserError(f"{path}: holds no side-scan ping; check that it is the right file")
    placed = [entry for entry in found if _has_position(entry["navigation"])]
    geodetic = _origin(placed)
    contacts = [_contact(number, entry, geodetic, path.name) for number, entry in enumerate(placed, start=1)]
    target.parent.mkdir(parents=True, exist_ok=True)
    write_file(target, contacts_csv(contacts, geodetic))
    document = {
        "table": str(target),
        "pings": info["pings"],
        "contacts": contact_rows(contacts, geodetic),
        "without_position": len(found) - len(placed),
        "problems": info["problems"],
    }
    for problem in info["problems"]:
        session.message(describe_problem(problem))
    if len(placed) < len(found):
        session.message(f"{len(found) - len(placed)} contacts lie at pings without position or heading and are left out")
    session.answer(document, _text(path, target, info["pings"], contacts))
    return exit_code(info["problems"])


def _has_position(navigation: Mapping[str, float]) -> bool:
    geographic = math.isfinite(navigation["latitude_deg"]) and math.isfinite(navigation["longitude_deg"])
    projected = math.isfinite(navigation["east_m"]) and math.isfinite(navigation["north_m"])
    return (geographic or projected) and math.isfinite(navigation["heading_rad"])


def _origin(entries: list[dict[str, Any]]) -> Geodetic | None:
    """Where the first contact was seen from; none for logs in projected metres."""
    if not entries or not math.isfinite(entries[0]["navigation"]["latitude_deg"]):
        return None
    first = entries[0]["navigation"]
    return Geodetic(origin_latitude_deg=first["latitude_deg"], origin_longitude_deg=first["longitude_deg"])


def _contact(number: int, entry: dict[str, Any], geodetic: Geodetic | None, log: str) -> Contact:
    """x is east and y north. The covariance is that of the sighting, without that of the navigation."""
    navigation = entry["navigation"]
    if geodetic is None:
        east, north = navigation["east_m"], navigation["north_m"]
    else:
        east, north = from_longitude_latitude(np.array([[navigation["longitude_deg"], navigation["latitude_deg"]]]), geodetic)[0]
    # unknown roll and pitch are none
    turn = rotation(*(known(navigation[key]) or 0.0 for key in ("roll_rad", "pitch_rad", "heading_rad")))
    offset = turn @ np.array(entry["body_position_m"])  # north, east, down
    covariance = turn @ entry["body_covariance_m2"] @ turn.T
    depth_m = navigation["depth_m"]
    return Contact(
        id=number,
        x_m=float(east + offset[1]),
        y_m=float(north + offset[0]),
        covariance_m2=(float(covariance[1, 1]), float(covariance[0, 1]), float(covariance[0, 0])),
        sightings=1,
        depth_m=float(depth_m + offset[2]) if math.isfinite(depth_m) else None,
        **sonar_part(Sighting(log, entry)),
    )


def _text(path: Path, target: Path, pings: int, contacts: list[Contact]) -> str:
    lines = [f"{path}: {pings} pings, {len(contacts)} contacts"]
    for contact in contacts:
        height = "" if contact.height_m is None else f" x {contact.height_m:.1f}"
        size = f"{contact.length_m:.1f} x {contact.width_m:.1f}{height} m"
        place = f"ping {contact.ping}, {contact.channel} {contact.ground_range_m:.1f} m"
        lines.append(f"  {contact.id:4}  {place}: {size}, confidence {contact.confidence:.2f}")
    return "\n".join([*lines, f"table  {target}"])
