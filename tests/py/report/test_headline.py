import math
import re
from pathlib import Path

from ssjs_cli.report.headline import GROUPS, cards, number_groups, time_shares

CONTRACT_KEYS = [
    "steps", "observations", "landmarks", "submaps", "loop_candidates", "loop_closures", "fusions", "wrong_pairs",
    "time_total_s", "time_local_s", "time_global_s", "time_association_s", "time_other_s",
    "step_time_p50_us", "step_time_p99_us", "step_time_max_us", "peak_rss_mb",
    "trajectory_rmse_m", "trajectory_mean_m", "trajectory_std_m", "trajectory_max_m", "final_drift_percent",
    "dead_reckoning_rmse_m", "dead_reckoning_final_drift_percent", "reference_outliers",
    "map_error_mean_m", "map_error_std_m", "map_error_max_m", "landmarks_missed", "landmarks_false",
    "nees_mean", "nees_inside_fraction", "nees_joint_per_dof", "nees_base_mean", "nees_map_mean", "nis_mean", "nis_inside_fraction",
    "half_chi2_initial", "half_chi2_final", "alignment",
]  # fmt: skip


def entries(summary):
    return {entry.key: entry.value for group in number_groups(summary) for entry in group.entries}


def test_every_key_of_the_summary_is_shown_once():
    shown = [entry.key for group in number_groups({}) for entry in group.entries]
    assert sorted(shown) == sorted(CONTRACT_KEYS)
    assert [title for title, _ in GROUPS] == ["Accuracy", "Consistency", "Map", "Time"]


def test_null_reads_no_reference_where_truth_is_needed():
    shown = entries({"trajectory_rmse_m": None, "nis_mean": None, "nees_mean": math.nan})
    assert (shown["trajectory_rmse_m"], shown["nees_mean"], shown["alignment"]) == ("no reference",) * 3
    assert shown["nis_mean"] == "not recorded"


def test_numbers_have_units():
    shown = entries(
        {"trajectory_rmse_m": 1.404, "nees_inside_fraction": 0.953, "step_time_p50_us": 3.1, "peak_rss_mb": 96.2, "steps": 61945}
    )
    assert [shown[key] for key in ("trajectory_rmse_m", "nees_inside_fraction", "step_time_p50_us", "peak_rss_mb", "steps")] == [
        "1.40 m", "95.3 %", "3.1 µs", "96 MB", "61,945",
    ]  # fmt: skip


def test_card_compares_with_dead_reckoning_and_with_real_time():
    # 21 m over 1.4 m is 15 times; 1,500 s in 2 s is 750 times
    by_title = {card.title: card for card in cards({"trajectory_rmse_m": 1.4, "dead_reckoning_rmse_m": 21.0, "time_total_s": 2.0}, 1500.0)}
    assert by_title["Trajectory RMSE"].lines == ["dead reckoning 21.00 m, 15 × as much"]
    assert by_title["Computing time"].lines == ["for a mission of 1,500 s: 750 × real time"]


def test_cards_without_numbers_say_so():
    values = {card.title: (card.value, card.muted, card.share) for card in cards({}, None)}
    assert values["Trajectory RMSE"] == ("no reference", True, None)
    assert values["Time per step, median"] == ("not recorded", True, None)


def test_shares_of_the_computing_time():
    shares = time_shares({"time_local_s": 1.0, "time_global_s": 3.0, "time_association_s": None})
    assert [(share.label, share.percent) for share in shares] == [("local maps", 25.0), ("global level", 75.0)]
    assert time_shares({}) == []


def test_the_source_holds_no_absolute_path_or_clock():
    import ssjs_cli.report as report

    for source in Path(report.__file__).parent.glob("*.py"):
        assert not re.search(r"\b(datetime|uuid|time\.time|resolve\(|absolute\()", source.read_text(encoding="utf-8")), source.name
