"""The page of a season of missions: one table, what stands out on top."""

from typing import TYPE_CHECKING

from ssjs_cli.report.sheet import SheetColumn, sheet
from ssjs_cli.report.study_page import StudyPage, render_study

if TYPE_CHECKING:
    from ssjs_cli.studies.batch import Season

SEASON_SHEET: tuple[SheetColumn, ...] = (
    ("mission", "mission", None, 1.0),
    ("outlier_score", "stands out", 1, 1.0),
    ("stands_out_by", "by", None, 1.0),
    ("warnings", "warnings", 0, 1.0),
    ("lost", "lost", 0, 1.0),
    ("landmarks", "landmarks", 0, 1.0),
    ("submaps", "submaps", 0, 1.0),
    ("loop_closures", "loop closures", 0, 1.0),
    ("nis_mean", "NIS / dof", 3, 1.0),
    ("trajectory_rmse_m", "RMSE [m]", 3, 1.0),
    ("dead_reckoning_rmse_m", "dead reckoning [m]", 2, 1.0),
    ("map_error_mean_m", "map error [m]", 3, 1.0),
    ("nees_mean", "pose NEES", 2, 1.0),
    ("time_total_s", "time [s]", 2, 1.0),
    ("directory", "run directory", None, 1.0),
)
NOTE = (
    "Missions that failed come first, then those that stand out: by how many robust standard deviations a mission is worse than the "
    "median of the season, in the logarithm of the column named."
)


def season_page(season: "Season") -> str:
    finished = [row for row in season.rows if not row["reason"]]
    page = StudyPage(
        kind="season of missions",
        title=season.folder.name,
        facts=[("missions", str(len(season.rows))), ("finished", str(len(finished)))],
        sheets=[sheet("season", "Missions", SEASON_SHEET, season.rows, note=NOTE)],
        sections=[],
        failures=[(row["mission"], row["reason"]) for row in season.rows if row["reason"]],
    )
    return render_study(page)
