"""From the files of a run to the text of the page. Nothing here reads the clock, the network or a path into the page."""

from typing import Any

from ssjs_cli.report.consistency_figures import Consistency, consistency
from ssjs_cli.report.error_figures import axis_errors, position_error
from ssjs_cli.report.frame_section import frame_section
from ssjs_cli.report.geographic_axes import add_geographic_axes
from ssjs_cli.report.headline import cards, number_groups, time_shares
from ssjs_cli.report.landmark_cards import landmark_sheet
from ssjs_cli.report.map_figure import MapAxes, SubmapColours, draw_map
from ssjs_cli.report.number_text import count_text, finite_number, percent_text, plain_text, seconds_text
from ssjs_cli.report.page_parts import Plot, render
from ssjs_cli.report.replay import replay_data, timeline_spans
from ssjs_cli.report.result_files import Columns, RunFiles
from ssjs_cli.report.step_time_figures import step_times
from ssjs_cli.report.survey_cards import survey_cards
from ssjs_cli.report.survey_sections import survey_sections
from ssjs_cli.report.tables import LOOP_COLUMNS, configuration_sections, loop_rows, submap_columns, submap_rows

FIGURE_IDS = ("map", "position-error", "axis-errors", "nees", "nis", "step-time-histogram", "step-time")


def render_page(files: RunFiles) -> str:
    summary = files.summary
    axes = MapAxes.from_summary(summary)
    colours = SubmapColours.from_files(files)
    drawing = draw_map(files, axes, colours)
    map_plot = Plot("map", "Map")
    if drawing is None:
        map_plot.missing = "landmarks.csv and trajectory.tum are missing or empty, so there is no map to draw."
    else:
        map_plot.figure, map_plot.notes = drawing.figure, drawing.notes
        add_geographic_axes(drawing.figure, summary, axes)
    replay = replay_data(files, axes, colours) if drawing is not None else None
    plots = [map_plot, *_error_plots(files, axes), *_consistency_plots(files)]
    step_histogram, step_over_time, step_quantiles = _step_time_plots(files)
    plots += [step_histogram, step_over_time]
    survey = survey_sections(files, axes, colours)
    by_id = {plot.div_id: plot for plot in plots}
    duration_s = _duration_s(files)
    loops, loops_note = loop_rows(files.submaps, axes) if files.submaps is not None else ([], "")
    return render(
        "report.html.j2",
        {
            "figures": {plot.div_id: plot.figure for plot in [*plots, *(survey.plots if survey else [])] if plot.figure is not None},
            "layers": {layer.key: layer.traces for layer in drawing.layers} if drawing is not None else {},
            "replay": replay,
        },
        ("sorted_tables.js", "plots.js", "report.js"),
        styles=("report.css", "survey.css"),
        title=_mission_name(files),
        subtitle=_text(summary, "description"),
        facts=_facts(files, duration_s),
        cards=[*survey_cards(files, duration_s), *cards(summary, duration_s, files.timing)],
        groups=number_groups(summary),
        plots=by_id,
        survey=survey,
        frames=frame_section(files.pictures),
        landmarks=landmark_sheet(files, axes),
        layers=drawing.layers if drawing is not None else [],
        map_missing=_missing_on_map(files),
        replay=replay is not None,
        estimates=replay["estimates"] if replay is not None else [],
        moments=len(replay["time_s"]) if replay is not None else 0,
        moments_text=count_text(len(replay["time_s"])) if replay is not None else "",
        steps_text=count_text(len(files.trajectory.time_s)) if files.trajectory is not None else "",
        timeline=timeline_spans(files, colours) if replay is not None else None,
        time_shares=time_shares(summary),
        step_quantiles=step_quantiles,
        timing=_timing_entries(files.timing),
        submap_columns=submap_columns(axes),
        submap_rows=submap_rows(files.submaps, axes, colours) if files.submaps is not None else [],
        submaps_known=files.submaps is not None,
        loop_columns=LOOP_COLUMNS,
        loop_rows=loops,
        loops_note=loops_note,
        configuration=configuration_sections(files.config) if files.config is not None else [],
        provenance=_provenance(summary),
    )


def _text(table: dict[str, Any], key: str) -> str:
    value = table.get(key)
    return value if isinstance(value, str) else ""


def _mission_name(files: RunFiles) -> str:
    mission = files.summary.get("mission")
    if isinstance(mission, dict):
        mission = mission.get("name")
    if not mission and files.config is not None and isinstance(files.config.get("mission"), dict):
        mission = files.config["mission"].get("name")
    return str(mission) if mission else "Mission"


def _duration_s(files: RunFiles) -> float | None:
    track = files.trajectory if files.trajectory is not None else files.online
    return float(track.time_s[-1] - track.time_s[0]) if track is not None and len(track.time_s) > 1 else None


def _facts(files: RunFiles, duration_s: float | None) -> list[tuple[str, str]]:
    summary = files.summary
    facts = [(key, str(summary[key])) for key in ("method", "association", "version", "seed") if summary.get(key) is not None]
    if duration_s:
        facts.append(("mission time", seconds_text(duration_s)))
    if files.time_origin_s:
        facts.append(("times count from", f"{files.time_origin_s:.3f} s"))
    return facts


def _missing_on_map(files: RunFiles) -> list[str]:
    """What the map could have shown, and the file it would have come from."""
    return [
        text
        for absent, text in (
            (files.trajectory is None, "final track (trajectory.tum)"),
            (files.online is None, "online track (trajectory_online.tum)"),
            (files.dead_reckoning is None, "dead reckoning (dead_reckoning.tum)"),
            (files.landmarks is None, "landmarks (landmarks.csv)"),
            (files.submaps is None, "submaps and loop closures (submaps.json)"),
            (files.reference is None, "reference (reference.csv)"),
        )
        if absent
    ]


def _error_plots(files: RunFiles, axes: MapAxes) -> list[Plot]:
    total = Plot("position-error", "Position error over time")
    by_axis = Plot("axis-errors", "Error along each axis")
    if files.errors is None:
        total.missing = "errors.csv is missing: this mission has no reference to compare with, so there is no error to draw."
        return [total, by_axis]
    drawn = position_error(files.errors, files.errors_online)
    if drawn is None:
        total.missing = "errors.csv holds fewer than two usable rows: the reference and the track do not overlap in time."
        return [total, by_axis]
    total.figure, total.notes = drawn.figure, drawn.notes
    if files.errors_online is None:
        total.notes.append("errors_online.csv is missing: only the final estimate is drawn.")
    signed = axis_errors(files.errors, axes.names)
    if signed is None:
        by_axis.missing = "errors.csv states no standard deviation, so the error cannot be set against it."
    else:
        by_axis.figure, by_axis.notes = signed.figure, signed.notes
    return [total, by_axis]


def _consistency_plots(files: RunFiles) -> list[Plot]:
    return [
        _consistency_plot(
            "nees", "NEES of the vehicle pose", files.nees,
            "nees.csv is missing: NEES needs the true trajectory at every step, which this mission does not have.",
        ),
        _consistency_plot("nis", _nis_heading(files), files.nis, "consistency.csv is missing, so there is no NIS to draw."),
    ]  # fmt: skip


def _nis_heading(files: RunFiles) -> str:
    """Under water one update holds the samples of every sensor at its time."""
    if files.summary.get("sensors"):
        return "NIS of the updates, all sensors together"
    return "NIS of the scan updates" if files.pictures is None else "NIS of the frames"


def _consistency_plot(quantity: str, heading: str, table: Columns | None, missing: str) -> Plot:
    plot = Plot(quantity, heading)
    answer: Consistency | None = consistency(table, quantity) if table is not None else None
    if answer is None:
        plot.missing = missing if table is None else f"The {quantity.upper()} file holds fewer than two usable rows."
        return plot
    plot.figure = answer.figure
    plot.notes = [
        f"{percent_text(answer.inside)} of {count_text(answer.count)} values lie inside their own 95 % band "
        f"({percent_text(answer.below)} below, {percent_text(answer.above)} above; 2.5 % each expected).",
        f"Mean per degree of freedom {answer.mean_per_dof:.3g} (1 expected; dof {answer.dof_text}).",
        "Right: percentile of each value under its own χ² distribution; level at the dashed line when the claimed covariance is true.",
        *answer.notes,
    ]
    return plot


def _step_time_plots(files: RunFiles) -> tuple[Plot, Plot, list[tuple[str, str]]]:
    histogram, over_time = Plot("step-time-histogram", "How long a step takes"), Plot("step-time", "Over the mission")
    if files.step_times is None:
        histogram.missing = "step_times.csv is missing, so the time of single steps is not known."
        return histogram, over_time, []
    answer = step_times(files.step_times)
    if answer is None:
        histogram.missing = "step_times.csv holds fewer than two usable rows."
        return histogram, over_time, []
    histogram.figure, over_time.figure, over_time.notes = answer.histogram, answer.over_time, answer.notes
    return histogram, over_time, answer.quantiles


def _timing_entries(timing: dict[str, Any] | None) -> list[tuple[str, str]]:
    if timing is None:
        return []
    entries = []
    parts = timing.get("parts")
    walls = {f"wall, {key}": value for key, value in parts.items()} if isinstance(parts, dict) else {}
    for key, value in [*timing.items(), *walls.items()]:
        number = finite_number(value)
        # the quantiles of the steps stand in this row already, from the steps themselves
        if number is None or key.startswith("step_time"):
            continue
        name, _, unit = key.rpartition("_")
        texts = {"s": seconds_text(number), "us": seconds_text(1e-6 * number), "mb": f"{number:,.0f} MB"}
        entries.append((name.replace("_", " "), texts[unit]) if name and unit in texts else (key, plain_text(number)))
    return entries


def _provenance(summary: dict[str, Any]) -> list[tuple[str, str]]:
    """Seed, version and digests: everything in the summary that says what went in."""
    entries: list[tuple[str, str]] = []
    for key in ("method", "association", "version", "seed"):
        if summary.get(key) is not None:
            entries.append((key, str(summary[key])))
    for key, value in summary.items():
        if "digest" not in key:
            continue
        if isinstance(value, dict):
            entries += [(f"{key}: {name}", str(digest)) for name, digest in value.items()]
        elif value is not None:
            entries.append((key, str(value)))
    return entries
