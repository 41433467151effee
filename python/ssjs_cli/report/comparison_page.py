"""The report of a comparison of methods."""

from typing import TYPE_CHECKING

from ssjs_cli.methods import known_methods
from ssjs_cli.report import comparison_figures as figures
from ssjs_cli.report.comparison_figures import MethodCurves
from ssjs_cli.report.figure_style import Figure
from ssjs_cli.report.method_colours import method_colours
from ssjs_cli.report.number_text import count_text, seconds_text
from ssjs_cli.report.page_parts import Plot
from ssjs_cli.report.sheet import SheetColumn, sheet
from ssjs_cli.report.study_page import GATE_NOTE, Section, StudyPage, render_study

if TYPE_CHECKING:
    from ssjs_cli.studies.comparison import Comparison

POSE_DOF = 3
TIME_SHEET: tuple[SheetColumn, ...] = (
    ("method", "method", None, 1.0),
    ("time_total_s", "total [s]", 3, 1.0),
    ("time_local_s", "local [s]", 3, 1.0),
    ("time_association_s", "association [s]", 3, 1.0),
    ("time_global_s", "global [s]", 3, 1.0),
    ("time_other_s", "other [s]", 3, 1.0),
    ("step_time_p50_us", "step, median [µs]", 1, 1.0),
    ("step_time_p99_us", "99 % [µs]", 0, 1.0),
    ("step_time_max_us", "largest [µs]", 0, 1.0),
    ("peak_rss_mb", "memory [MB]", 0, 1.0),
)
MAP_SHEET: tuple[SheetColumn, ...] = (
    ("method", "method", None, 1.0),
    ("trajectory_rmse_m", "RMSE [m]", 3, 1.0),
    ("trajectory_mean_m", "mean [m]", 3, 1.0),
    ("trajectory_std_m", "std [m]", 3, 1.0),
    ("trajectory_max_m", "max [m]", 3, 1.0),
    ("reference_outliers", "outliers", 0, 1.0),
    ("final_drift_percent", "final drift [%]", 3, 1.0),
    ("map_error_mean_m", "map mean [m]", 3, 1.0),
    ("map_error_std_m", "std [m]", 3, 1.0),
    ("map_error_max_m", "max [m]", 3, 1.0),
    ("landmarks", "landmarks", 0, 1.0),
    ("landmarks_missed", "missed", 0, 1.0),
    ("landmarks_false", "false", 0, 1.0),
)
CONSISTENCY_SHEET: tuple[SheetColumn, ...] = (
    ("method", "method", None, 1.0),
    ("nees_mean", "NEES, 3 dof", 2, 1.0),
    ("nees_inside_fraction", "inside [%]", 1, 100.0),
    ("nees_joint_per_dof", "bases jointly / dof", 3, 1.0),
    ("nees_base_mean", "bases, 3 dof", 2, 1.0),
    ("nees_map_mean", "landmarks, 2 dof", 2, 1.0),
    ("nees_position_per_dof", "position / dof", 2, 1.0),
    ("inside_3_sigma_fraction", "within 3 σ [%]", 1, 100.0),
    ("nis_mean", "NIS / dof", 3, 1.0),
    ("nis_band_low", "band from", 3, 1.0),
    ("nis_band_high", "to", 3, 1.0),
    ("nis_inside_fraction", "inside [%]", 1, 100.0),
    ("half_chi2_initial", "½ χ² before", 1, 1.0),
    ("half_chi2_final", "½ χ² after", 1, 1.0),
)
COUNT_SHEET: tuple[SheetColumn, ...] = (
    ("method", "method", None, 1.0),
    ("submaps", "submaps", 0, 1.0),
    ("live_maps", "live maps", 0, 1.0),
    ("loop_candidates", "map pairs tested", 0, 1.0),
    ("loop_closures", "loop closures", 0, 1.0),
    ("fusions", "fusions", 0, 1.0),
    ("wrong_pairs", "wrong pairs", 0, 1.0),
)


def comparison_page(comparison: "Comparison") -> str:
    methods = [row["method"] for row in comparison.rows]
    colours = method_colours(methods, known_methods())
    finished = [
        MethodCurves(row["method"], colours[row["method"]], comparison.records[row["method"]], row)
        for row in comparison.rows
        if row["method"] in comparison.records
    ]
    rows = [dict(entry.numbers) for entry in finished]
    swatches = [entry.colour for entry in finished]
    overlay = figures.maps(finished)
    sheets = [
        sheet("accuracy", "Accuracy", MAP_SHEET, rows, colours=swatches),
        sheet(
            "consistency-numbers", "Consistency", CONSISTENCY_SHEET, rows, colours=swatches,
            note="Inside: share of the values inside their own 95 % band; 95 % expected. NEES of the vehicle pose should be 3 in the mean "
            "(single values between 0.22 and 9.35), of landmarks 2, NIS per degree of freedom 1.",
        ),
        sheet("times", "Computing time and memory", TIME_SHEET, rows, colours=swatches),
        sheet("counts", "Maps", COUNT_SHEET, rows, colours=swatches),
    ]  # fmt: skip
    map_plot = Plot("map", "Maps", missing="No method finished, so there is no map to draw.")
    if overlay is not None:
        map_plot = Plot("map", "Maps", overlay.figure, overlay.notes)
    no_reference = "The mission holds no reference to compare with."
    no_truth = "The mission holds no dense truth, which NEES needs; NIS below needs none."
    sections = [
        Section("map-section", "Maps", [map_plot]),
        Section(
            "time-section",
            "Computing time",
            [
                _plot("time-split", "Where the time goes", figures.time_split(finished), "No method recorded its times."),
                _plot(
                    "cumulative-time", "Time spent over the mission", figures.cumulative_time(finished), "No method recorded its steps.",
                    "Sum of the step times of the repeat with the median total; what a method does after the last event is not in it.",
                ),
            ],
        ),
        Section(
            "error-section",
            "Error",
            [
                _plot("error", "Position error of the final trajectory", figures.errors(finished, "final"), no_reference),
                *_extra("error-online", "Position error of the online estimate", figures.errors(finished, "online")),
            ],
        ),
        Section(
            "consistency-section",
            "Consistency",
            [
                _plot("nees", "NEES of the vehicle pose, final trajectory", figures.nees(finished, "final", POSE_DOF), no_truth),
                *_extra("nees-online", "NEES of the vehicle pose, online", figures.nees(finished, "online", POSE_DOF)),
                _plot(
                    "nis", "NIS of the scan updates", figures.nis(finished), "No scan updated a filter.",
                    f"Means over equal spans of the mission; the band is that of the degrees of freedom in a span. {GATE_NOTE}",
                ),
            ],
        ),
    ]  # fmt: skip
    page = StudyPage(
        kind="comparison of methods",
        title=comparison.mission.name,
        subtitle=comparison.mission.description,
        facts=_facts(comparison),
        sheets=sheets,
        sections=sections,
        failures=[(row["method"], row["reason"]) for row in comparison.rows if row["reason"]],
        layers=overlay.layers if overlay is not None else [],
    )
    return render_study(page)


def _plot(div_id: str, heading: str, figure: Figure | None, missing: str, note: str = "") -> Plot:
    if figure is None:
        return Plot(div_id, heading, missing=missing)
    return Plot(div_id, heading, figure, [note] if note else [])


def _extra(div_id: str, heading: str, figure: Figure | None) -> list[Plot]:
    """A second view: where it is missing the first has said why."""
    return [] if figure is None else [Plot(div_id, heading, figure)]


def _facts(comparison: "Comparison") -> list[tuple[str, str]]:
    finished = [row for row in comparison.rows if row["repeats"]]
    facts = [("methods", count_text(len(comparison.rows))), ("seed", str(comparison.seed))]
    odometry = comparison.mission.time_s
    facts.append(("mission time", seconds_text(float(odometry[-1] - odometry[0]))))
    origins_s = {record["time_origin_s"] for record in comparison.records.values()} - {0.0}
    if origins_s:
        facts.append(("times count from", f"{min(origins_s):.3f} s"))
    if finished:
        facts += [("steps", count_text(finished[0]["steps"])), ("observations", count_text(finished[0]["observations"]))]
        associations = dict.fromkeys(str(row["association"]) for row in finished)
        facts.append(("association", ", ".join(associations)))
        repeats = max(row["repeats"] for row in finished)
        if repeats > 1:
            facts.append(("times", f"median of {repeats} runs"))
    return facts
