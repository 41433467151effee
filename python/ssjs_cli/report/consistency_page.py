"""The report of a consistency study."""

from typing import TYPE_CHECKING, Any

from ssjs_cli.methods import known_methods
from ssjs_cli.report import figure_style as style
from ssjs_cli.report.comparison_figures import band_traces, nis_band, nis_per_dof
from ssjs_cli.report.figure_style import Figure, Trace
from ssjs_cli.report.method_colours import method_colours
from ssjs_cli.report.page_parts import Plot
from ssjs_cli.report.sheet import SheetColumn, sheet
from ssjs_cli.report.study_page import GATE_NOTE, Section, StudyPage, render_study, seeds_text

if TYPE_CHECKING:
    from ssjs_cli.studies.monte_carlo import ConsistencyStudy

METHOD_SHEET: tuple[SheetColumn, ...] = (
    ("method", "method", None, 1.0),
    ("runs", "runs", 0, 1.0),
    ("nees_mean", "NEES, 3 dof", 2, 1.0),
    ("nees_inside_fraction", "inside [%]", 1, 100.0),
    ("nees_online_mean", "online", 2, 1.0),
    ("nees_online_inside_fraction", "inside [%]", 1, 100.0),
    ("nees_joint_per_dof", "bases jointly / dof", 3, 1.0),
    ("nees_joint_band_low", "band from", 3, 1.0),
    ("nees_joint_band_high", "to", 3, 1.0),
    ("nees_map_mean", "landmarks, 2 dof", 2, 1.0),
    ("nees_position_per_dof", "position / dof", 2, 1.0),
    ("inside_3_sigma_fraction", "within 3 σ [%]", 1, 100.0),
    ("nis_mean", "NIS / dof", 4, 1.0),
    ("nis_band_low", "band from", 4, 1.0),
    ("nis_band_high", "to", 4, 1.0),
    ("trajectory_rmse_m", "RMSE [m]", 3, 1.0),
    ("map_error_mean_m", "map error [m]", 3, 1.0),
    ("wrong_pairs", "wrong pairs", 2, 1.0),
)
RUN_SHEET: tuple[SheetColumn, ...] = (
    ("method", "method", None, 1.0),
    ("seed", "seed", 0, 1.0),
    ("nees_mean", "NEES, 3 dof", 2, 1.0),
    ("nees_inside_fraction", "inside [%]", 1, 100.0),
    ("nees_joint_per_dof", "bases jointly / dof", 3, 1.0),
    ("nees_map_mean", "landmarks, 2 dof", 2, 1.0),
    ("nees_position_per_dof", "position / dof", 2, 1.0),
    ("inside_3_sigma_fraction", "within 3 σ [%]", 1, 100.0),
    ("nis_mean", "NIS / dof", 4, 1.0),
    ("trajectory_rmse_m", "RMSE [m]", 3, 1.0),
    ("trajectory_max_m", "max [m]", 3, 1.0),
    ("map_error_mean_m", "map mean [m]", 3, 1.0),
    ("map_error_max_m", "max [m]", 3, 1.0),
    ("landmarks_false", "false landmarks", 0, 1.0),
    ("loop_closures", "closures", 0, 1.0),
    ("wrong_pairs", "wrong pairs", 0, 1.0),
    ("reason", "failed because", None, 1.0),
)

EXPECTED_JOINT = {
    "type": "line", "xref": "paper", "x0": 0, "x1": 1, "y0": 1, "y1": 1, "line": {"color": style.BAND, "width": 1.4, "dash": "dash"},
}  # fmt: skip


def consistency_page(study: "ConsistencyStudy") -> str:
    methods = [row["method"] for row in study.rows]
    colours = method_colours(methods, known_methods())
    count = len(study.seeds)
    runs = "run" if count == 1 else "runs"
    joint = "Dashed: expected. In the mean of the table each run counts with the degrees of freedom of its bases."
    plots = [
        _plot("nees", f"Mean NEES of the vehicle pose over {count} {runs}, final trajectory", _nees(study, colours, "nees_mean")),
        _plot("nees-online", f"Mean NEES of the vehicle pose over {count} {runs}, online", _nees(study, colours, "nees_online_mean")),
        _plot("joint", "Joint NEES of all bases per degree of freedom, run by run", _by_run(study, colours, "nees_joint_per_dof"), joint),
        _plot("nis", "NIS of the scan updates, all runs together", _nis(study, colours), GATE_NOTE),
        _plot("rmse", "Trajectory RMSE, run by run", _by_run(study, colours, "trajectory_rmse_m")),
    ]
    failures = [(row["method"], row["reason"]) for row in study.rows if row["reason"]]
    note = (
        "Inside: share of the instants at which the mean over the runs lies in its 95 % band; 95 % expected of a method that knows its own "
        "error, though neighbouring instants share theirs. Expected values: NEES 3, jointly 1, landmarks 2, NIS per degree of freedom 1."
    )
    swatches = [colours[method] for method in methods]
    page = StudyPage(
        kind="consistency study",
        title=study.scenario.name,
        subtitle=study.scenario.description,
        facts=[("runs a method", str(count)), ("seeds", seeds_text(study.seeds)), *_bands(study)],
        sheets=[sheet("methods", "Methods", METHOD_SHEET, study.rows, colours=swatches, note=note)],
        sections=[
            Section("nees-section", "NEES", plots[:2]),
            Section("joint-section", "Bases jointly", plots[2:3]),
            Section("nis-section", "NIS", plots[3:4]),
            Section("error-section", "Error", plots[4:]),
        ],
        failures=failures,
    )
    page.sheets.append(sheet("runs", "Run by run", RUN_SHEET, study.runs, colours=[colours[row["method"]] for row in study.runs]))
    return render_study(page)


def _bands(study: "ConsistencyStudy") -> list[tuple[str, str]]:
    for row in study.rows:
        if row["nees_band_low"] is not None:
            return [("95 % band of the mean NEES", f"{row['nees_band_low']:.2f} to {row['nees_band_high']:.2f}")]
    return []


def _plot(div_id: str, heading: str, figure: Figure | None, note: str = "") -> Plot:
    if figure is None:
        return Plot(div_id, heading, missing="No run of this study has the numbers for this figure.")
    return Plot(div_id, heading, figure, [note] if note else [])


def _nees(study: "ConsistencyStudy", colours: dict[str, str], key: str) -> Figure | None:
    rows = study.over_time
    if not rows:
        return None
    first = [row for row in rows if row["method"] == rows[0]["method"]]
    ends = [first[0]["time_s"], first[-1]["time_s"]]
    low, high = rows[0]["band_low"], rows[0]["band_high"]
    traces = band_traces(ends, [low, low], [high, high])
    largest = high
    for method in dict.fromkeys(row["method"] for row in rows):
        chosen = [row for row in rows if row["method"] == method and row[key] is not None]
        if not chosen:
            continue
        largest = max(largest, *(row[key] for row in chosen))
        values = [round(row[key], 4) for row in chosen]
        hover = f"{method}: mean NEES %{{y:.2f}} at %{{x:.0f}} s<extra></extra>"
        traces.append(style.line([row["time_s"] for row in chosen], values, method, colours[method], 1.5, hovertemplate=hover))
    scale: dict[str, Any] = {"type": "log", "dtick": 1} if largest > 20.0 * high else {"range": [0.0, round(1.08 * largest, 3)]}
    return {
        "data": traces,
        "layout": style.layout(340, xaxis=style.axis("mission time [s]", range=ends), yaxis=style.axis("mean NEES, 3 dof [-]", **scale)),
    }


def _by_run(study: "ConsistencyStudy", colours: dict[str, str], key: str) -> Figure | None:
    traces: list[Trace] = []
    for method in dict.fromkeys(row["method"] for row in study.runs):
        chosen = [row for row in study.runs if row["method"] == method and row[key] is not None]
        if chosen:
            traces.append({
                "type": "scatter", "mode": "markers", "name": method, "x": [str(row["seed"]) for row in chosen],
                "y": [row[key] for row in chosen], "marker": {"color": colours[method], "size": 7},
                "hovertemplate": f"{method}: %{{y:.3f}}, seed %{{x}}<extra></extra>",
            })  # fmt: skip
    if not traces:
        return None
    title = {"nees_joint_per_dof": "NEES / dof [-]", "trajectory_rmse_m": "RMSE [m]"}[key]
    expected = [EXPECTED_JOINT] if key == "nees_joint_per_dof" else []
    return {
        "data": traces,
        "layout": style.layout(
            300, showlegend=True, shapes=expected, xaxis=style.axis("seed", type="category"), yaxis=style.axis(title, rangemode="tozero")
        ),
    }


def _nis(study: "ConsistencyStudy", colours: dict[str, str]) -> Figure | None:
    known = {method: curve for method, curve in study.nis.items() if curve}
    if not known:
        return None
    most = max(known.values(), key=lambda curve: sum(curve["dof"]))
    traces = nis_band(most)
    for method, curve in known.items():
        hover = f"{method}: NIS / dof %{{y:.3f}} near %{{x:.0f}} s<extra></extra>"
        traces.append(style.line(list(curve["time_s"]), nis_per_dof(curve), method, colours[method], 1.5, hovertemplate=hover))
    ends = [most["time_s"][0], most["time_s"][-1]]
    return {
        "data": traces,
        "layout": style.layout(320, xaxis=style.axis("mission time [s]", range=ends), yaxis=style.axis("NIS / dof [-]")),
    }
