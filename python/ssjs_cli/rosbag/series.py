"""The rows of each topic, in the order of their own stamps."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ssjs_cli.formats.number_table import FloatArray
from ssjs_cli.rosbag.bag import UNDECODABLE, Bag
from ssjs_cli.rosbag.sensor_rows import NANOSECONDS, READERS, Row, header_time_ns


@dataclass
class Series:
    """time_ns: of the header, else of the recorder. without_answer: messages that know nothing, such as a fix without satellites."""

    time_ns: list[int] = field(default_factory=list)
    rows: list[Row] = field(default_factory=list)
    recorder_times: int = 0
    without_answer: int = 0

    def add(self, time_ns: int | None, recorder_ns: int, row: Row | None) -> None:
        if row is None:
            self.without_answer += 1
            return
        self.recorder_times += time_ns is None
        self.time_ns.append(recorder_ns if time_ns is None else time_ns)
        self.rows.append(row)

    def sorted(self) -> tuple[FloatArray, FloatArray, int]:
        """time_s (n,), rows (n, columns), and how many came later than one with a later stamp. Equal stamps keep their order."""
        time_ns = np.array(self.time_ns, dtype=np.int64)
        order = np.argsort(time_ns, kind="stable")
        late = int((np.diff(time_ns) < 0).sum())
        whole, rest = np.divmod(time_ns[order], NANOSECONDS)
        return whole + rest / NANOSECONDS, np.array(self.rows, dtype=np.float64)[order], late


def read_series(bag: Bag, roles: Mapping[str, str]) -> dict[str, Series]:
    """By role."""
    kinds = bag.topics()
    role_of = {topic: role for role, topic in roles.items()}
    series = {role: Series() for role in roles}
    for entry in bag.messages(set(role_of)):
        try:
            row, time_ns = READERS[kinds[entry.topic]](entry.message), header_time_ns(entry.message)
        except UNDECODABLE:  # a type of this name with other fields
            bag.note_undecodable(entry.topic)
            continue
        series[role_of[entry.topic]].add(time_ns, entry.time_ns, row)
    return series


def unused_topics(bag: Bag, roles: Mapping[str, str]) -> Counter[str]:
    """Their messages, by name and type."""
    counts = bag.counts()
    return Counter({f"{name} ({kind})": counts[name] for name, kind in bag.topics().items() if name not in roles.values()})
