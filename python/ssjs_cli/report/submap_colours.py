"""Ten colours for any number of submaps: neighbours on the ground differ, as countries do on a political map."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

PALETTE = ("#3b78b5", "#ea7f1e", "#3a9a4b", "#d1495b", "#7d5ba6", "#00a6a6", "#a0662f", "#d45ba8", "#b39a00", "#5f7484")
#: For landmarks whose submap is not listed.
UNKNOWN_COLOUR = "#9aa3ad"


def colour_groups(base_position: FloatArray) -> list[int]:
    """One palette index per submap; base_position (n, 2) in metres. Each takes the colour whose nearest bearer so far is farthest."""
    groups: list[int] = []
    nearest = np.full(len(PALETTE), np.inf)
    for index, position in enumerate(base_position):
        earlier = np.array(groups, dtype=np.int64)
        distance = np.hypot(*(base_position[:index] - position).T)
        for group in range(len(PALETTE)):
            bearers = distance[earlier == group] if index else distance
            nearest[group] = bearers.min() if len(bearers) else np.inf
        groups.append(int(np.argmax(nearest)))
    return groups
