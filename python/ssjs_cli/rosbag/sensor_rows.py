"""One message to one row of numbers, in the axes of the recording; None where the message says that it knows nothing."""

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

Row = tuple[float, ...]

NANOSECONDS = 1_000_000_000
UNKNOWN_COVARIANCE = -1.0  # of sensor_msgs: "this message has no such estimate"
NO_FIX = -1
MAX_NORM_DEVIATION = 0.01  # of a quaternion; zeros are those of a driver without an estimate


def header_time_ns(message: Any) -> int | None:
    """None without a header, or with one that was never stamped."""
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    if stamp is None:
        return None
    time_ns = int(stamp.sec) * NANOSECONDS + int(stamp.nanosec)
    return time_ns if time_ns > 0 else None


def imu_row(message: Any) -> Row | None:
    """x, y, z, w of the orientation and x, y, z of the turn rates, NaN where there is no gyro."""
    orientation, rates = message.orientation, message.angular_velocity
    quaternion = (orientation.x, orientation.y, orientation.z, orientation.w)
    is_rotation = abs(math.hypot(*quaternion) - 1.0) <= MAX_NORM_DEVIATION
    if message.orientation_covariance[0] == UNKNOWN_COVARIANCE or not is_rotation:
        return None
    has_gyro = message.angular_velocity_covariance[0] != UNKNOWN_COVARIANCE
    gyro = (rates.x, rates.y, rates.z) if has_gyro else (math.nan,) * 3
    return (*quaternion, *gyro)


def velocity_row(message: Any) -> Row:
    """A twist of whichever stamped kind."""
    twist = message.twist.twist if hasattr(message.twist, "twist") else message.twist
    return twist.linear.x, twist.linear.y, twist.linear.z


def range_row(message: Any) -> Row | None:
    """Outside its own limits an altimeter has not seen the bottom."""
    distance = float(message.range)
    return (distance,) if message.min_range <= distance <= message.max_range else None


def fix_row(message: Any) -> Row | None:
    """Latitude, longitude in degrees, variance of the worse horizontal axis in m^2, NaN where unknown."""
    if message.status.status == NO_FIX or abs(message.latitude) > 90.0 or abs(message.longitude) > 180.0:
        return None
    known = message.position_covariance_type > 0
    variance = max(message.position_covariance[0], message.position_covariance[4]) if known else math.nan
    return message.latitude, message.longitude, variance


def pressure_row(message: Any) -> Row:
    return (float(message.fluid_pressure),)


def point_row(message: Any) -> Row:
    return (float(message.point.z),)


def number_row(message: Any) -> Row:
    return (float(message.data),)


READERS: Mapping[str, Callable[[Any], Row | None]] = MappingProxyType(
    {
        "sensor_msgs/msg/Imu": imu_row,
        "geometry_msgs/msg/TwistWithCovarianceStamped": velocity_row,
        "geometry_msgs/msg/TwistStamped": velocity_row,
        "nav_msgs/msg/Odometry": velocity_row,
        "sensor_msgs/msg/FluidPressure": pressure_row,
        "geometry_msgs/msg/PointStamped": point_row,
        "sensor_msgs/msg/Range": range_row,
        "sensor_msgs/msg/NavSatFix": fix_row,
        "std_msgs/msg/Float64": number_row,
        "std_msgs/msg/Float32": number_row,
    }
)
