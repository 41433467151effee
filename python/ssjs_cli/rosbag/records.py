"""What a bag is made of, whichever format it has."""

from typing import NamedTuple


class BagTopic(NamedTuple):
    """kind: the type as ROS 2 names it, such as sensor_msgs/msg/Imu; definition: its text, and those of the types inside."""

    name: str
    kind: str
    definition: str


class BagMessage(NamedTuple):
    topic: str
    time_ns: int
    data: bytes


class BrokenBagError(Exception):
    """Why no more of a bag can be read."""
