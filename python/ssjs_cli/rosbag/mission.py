"""A recording of ROS as the mission of an underwater vehicle: attitude, velocity over the bottom, depth, altitude, and fixes to compare
with. Only what the sensors say is taken; a pose that the vehicle computed itself is not."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ssjs_cli.errors import UserError
from ssjs_cli.formats.file_digest import file_digest
from ssjs_cli.formats.geographic import from_longitude_latitude
from ssjs_cli.formats.mission import Fixes, Geodetic, ImportRecord, Mission, Reference, ReferenceDescription
from ssjs_cli.formats.navigation import Attitude, BoolArray, BottomVelocity, Scalars, UnderwaterNavigation
from ssjs_cli.formats.number_table import FloatArray
from ssjs_cli.rosbag.bag import Bag
from ssjs_cli.rosbag.marine_frames import marine_attitude, marine_vectors
from ssjs_cli.rosbag.roles import ALTITUDE, DEPTH, FIX, IMU, VELOCITY, choose_topics, parse_topics
from ssjs_cli.rosbag.series import Series, read_series, unused_topics

STANDARD_GRAVITY_M_S2 = 9.80665
MAX_FIX_GAP_S = 2.0


@dataclass(frozen=True)
class BagOptions:
    """topics: as given on the command line. is_marine: axes are north-east-down and forward-starboard-down already, not those of ROS."""

    topics: Sequence[str] = ()
    is_marine: bool = False
    surface_pressure_pa: float = 101_325.0
    water_density_kg_m3: float = 1025.0


def read_rosbag(source: Path, options: BagOptions) -> Mission:
    chosen = parse_topics(options.topics)
    bag = Bag(source)
    try:
        roles = choose_topics(bag.topics(), chosen)
    except UserError as error:
        raise UserError(f"{source}: {error}") from error
    series = read_series(bag, roles)
    counts: dict[str, int] = {}
    lost = list(bag.lost)
    tables = {}
    for role, entry in series.items():
        table = _table(role, roles[role], entry, counts, lost)
        if table is not None:
            tables[role] = table
    if IMU not in tables:
        raise UserError(f"{source}: {roles[IMU]} holds no attitude that can be used; name another topic with --topic imu=TOPIC")
    unused = unused_topics(bag, roles)
    counts.update({f"not used: {name}": count for name, count in sorted(unused.items())})
    geodetic, reference = _reference(tables.get(FIX))
    kinds = bag.topics()
    return Mission(
        name=source.stem,
        description=f"recording {source.name}",
        notes="; ".join(f"{role}: {topic} ({kinds[topic]})" for role, topic in roles.items()),
        navigation=_navigation(tables, {role: kinds[topic] for role, topic in roles.items()}, options),
        reference=reference,
        geodetic=geodetic,
        import_record=ImportRecord(format="rosbag", counts=counts, lost=lost, digests=_digests(source)),
    )


Table = tuple[FloatArray, FloatArray]


def _table(role: str, topic: str, series: Series, counts: dict[str, int], lost: list[str]) -> Table | None:
    """time_s and finite rows; without bottom lock a velocity may be none, and without a gyro a turn rate."""
    counts[role] = len(series.rows)
    for name, count in (("without an answer", series.without_answer), ("with the recorder's time", series.recorder_times)):
        if count:
            counts[f"{role} {name}"] = count
    if not series.rows:
        return None
    time_s, rows, late = series.sorted()
    if late:
        counts[f"{role} put in order of their stamps"] = late
    needed = {IMU: rows[:, :4], VELOCITY: time_s[:, None], FIX: rows[:, :2]}.get(role, rows)
    good = _finite_rows(needed)
    if not good.all():
        lost.append(f"{topic}: {int((~good).sum())} of {len(good)} messages are not finite and were dropped")
    return (time_s[good], rows[good]) if good.any() else None


def _finite_rows(values: FloatArray) -> BoolArray:
    return np.asarray(np.isfinite(values).all(axis=1), dtype=np.bool_)


def _navigation(tables: Mapping[str, Table], kinds: Mapping[str, str], options: BagOptions) -> UnderwaterNavigation:
    time_s, imu = tables[IMU]
    gyro = marine_vectors(imu[:, 4:], is_marine=options.is_marine)
    velocity = None
    if VELOCITY in tables:
        velocity_time_s, body = tables[VELOCITY]
        velocity = BottomVelocity(velocity_time_s, marine_vectors(body, is_marine=options.is_marine), _finite_rows(body))
    depth = None
    if DEPTH in tables:
        depth_time_s, values = tables[DEPTH]
        depth = Scalars(depth_time_s, _depth_of(kinds[DEPTH], options)(values[:, 0]))
    return UnderwaterNavigation(
        attitude=Attitude(
            time_s, marine_attitude(imu[:, :4], is_marine=options.is_marine), gyro + 0.0 if np.isfinite(gyro).all() else None
        ),
        velocity=velocity,
        depth=depth,
        altitude=Scalars(tables[ALTITUDE][0], tables[ALTITUDE][1][:, 0]) if ALTITUDE in tables else None,
    )


def _depth_of(kind: str, options: BagOptions) -> Callable[[FloatArray], FloatArray]:
    """Pressure in Pa above that of the air over the weight of the water; the z of a point, which is up in ROS; a number as it is."""
    if kind == "sensor_msgs/msg/FluidPressure":
        return lambda pressure_pa: (pressure_pa - options.surface_pressure_pa) / (options.water_density_kg_m3 * STANDARD_GRAVITY_M_S2)
    if kind == "geometry_msgs/msg/PointStamped" and not options.is_marine:
        return lambda z_m: -z_m
    return lambda depth_m: depth_m


def _reference(fixes: Table | None) -> tuple[Geodetic | None, Reference]:
    """The first fix is the origin; all are a reference."""
    if fixes is None:
        return None, Reference(ReferenceDescription())
    time_s, rows = fixes
    latitude, longitude = float(rows[0, 0]), float(rows[0, 1])
    geodetic = Geodetic(origin_latitude_deg=latitude, origin_longitude_deg=longitude, heading_deg=0.0, y_axis="right")
    sigma_m = np.sqrt(rows[:, 2]) if (rows[:, 2] > 0.0).all() else None
    places = Fixes(time_s, from_longitude_latitude(rows[:, [1, 0]], geodetic), sigma_m)
    return geodetic, Reference(ReferenceDescription(alignment="origin", max_gap_s=MAX_FIX_GAP_S), fixes=places)


def _digests(source: Path) -> dict[str, str]:
    files = [source] if source.is_file() else sorted(path for path in source.iterdir() if path.is_file())
    return {path.name: file_digest(path) for path in files}
