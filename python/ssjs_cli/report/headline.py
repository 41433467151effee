"""The numbers at the top: eight cards a reader takes in at a glance, then every key of summary.json in words."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ssjs_cli.report.number_text import (
    NO_REFERENCE,
    NOT_MEASURED,
    NOT_RECORDED,
    count_text,
    finite_number,
    metres_text,
    percent_text,
    plain_text,
    seconds_text,
    times_text,
)


@dataclass(frozen=True)
class Card:
    """value: the large number; lines: what stands under it; share: 0..1 draws a meter with a mark at 95 %."""

    title: str
    value: str
    lines: list[str]
    share: float | None = None
    muted: bool = False


@dataclass(frozen=True)
class Entry:
    label: str
    value: str
    key: str


@dataclass(frozen=True)
class Group:
    title: str
    entries: list[Entry]


def _microseconds_text(value_us: float) -> str:
    return seconds_text(1e-6 * value_us)


def _megabytes_text(value_mb: float) -> str:
    return f"{value_mb:,.0f} MB"


def _percent_value_text(value_percent: float) -> str:
    return f"{value_percent:.3g} %"


Format = Callable[[float], str]

#: title, then per row: key, label, format, text for null
GROUPS: tuple[tuple[str, tuple[tuple[str, str, Format, str], ...]], ...] = (
    (
        "Accuracy",
        (
            ("trajectory_rmse_m", "trajectory RMSE", metres_text, NO_REFERENCE),
            ("trajectory_mean_m", "trajectory mean error", metres_text, NO_REFERENCE),
            ("trajectory_std_m", "trajectory standard deviation", metres_text, NO_REFERENCE),
            ("trajectory_max_m", "trajectory largest error", metres_text, NO_REFERENCE),
            ("final_drift_percent", "final drift, of path length", _percent_value_text, NO_REFERENCE),
            ("dead_reckoning_rmse_m", "dead reckoning RMSE", metres_text, NO_REFERENCE),
            ("dead_reckoning_final_drift_percent", "dead reckoning final drift", _percent_value_text, NO_REFERENCE),
            ("reference_outliers", "reference outliers", count_text, NO_REFERENCE),
            ("map_error_mean_m", "map error mean", metres_text, NO_REFERENCE),
            ("map_error_std_m", "map error standard deviation", metres_text, NO_REFERENCE),
            ("map_error_max_m", "map error largest", metres_text, NO_REFERENCE),
            ("landmark_error_rms_m", "landmarks against the ground they show, RMS", metres_text, NO_REFERENCE),
            ("landmark_error_median_m", "the same, median", metres_text, NO_REFERENCE),
            ("landmark_error_max_m", "the same, largest", metres_text, NO_REFERENCE),
            ("landmarks_missed", "landmarks missed", count_text, NO_REFERENCE),
            ("landmarks_false", "landmarks false", count_text, NO_REFERENCE),
        ),
    ),
    (
        "Consistency",
        (
            ("nees_mean", "NEES mean, vehicle pose", plain_text, NO_REFERENCE),
            ("nees_inside_fraction", "NEES inside its 95 % band", percent_text, NO_REFERENCE),
            ("nees_joint_per_dof", "NEES of all bases jointly, per dof", plain_text, NO_REFERENCE),
            ("nees_base_mean", "NEES mean, bases", plain_text, NO_REFERENCE),
            ("nees_map_mean", "NEES mean, landmarks", plain_text, NO_REFERENCE),
            ("nis_mean", "NIS mean", plain_text, NOT_RECORDED),
            ("nis_inside_fraction", "NIS inside its 95 % band", percent_text, NOT_RECORDED),
            ("half_chi2_initial", "½ χ² before the global solution", plain_text, NOT_RECORDED),
            ("half_chi2_final", "½ χ² after the global solution", plain_text, NOT_RECORDED),
        ),
    ),
    (
        "Map",
        (
            ("steps", "steps", count_text, NOT_RECORDED),
            ("observations", "observations", count_text, NOT_RECORDED),
            ("landmarks", "landmarks", count_text, NOT_RECORDED),
            ("submaps", "submaps", count_text, NOT_RECORDED),
            ("loop_candidates", "map pairs tested", count_text, NOT_RECORDED),
            ("loop_closures", "loop closures", count_text, NOT_RECORDED),
            ("fusions", "maps merged", count_text, NOT_RECORDED),
            ("wrong_pairs", "wrong pairs", count_text, NO_REFERENCE),
        ),
    ),
    (
        "Time",
        (
            ("time_total_s", "total", seconds_text, NOT_RECORDED),
            ("time_local_s", "local maps", seconds_text, NOT_RECORDED),
            ("time_association_s", "association", seconds_text, NOT_MEASURED),
            ("time_global_s", "global level", seconds_text, NOT_RECORDED),
            ("time_other_s", "other", seconds_text, NOT_RECORDED),
            ("step_time_p50_us", "step, median", _microseconds_text, NOT_RECORDED),
            ("step_time_p99_us", "step, 99 %", _microseconds_text, NOT_RECORDED),
            ("step_time_max_us", "step, largest", _microseconds_text, NOT_RECORDED),
            ("peak_rss_mb", "largest memory", _megabytes_text, NOT_RECORDED),
        ),
    ),
)

#: Of some missions only: shown where the summary has them.
SOMETIMES = ("landmark_error_rms_m", "landmark_error_median_m", "landmark_error_max_m")
#: What is done before the estimator begins: key of timing.json's parts, and what it is.
BEFORE_TEXTS = (("detect_s", "finding contacts"), ("frames_s", "reading frames"), ("register_s", "registering frames"))


def measured(summary: dict[str, Any], key: str) -> float | None:
    """A time of exactly nothing is that of a part that no clock was put to; it lies in that of the others."""
    value = finite_number(summary.get(key))
    return None if value == 0.0 and key == "time_association_s" else value


def number_groups(summary: dict[str, Any]) -> list[Group]:
    groups = []
    for title, rows in GROUPS:
        entries = []
        for key, label, text, absent in rows:
            if key in SOMETIMES and key not in summary:
                continue
            value = measured(summary, key)
            entries.append(Entry(label, absent if value is None else text(value), key))
        if title == "Accuracy":
            alignment = summary.get("alignment")
            entries.append(Entry("alignment to the reference", str(alignment) if alignment else NO_REFERENCE, "alignment"))
        groups.append(Group(title, entries))
    return groups


def _joined(summary: dict[str, Any], parts: tuple[tuple[str, str, Format], ...]) -> str:
    """ "mean 0.31 m · largest 1.2 m" from the keys that have a value."""
    texts = []
    for key, wording, text in parts:
        value = finite_number(summary.get(key))
        if value is not None:
            texts.append(wording.format(text(value)))
    return " · ".join(texts)


def cards(summary: dict[str, Any], duration_s: float | None, timing: dict[str, Any] | None = None) -> list[Card]:
    """timing: timing.json, where it is there."""
    return [
        _trajectory_card(summary),
        _map_error_card(summary),
        _share_card(summary, "NEES inside 95 % band", "nees_inside_fraction", "nees_mean", "mean {} for the vehicle pose", NO_REFERENCE),
        _share_card(summary, "NIS inside 95 % band", "nis_inside_fraction", "nis_mean", "mean {}", NOT_RECORDED),
        _count_card(
            summary, "Map", "landmarks", "landmarks",
            (("submaps", "in {} submaps", count_text), ("observations", "{} observations", count_text)),
        ),
        _count_card(
            summary, "Loop closures", "loop_closures", "",
            (("loop_candidates", "of {} map pairs tested", count_text), ("wrong_pairs", "{} wrong pairs", count_text)),
        ),
        _step_card(summary),
        _total_card(summary, duration_s, timing),
    ]  # fmt: skip


def _trajectory_card(summary: dict[str, Any]) -> Card:
    rmse_m = finite_number(summary.get("trajectory_rmse_m"))
    dead_m = finite_number(summary.get("dead_reckoning_rmse_m"))
    lines = [_joined(summary, (("trajectory_mean_m", "mean {}", metres_text), ("trajectory_max_m", "largest {}", metres_text)))]
    if dead_m is not None:
        times = f", {times_text(dead_m / rmse_m)} × as much" if rmse_m and dead_m > rmse_m else ""
        lines.append(f"dead reckoning {metres_text(dead_m)}{times}")
    return _card("Trajectory RMSE", rmse_m, metres_text, lines, NO_REFERENCE)


def _map_error_card(summary: dict[str, Any]) -> Card:
    seen_m = finite_number(summary.get("landmark_error_rms_m"))
    if seen_m is not None:  # what a keypoint shows has no name in the world: its truth is the place that was seen
        parts = (("landmark_error_median_m", "median {}", metres_text), ("landmark_error_max_m", "largest {}", metres_text))
        compared = _joined(summary, (("landmarks_compared", "{} landmarks against the ground they show", count_text),))
        return _card("Map error, RMS", seen_m, metres_text, [_joined(summary, parts), compared], NO_REFERENCE)
    lines = [
        _joined(summary, (("map_error_std_m", "σ {}", metres_text), ("map_error_max_m", "largest {}", metres_text))),
        _joined(summary, (("landmarks_missed", "{} missed", count_text), ("landmarks_false", "{} false", count_text))),
    ]
    return _card("Map error, mean", finite_number(summary.get("map_error_mean_m")), metres_text, lines, NO_REFERENCE)


def _share_card(summary: dict[str, Any], title: str, share_key: str, mean_key: str, mean_wording: str, absent: str) -> Card:
    share = finite_number(summary.get(share_key))
    card = _card(title, share, percent_text, [_joined(summary, ((mean_key, mean_wording, plain_text),))], absent)
    return card if share is None else Card(card.title, card.value, card.lines, share=min(max(share, 0.0), 1.0))


def _count_card(summary: dict[str, Any], title: str, key: str, unit: str, parts: tuple[tuple[str, str, Format], ...]) -> Card:
    def with_unit(value: float) -> str:
        return f"{count_text(value)} {unit}".strip()

    return _card(title, finite_number(summary.get(key)), with_unit, [_joined(summary, parts)], NOT_RECORDED)


def _step_card(summary: dict[str, Any]) -> Card:
    parts = (("step_time_p99_us", "99 % below {}", _microseconds_text), ("step_time_max_us", "largest {}", _microseconds_text))
    lines = [_joined(summary, parts), _joined(summary, (("steps", "{} steps", count_text),))]
    return _card("Time per step, median", finite_number(summary.get("step_time_p50_us")), _microseconds_text, lines, NOT_RECORDED)


def _total_card(summary: dict[str, Any], duration_s: float | None, timing: dict[str, Any] | None) -> Card:
    total_s = finite_number(summary.get("time_total_s"))
    lines = []
    if total_s and duration_s:
        lines.append(f"for a mission of {seconds_text(duration_s)}: {duration_s / total_s:,.0f} × real time")
    parts = (timing or {}).get("parts")
    before = [(text, finite_number(parts.get(key))) for key, text in BEFORE_TEXTS] if isinstance(parts, dict) else []
    lines += [f"{text} before it: {seconds_text(value)}" for text, value in before if value is not None]
    lines.append(_joined(summary, (("peak_rss_mb", "largest memory {}", _megabytes_text),)))
    return _card("Computing time", total_s, seconds_text, lines, NOT_RECORDED)


def _card(title: str, value: float | None, text: Format, lines: list[str], absent: str) -> Card:
    if value is None:
        return Card(title, absent, [line for line in lines if line], muted=True)
    return Card(title, text(value), [line for line in lines if line])


@dataclass(frozen=True)
class TimeShare:
    label: str
    text: str
    percent: float
    colour: str


TIME_PARTS = (
    ("time_local_s", "local maps", "#3b78b5"),
    ("time_association_s", "association", "#ea7f1e"),
    ("time_global_s", "global level", "#7d5ba6"),
    ("time_other_s", "other", "#b8c2cc"),
)


def time_shares(summary: dict[str, Any]) -> list[TimeShare]:
    """Where the computing time went, in per cent of the sum of the parts; empty when a run did not record them."""
    known = [(label, max(value, 0.0), colour) for key, label, colour in TIME_PARTS if (value := measured(summary, key)) is not None]
    total_s = sum(value for _, value, _ in known)
    if total_s <= 0.0:
        return []
    return [TimeShare(label, seconds_text(value), round(100.0 * value / total_s, 3), colour) for label, value, colour in known]
