"""Recordings written by the library rosbags, in the axes of ROS, of a vehicle whose motion is known in those of the sea."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

SECOND_NS = 1_000_000_000
START_NS = 1_700_000_000 * SECOND_NS
ROS1, SQLITE, MCAP = "ROS 1 bag", "sqlite3", "mcap"
FORMATS = (ROS1, SQLITE, MCAP)

NED_R_ENU = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
FRD_R_FLU = np.diag([1.0, -1.0, -1.0])

Stamped = tuple[str, str, int, Any]  # topic, type, recorder's time, message


class Messages:
    """Makes messages of one ROS."""

    def __init__(self, kind: str) -> None:
        from rosbags.typesys import Stores, get_typestore

        self.store = get_typestore(Stores.ROS1_NOETIC if kind == ROS1 else Stores.ROS2_HUMBLE)
        self.is_ros1 = kind == ROS1

    def make(self, kind: str, **fields: Any) -> Any:
        return self.store.types[kind](**fields)

    def header(self, time_ns: int) -> Any:
        seconds, rest = divmod(time_ns, SECOND_NS)
        stamp = self.make("builtin_interfaces/msg/Time", sec=seconds, nanosec=rest)
        fields = {"seq": 0} if self.is_ros1 else {}
        return self.make("std_msgs/msg/Header", stamp=stamp, frame_id="base_link", **fields)

    def vector(self, values: Iterable[float]) -> Any:
        x, y, z = (float(value) for value in values)
        return self.make("geometry_msgs/msg/Vector3", x=x, y=y, z=z)

    def imu(self, time_ns: int, roll_pitch_yaw: Sequence[float], rates: Sequence[float], *, known: bool = True, gyro: bool = True) -> Any:
        """Angles and rates of the sea's axes."""
        ned_R_frd = Rotation.from_euler("ZYX", list(roll_pitch_yaw)[::-1]).as_matrix()
        x, y, z, w = Rotation.from_matrix(NED_R_ENU @ ned_R_frd @ FRD_R_FLU).as_quat()
        unknown, zero = np.array([-1.0, *[0.0] * 8]), np.zeros(9)
        return self.make(
            "sensor_msgs/msg/Imu",
            header=self.header(time_ns),
            orientation=self.make("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w),
            orientation_covariance=zero if known else unknown,
            angular_velocity=self.vector(FRD_R_FLU @ np.asarray(rates)),
            angular_velocity_covariance=zero if gyro else unknown,
            linear_acceleration=self.vector((0.0, 0.0, 9.8)),
            linear_acceleration_covariance=zero,
        )

    def twist(self, time_ns: int, velocity: Sequence[float]) -> Any:
        linear = self.vector(FRD_R_FLU @ np.asarray(velocity))
        twist = self.make("geometry_msgs/msg/Twist", linear=linear, angular=self.vector((0.0, 0.0, 0.0)))
        inner = self.make("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=np.zeros(36))
        return self.make("geometry_msgs/msg/TwistWithCovarianceStamped", header=self.header(time_ns), twist=inner)

    def pressure(self, time_ns: int, pascal: float) -> Any:
        return self.make("sensor_msgs/msg/FluidPressure", header=self.header(time_ns), fluid_pressure=pascal, variance=0.0)

    def range(self, time_ns: int, distance: float) -> Any:
        return self.make(
            "sensor_msgs/msg/Range",
            header=self.header(time_ns),
            radiation_type=0,
            field_of_view=0.1,
            min_range=0.5,
            max_range=50.0,
            range=distance,
        )

    def fix(self, time_ns: int, latitude: float, longitude: float, *, status: int = 0) -> Any:
        return self.make(
            "sensor_msgs/msg/NavSatFix",
            header=self.header(time_ns),
            status=self.make("sensor_msgs/msg/NavSatStatus", status=status, service=1),
            latitude=latitude,
            longitude=longitude,
            altitude=0.0,
            position_covariance=np.array([4.0, 0.0, 0.0, 0.0, 9.0, 0.0, 0.0, 0.0, 25.0]),
            position_covariance_type=2,
        )

    def number(self, value: float) -> Any:
        return self.make("std_msgs/msg/Float64", data=value)

    def text(self, value: str) -> Any:
        return self.make("std_msgs/msg/String", data=value)


@contextmanager
def _writer(path: Path, kind: str) -> Iterator[Any]:
    if kind == ROS1:
        from rosbags.rosbag1 import Writer as Writer1

        with Writer1(path) as writer:
            yield writer
        return
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.rosbag2 import Writer as Writer2

    with Writer2(path, version=9, storage_plugin=StoragePlugin.MCAP if kind == MCAP else StoragePlugin.SQLITE3) as writer:
        yield writer


def write_bag(path: Path, kind: str, messages: Iterable[Stamped]) -> Path:
    store = Messages(kind).store
    connections: dict[str, Any] = {}
    with _writer(path, kind) as writer:
        for topic, message_kind, time_ns, message in messages:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, message_kind, typestore=store)
            serialize = store.serialize_ros1 if kind == ROS1 else store.serialize_cdr
            writer.write(connections[topic], time_ns, serialize(message, message_kind))
    return path


def angles_at(step: int) -> tuple[float, float, float]:
    """roll, pitch, yaw at the step, 10 a second: starboard down, bow up, turning slowly to starboard."""
    return 0.05, 0.1, -1.2 + 0.002 * step


def dive(kind: str, seconds: int = 20) -> Iterator[Stamped]:
    """1.5 m/s ahead, 0.1 m/s to starboard, at 7 m, 9 m above the bottom. The recorder writes 30 ms late."""
    make = Messages(kind)
    for step in range(10 * seconds):
        time_ns = START_NS + step * SECOND_NS // 10
        late_ns = time_ns + 30_000_000
        yield "/imu/data", "sensor_msgs/msg/Imu", late_ns, make.imu(time_ns, angles_at(step), (0.001, -0.002, 0.02))
        if step % 2 == 0:
            noise_m_s = 0.001 * (0, 1, -1)[step // 2 % 3]  # a log that says the same for ever hangs
            velocity = (1.5 + noise_m_s, 0.1, -0.05)
            yield "/dvl/twist", "geometry_msgs/msg/TwistWithCovarianceStamped", late_ns, make.twist(time_ns, velocity)
            yield "/altimeter", "sensor_msgs/msg/Range", late_ns, make.range(time_ns, 9.0 if step % 20 else 60.0)
        yield "/pressure", "sensor_msgs/msg/FluidPressure", late_ns, make.pressure(time_ns, 101_325.0 + 7.0 * 1025.0 * 9.80665)
        if step % 10 == 0:
            north_deg = 1.5 * step / 10 / 111_000.0
            fix = make.fix(time_ns, 41.78 + north_deg, 3.03, status=-1 if step == 0 else 0)
            yield "/gps/fix", "sensor_msgs/msg/NavSatFix", late_ns, fix
            yield "/log", "std_msgs/msg/String", late_ns, make.text(f"step {step}")
