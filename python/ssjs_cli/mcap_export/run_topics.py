"""The topics that a run directory fills: poses, uncertainty, map, loop closures, contacts, consistency."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from ssjs_cli.formats.geographic import to_longitude_latitude
from ssjs_cli.formats.mission import Geodetic
from ssjs_cli.formats.number_table import FloatArray
from ssjs_cli.mcap_export import scene, schemas
from ssjs_cli.mcap_export.frames import BASE_LINK, DEAD_RECKONING, MAP, VEHICLE, WORLD, map_R_world, quaternion_of, vehicle_R_base_link
from ssjs_cli.mcap_export.run_files import RunFiles, Track, position_covariance
from ssjs_cli.mcap_export.topics import Stamped, Topic, nanoseconds, stamped, timestamp


def run_topics(run: RunFiles, geodetic: Geodetic | None) -> list[Topic]:
    topics = [
        Topic("/tf_static", schemas.FRAME_TRANSFORMS, _fixed_frames(run, geodetic)),
        Topic("/tf", schemas.FRAME_TRANSFORMS, _moving_frames(run)),
        Topic("/pose/corrected", schemas.POSE_IN_FRAME, _poses(run.corrected)),
        Topic("/pose/online", schemas.POSE_IN_FRAME, _poses(run.online)),
        Topic("/pose/dead_reckoning", schemas.POSE_IN_FRAME, _poses(run.dead_reckoning)),
        Topic("/uncertainty", schemas.UNCERTAINTY, _uncertainty(run)),
        Topic("/uncertainty/ellipsoid", schemas.SCENE_UPDATE, _own_ellipsoid(run)),
        Topic("/nis", schemas.CONSISTENCY, _consistency(run)),
        Topic("/map/tracks", schemas.SCENE_UPDATE, _tracks(run)),
        Topic("/map/landmarks", schemas.SCENE_UPDATE, _landmarks(run)),
        Topic("/loops", schemas.LOG, _loop_events(run)),
        Topic("/map/loops", schemas.SCENE_UPDATE, _loop_lines(run)),
    ]
    if run.contacts:
        topics.append(Topic("/contacts", schemas.CONTACT, _contacts(run)))
    if geodetic is not None:
        topics.append(Topic("/position", schemas.LOCATION_FIX, _fixes(run, geodetic)))
    return topics


def _transform(time_ns: int, parent: str, child: str, position_m: list[float], orientation: list[float]) -> dict[str, Any]:
    return {
        "timestamp": timestamp(time_ns),
        "parent_frame_id": parent,
        "child_frame_id": child,
        "translation": scene.vector(position_m),
        "rotation": scene.quaternion(orientation),
    }


def _fixed_frames(run: RunFiles, geodetic: Geodetic | None) -> Iterator[Stamped]:
    time_ns = nanoseconds(float(run.corrected.time_s[0]))
    world = quaternion_of(map_R_world(geodetic, under_water=run.under_water))
    base_link = quaternion_of(vehicle_R_base_link(under_water=run.under_water))
    still = [0.0, 0.0, 0.0]
    turned = [_transform(time_ns, MAP, WORLD, still, list(world)), _transform(time_ns, VEHICLE, BASE_LINK, still, list(base_link))]
    yield time_ns, {"transforms": turned}


def _moving_frames(run: RunFiles) -> Iterator[Stamped]:
    """Dead reckoning has the same times as the corrected track."""
    for time_s, *rows in zip(run.corrected.time_s.tolist(), *_rows(run.corrected), *_rows(run.dead_reckoning), strict=True):
        time_ns = nanoseconds(time_s)
        yield (
            time_ns,
            {"transforms": [_transform(time_ns, WORLD, VEHICLE, *rows[:2]), _transform(time_ns, WORLD, DEAD_RECKONING, *rows[2:])]},
        )


def _rows(track: Track) -> tuple[list[list[float]], list[list[float]]]:
    return track.position_m.tolist(), track.orientation.tolist()


def _poses(track: Track) -> Iterator[Stamped]:
    for time_s, position_m, orientation in zip(track.time_s.tolist(), *_rows(track), strict=True):
        yield stamped(time_s, frame_id=WORLD, pose=scene.pose(position_m, orientation))


def _uncertainty(run: RunFiles) -> Iterator[Stamped]:
    variances = np.maximum(np.diagonal(run.covariance_m2, axis1=1, axis2=2), 0.0)
    minor, major = np.linalg.eigvalsh(run.covariance_m2[:, :2, :2]).T
    columns = np.sqrt(np.maximum(np.column_stack([variances, major, minor, run.heading_variance]), 0.0))
    names = tuple(name for name in schemas.UNCERTAINTY["properties"] if name != "timestamp")
    for time_s, sigmas in zip(run.corrected.time_s.tolist(), columns.tolist(), strict=True):
        yield stamped(time_s, **dict(zip(names, sigmas, strict=True)))


def _own_ellipsoid(run: RunFiles) -> Iterator[Stamped]:
    for time_s, position_m, covariance_m2 in zip(
        run.corrected.time_s.tolist(), run.corrected.position_m.tolist(), run.covariance_m2, strict=True
    ):
        time_ns = nanoseconds(time_s)
        sphere = scene.ellipsoid(position_m, covariance_m2, scene.OWN_ELLIPSOID)
        yield time_ns, scene.update(scene.entity("vehicle", timestamp(time_ns), spheres=[sphere]))


def _consistency(run: RunFiles) -> Iterator[Stamped]:
    for time_s, nis, dof in run.nis.stacked(("time_s", "nis", "dof")).tolist():
        yield stamped(time_s, nis=nis, dof=int(dof), nis_per_dof=nis / dof if dof > 0 else 0.0)


def _tracks(run: RunFiles) -> Iterator[Stamped]:
    """The whole tracks from the start, so that a viewer shows them wherever it is put."""
    time_ns = nanoseconds(float(run.corrected.time_s[0]))
    corrected = scene.line(run.corrected.position_m, schemas.LINE_STRIP, scene.CORRECTED)
    reckoned = scene.line(run.dead_reckoning.position_m, schemas.LINE_STRIP, scene.RECKONED)
    yield (
        time_ns,
        scene.update(
            scene.entity("corrected", timestamp(time_ns), lines=[corrected]),
            scene.entity("dead reckoning", timestamp(time_ns), lines=[reckoned]),
        ),
    )


def _landmarks(run: RunFiles) -> Iterator[Stamped]:
    """The map at the end of the mission, one entity a landmark, from the start."""
    if not run.landmarks.rows:
        return
    time_ns = nanoseconds(float(run.corrected.time_s[0]))
    names = {row["id"]: str(row["name"]) for row in run.contacts if "name" in row and "id" in row}
    entities = []
    for number, position_m, covariance_m2 in zip(
        run.landmarks["id"].tolist(), run.landmarks.stacked(("x_m", "y_m", "z_m")).tolist(), position_covariance(run.landmarks), strict=True
    ):
        sphere = scene.ellipsoid(position_m, covariance_m2, scene.LANDMARK)
        text = scene.label(position_m, names.get(int(number), f"{number:.0f}"))
        entities.append(scene.entity(f"{number:.0f}", timestamp(time_ns), spheres=[sphere], texts=[text]))
    yield time_ns, scene.update(*entities)


def _loops_in_order(run: RunFiles) -> list[dict[str, Any]]:
    return sorted(run.loops, key=lambda loop: float(loop["time_s"]))


def _loop_events(run: RunFiles) -> Iterator[Stamped]:
    for loop in _loops_in_order(run):
        accepted = bool(loop["accepted"])
        decision = "closed" if accepted else f"refused ({loop['reason']})"
        text = f"submap {loop['from']} to {loop['to']}: {decision}, {loop['pairs']} pairs"
        level = schemas.LOG_LEVELS["INFO" if accepted else "WARNING"]
        yield stamped(float(loop["time_s"]), level=level, message=text, name="loop closure", file="", line=0)


def _loop_lines(run: RunFiles) -> Iterator[Stamped]:
    """Each message holds all lines up to its time, for a viewer that is put somewhere shows the last message alone."""
    depth_m = float(np.median(run.corrected.position_m[:, 2]))  # bases lie at z = 0, the surface: drawn at the track
    base_m = {index: [*place, depth_m] for index, place in run.base_m.items()}
    ends: list[list[float]] = []
    for loop in _loops_in_order(run):
        if not loop["accepted"] or loop["from"] not in base_m or loop["to"] not in base_m:
            continue
        ends += [base_m[loop["from"]], base_m[loop["to"]]]
        time_ns = nanoseconds(float(loop["time_s"]))
        lines = [scene.line(np.array(ends), schemas.LINE_LIST, scene.LOOP)]
        yield time_ns, scene.update(scene.entity("loops", timestamp(time_ns), lines=lines))


def _contacts(run: RunFiles) -> Iterator[Stamped]:
    """At the time of the sighting that contacts.csv names; without one at the start."""
    start_s = float(run.corrected.time_s[0])
    for time_s, row in sorted(((float(row.get("time_s", start_s)), row) for row in run.contacts), key=lambda entry: entry[0]):
        yield stamped(time_s, **row)


def _fixes(run: RunFiles, geodetic: Geodetic) -> Iterator[Stamped]:
    """Height over the sea is minus the depth; the covariance is turned to east, north, up."""
    track = run.corrected
    R = map_R_world(geodetic, under_water=run.under_water)
    covariance_m2: FloatArray = R @ run.covariance_m2 @ R.T
    height_m = -track.position_m[:, 2] if geodetic.y_axis == "right" else track.position_m[:, 2]
    places = np.column_stack([to_longitude_latitude(track.position_m[:, :2], geodetic), height_m + 0.0])
    for time_s, (longitude, latitude, altitude), covariance in zip(
        track.time_s.tolist(), places.tolist(), covariance_m2.reshape(-1, 9).tolist(), strict=True
    ):
        yield stamped(
            time_s,
            frame_id=VEHICLE,
            latitude=latitude,
            longitude=longitude,
            altitude=altitude,
            position_covariance=covariance,
            position_covariance_type=schemas.COVARIANCE_KNOWN,
        )
