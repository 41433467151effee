"""Which missions of a season stand out."""

import math
import statistics
from collections.abc import Mapping, Sequence
from typing import Any

#: What a mission is compared with the others by, larger being worse; compared as logarithms, since they are ratios of errors and counts.
OUTLIER_KEYS = ("nis_mean", "nees_mean", "trajectory_rmse_m", "map_error_mean_m", "step_time_p99_us")
#: Of a normal distribution: the standard deviation over the median of the absolute deviations.
SIGMA_PER_MAD = 1.4826
#: A season whose missions are all but equal has no outliers: deviations are counted in no smaller unit, a fifth of the value.
LEAST_SPREAD = math.log(1.2)
LEAST_MISSIONS = 4


def worst_first(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Adds outlier_score and stands_out_by: the largest deviation of a mission from the median of the season, in robust standard
    deviations, and the key it is found in. Failed missions first, then by that score, then as they came."""
    spread = {key: _centre_and_sigma([row[key] for row in rows if _is_comparable(row.get(key))]) for key in OUTLIER_KEYS}
    scored = []
    for row in rows:
        scores = {key: _deviation(row.get(key), *of) for key, of in spread.items() if of is not None}
        largest = max(scores, key=lambda key: scores[key], default=None)
        found = largest is not None and scores[largest] > 0.0
        scored.append(
            {
                **row,
                "outlier_score": round(scores[largest], 2) if found and largest is not None else None,
                "stands_out_by": largest if found else None,
            }
        )
    return sorted(scored, key=lambda row: (not row.get("reason"), -(row["outlier_score"] or 0.0)))


def _is_comparable(value: Any) -> bool:
    return isinstance(value, (int, float)) and math.isfinite(value) and value > 0.0


def _centre_and_sigma(values: Sequence[float]) -> tuple[float, float] | None:
    if len(values) < LEAST_MISSIONS:
        return None
    logarithms = [math.log(value) for value in values]
    centre = statistics.median(logarithms)
    deviation = statistics.median(abs(value - centre) for value in logarithms)
    return centre, max(SIGMA_PER_MAD * deviation, LEAST_SPREAD)


def _deviation(value: Any, centre: float, sigma: float) -> float:
    return (math.log(value) - centre) / sigma if _is_comparable(value) else 0.0
