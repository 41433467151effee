"""What a finished comparison says on the terminal."""

from typing import Any

from ssjs_cli.exit_codes import DONE, PARTLY_DONE
from ssjs_cli.session import Session
from ssjs_cli.studies.comparison import COMPARISON_FILE, REPORT_FILE, Comparison
from ssjs_cli.studies.tables import Column, terminal_table

TIME_COLUMNS: tuple[Column, ...] = (
    ("method", "method", ""),
    ("time_total_s", "total s", ".3f"),
    ("time_local_s", "local s", ".3f"),
    ("time_association_s", "assoc. s", ".3f"),
    ("time_global_s", "global s", ".3f"),
    ("time_other_s", "other s", ".3f"),
    ("step_time_p99_us", "step 99 % us", ".0f"),
    ("peak_rss_mb", "memory MB", ".0f"),
    ("submaps", "submaps", "d"),
    ("live_maps", "live maps", "d"),
    ("loop_candidates", "pairs tested", "d"),
    ("loop_closures", "closures", "d"),
    ("fusions", "fusions", "d"),
    ("wrong_pairs", "wrong pairs", "d"),
    ("reason", "why not", ""),
)
ACCURACY_COLUMNS: tuple[Column, ...] = (
    ("method", "method", ""),
    ("trajectory_rmse_m", "RMSE m", ".3f"),
    ("trajectory_max_m", "max m", ".3f"),
    ("reference_outliers", "outliers", "d"),
    ("map_error_mean_m", "map mean m", ".3f"),
    ("map_error_std_m", "std m", ".3f"),
    ("map_error_max_m", "max m", ".3f"),
    ("landmarks", "landmarks", "d"),
    ("landmarks_missed", "missed", "d"),
    ("landmarks_false", "false", "d"),
    ("nees_mean", "NEES (3)", ".2f"),
    ("nees_inside_fraction", "inside", ".1%"),
    ("nees_joint_per_dof", "joint/dof", ".2f"),
    ("nis_mean", "NIS/dof", ".3f"),
    ("nis_inside_fraction", "inside", ".1%"),
)


def answer_comparison(comparison: Comparison, session: Session) -> int:
    for text in comparison.lost:
        session.message(f"lost: {text}")
    session.answer(comparison.document, comparison_text(comparison))
    return PARTLY_DONE if comparison.lost else DONE


def comparison_text(comparison: Comparison) -> str:
    rows: list[dict[str, Any]] = comparison.rows
    parts = [
        terminal_table(f"{comparison.mission.name}: computing time", TIME_COLUMNS, rows),
        terminal_table("Accuracy and consistency", ACCURACY_COLUMNS, rows),
        f"results     {comparison.folder / COMPARISON_FILE}\nreport      {comparison.folder / REPORT_FILE}",
    ]
    return "\n\n".join(parts)
