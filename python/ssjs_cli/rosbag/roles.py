"""Which topic of a recording says what: by its type, by its name where the type alone does not tell, or as the user says."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from ssjs_cli.errors import UserError, nearest_hint

IMU, VELOCITY, DEPTH, ALTITUDE, FIX = "imu", "velocity", "depth", "altitude", "fix"
NONE = "none"


@dataclass(frozen=True)
class Role:
    """kinds: types in the order of preference. named: types that need a topic name with the word, or to be named by the user."""

    kinds: tuple[str, ...]
    named: tuple[str, ...] = ()
    word: str = ""

    @property
    def accepted(self) -> tuple[str, ...]:
        return self.kinds + self.named


_NUMBERS = ("std_msgs/msg/Float64", "std_msgs/msg/Float32")
ROLES: Mapping[str, Role] = MappingProxyType(
    {
        IMU: Role(("sensor_msgs/msg/Imu",)),
        VELOCITY: Role(("geometry_msgs/msg/TwistWithCovarianceStamped", "geometry_msgs/msg/TwistStamped", "nav_msgs/msg/Odometry")),
        DEPTH: Role(("sensor_msgs/msg/FluidPressure",), ("geometry_msgs/msg/PointStamped", *_NUMBERS), "depth"),
        ALTITUDE: Role(("sensor_msgs/msg/Range",), _NUMBERS, "altitude|altimeter"),
        FIX: Role(("sensor_msgs/msg/NavSatFix",)),
    }
)


def parse_topics(texts: Sequence[str]) -> dict[str, str]:
    """`imu=/x`, once a role; `none` leaves a role out."""
    chosen: dict[str, str] = {}
    for text in texts:
        role, separator, topic = text.partition("=")
        if not separator or not topic or role not in ROLES:
            raise UserError(
                f"--topic {text}: must be ROLE=TOPIC or ROLE=none with ROLE one of {', '.join(ROLES)}{nearest_hint(role, ROLES)}"
            )
        if role in chosen:
            raise UserError(f"--topic {text}: {role} is given twice; keep one")
        chosen[role] = topic
    return chosen


def choose_topics(topics: Mapping[str, str], chosen: Mapping[str, str]) -> dict[str, str]:
    """Role to topic. topics: name to type."""
    found: dict[str, str] = {}
    for role, description in ROLES.items():
        if chosen.get(role) == NONE:
            continue
        if role in chosen:
            found[role] = _checked(role, description, chosen[role], topics)
            continue
        taken = set(chosen.values())
        candidates = [name for name in _candidates(description, topics) if name not in taken]
        if len(candidates) > 1:
            raise UserError(
                f"{len(candidates)} topics could be the {role}: {', '.join(candidates)}; choose with --topic {role}={candidates[0]}, "
                f"or leave it out with --topic {role}=none"
            )
        if candidates:
            found[role] = candidates[0]
    if IMU not in found:
        held = ", ".join(f"{name} ({kind})" for name, kind in topics.items()) or "nothing"
        raise UserError(f"the recording holds no attitude ({ROLES[IMU].kinds[0]}), which a mission needs; it holds {held}")
    return found


def _candidates(role: Role, topics: Mapping[str, str]) -> list[str]:
    """The topics of the most preferred type that there is."""
    for kind in role.kinds:
        if names := [name for name, held in topics.items() if held == kind]:
            return names
    if not role.named:
        return []
    return [name for name, held in topics.items() if held in role.named and re.search(role.word, name.lower())]


def _checked(role: str, description: Role, topic: str, topics: Mapping[str, str]) -> str:
    if topic not in topics:
        raise UserError(f"--topic {role}={topic}: there is no such topic{nearest_hint(topic, topics)}; there are {', '.join(topics)}")
    if topics[topic] not in description.accepted:
        raise UserError(f"--topic {role}={topic}: is {topics[topic]}; {role} can be read from {', '.join(description.accepted)}")
    return topic
