"""What a finished run says to the user."""

from pathlib import Path
from typing import Any

from ssjs_cli.errors import UserError
from ssjs_cli.exit_codes import DONE, PARTLY_DONE
from ssjs_cli.formats.run_directory import REPORT_FILE
from ssjs_cli.mission_run import FinishedRun
from ssjs_cli.progress import working
from ssjs_cli.session import Session


def build_run_report(directory: Path) -> Path:
    """The report of a run directory; a result file that cannot be read is the user's to mend."""
    from ssjs_cli.report import build_report

    try:
        with working("building the report"):
            return build_report(directory)
    except ValueError as error:
        if type(error).__module__.startswith("ssjs_cli.report"):
            raise UserError(f"{directory}: {error}") from error
        raise


def finish_run(finished: FinishedRun, session: Session, *, with_report: bool) -> int:
    """Builds the report, prints the answer, and gives the exit code."""
    if with_report:
        build_run_report(finished.directory)
    for text in finished.lost:
        session.message(f"lost: {text}")
    document: dict[str, Any] = {**finished.summary, "run_directory": str(finished.directory)}
    if with_report:
        document["report"] = str(finished.directory / REPORT_FILE)
    session.answer(document, summary_text(finished, with_report=with_report))
    return PARTLY_DONE if finished.lost else DONE


def summary_text(finished: FinishedRun, *, with_report: bool) -> str:
    summary = finished.summary
    lines = [
        ("mission", f"{summary['mission']}, method {summary['method']}, association {summary['association']}, seed {summary['seed']}"),
        ("input", _joined([(summary["steps"], "steps"), (summary["observations"], "observations")])),
        ("map", _joined([(summary[key], key.replace("_", " ")) for key in ("landmarks", "submaps", "fusions", "loop_closures")])),
        ("time", _time_text(summary)),
        ("smoothing", _smoothing_text(summary)),
        ("trajectory", _trajectory_text(summary)),
        ("map error", _map_text(summary)),
        ("frames", _frames_text(summary)),
        ("contacts", _contacts_text(summary)),
        ("consistency", _consistency_text(summary)),
        ("results", str(finished.directory)),
        ("report", str(finished.directory / REPORT_FILE) if with_report else None),
    ]
    return "\n".join(f"{label:<12}{text}" for label, text in lines if text)


def _joined(parts: list[tuple[Any, str]]) -> str:
    return ", ".join(f"{value} {name}" for value, name in parts if value is not None)


def _time_text(summary: dict[str, Any]) -> str | None:
    if summary["time_total_s"] is None:
        return None
    text = f"{summary['time_total_s']:.2f} s"
    if summary["step_time_p99_us"] is not None:
        text += f", step 50 % {summary['step_time_p50_us']:.0f} us, 99 % {summary['step_time_p99_us']:.0f} us"
    return text


def _smoothing_text(summary: dict[str, Any]) -> str | None:
    if summary["half_chi2_final"] is None:
        return None
    text = f"half chi2 {summary['half_chi2_initial']:.1f} -> {summary['half_chi2_final']:.1f}"
    text += f", {summary['smoothing_iterations']} iterations over {summary['smoothing_poses']} poses in {summary['time_smoothing_s']:.2f} s"
    if summary["smoothing_doubted"]:
        text += f", {summary['smoothing_doubted']} of {summary['smoothing_sightings']} sightings doubted"
    return text


def _trajectory_text(summary: dict[str, Any]) -> str | None:
    if summary["trajectory_rmse_m"] is None:
        return None
    text = f"RMSE {summary['trajectory_rmse_m']:.3f} m, max {summary['trajectory_max_m']:.3f} m (alignment {summary['alignment']}"
    if summary["reference_outliers"]:
        text += f", {summary['reference_outliers']} of {summary['reference_compared']} fixes rejected"
    text += ")"
    if summary["dead_reckoning_rmse_m"] is not None:
        text += f"; dead reckoning {summary['dead_reckoning_rmse_m']:.3f} m"
        if summary["trajectory_rmse_m"] > 0.0:
            text += f", {summary['dead_reckoning_rmse_m'] / summary['trajectory_rmse_m']:.1f} times as much"
    return text


def _map_text(summary: dict[str, Any]) -> str | None:
    if summary["map_error_mean_m"] is None:
        return None
    return (
        f"mean {summary['map_error_mean_m']:.3f} m, max {summary['map_error_max_m']:.3f} m, "
        f"{summary['landmarks_missed']} missed, {summary['landmarks_false']} false"
    )


def _frames_text(summary: dict[str, Any]) -> str | None:
    if summary.get("frames_used") is None:
        return None
    text = f"{summary['frames_used']} of {summary['frames']} used, {summary['frames_with_region']} with a region"
    left_out = summary.get("frames_left_out")
    if isinstance(left_out, dict) and left_out:
        text += "; left out: " + ", ".join(f"{count} {kind}" for kind, count in left_out.items())
    if summary.get("landmark_error_rms_m") is not None:
        text += f"; landmarks {summary['landmark_error_rms_m']:.3f} m RMS from what they were seen at"
    return text


def _contacts_text(summary: dict[str, Any]) -> str | None:
    if summary.get("contacts_found") is None:
        return None
    text = f"{summary['contacts_found']} of {summary['objects']} objects found, "
    text += f"{summary['contacts_false']} of {summary['contacts']} contacts false"
    if summary["contacts_duplicate"]:
        text += f" ({summary['contacts_duplicate']} of them a second one of an object)"
    if summary["contact_position_rms_m"] is not None:
        text += f", position RMS {summary['contact_position_rms_m']:.3f} m"
    return text


def _consistency_text(summary: dict[str, Any]) -> str | None:
    parts = []
    if summary["nis_mean"] is not None:
        parts.append(f"NIS per degree of freedom {summary['nis_mean']:.3f}")
    if summary["nees_mean"] is not None:
        parts.append(f"pose NEES {summary['nees_mean']:.2f} of {summary['nees_dof']}")
    if summary.get("inside_3_sigma_fraction") is not None:
        parts.append(f"{100.0 * summary['inside_3_sigma_fraction']:.1f} % of the time inside 3 sigma")
    return ", ".join(parts) or None
