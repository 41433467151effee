"""The evaluation of a run that finished earlier."""

from pathlib import Path

from ssjs_cli.errors import UserError, nearest_hint
from ssjs_cli.evaluation import UNUSABLE_REFERENCE, evaluate, require_reference, with_alignment
from ssjs_cli.exit_codes import DONE
from ssjs_cli.formats.mission import (
    ALIGNMENTS,
    LANDMARKS_FILE,
    MISSION_FILE,
    Reference,
    ReferenceDescription,
    mission_directory,
    read_fixes,
    read_mission_document,
    read_reference,
)
from ssjs_cli.formats.mission_link import linked_mission
from ssjs_cli.formats.number_table import read_header
from ssjs_cli.formats.run_directory import (
    REPORT_FILE,
    SUMMARY_FILE,
    read_estimate,
    read_json,
    replace_json,
    run_directory,
)
from ssjs_cli.formats.tum import read_tum
from ssjs_cli.mission_run import FinishedRun
from ssjs_cli.run_summary import build_run_report, summary_text
from ssjs_cli.session import Session


def evaluate_run(
    session: Session, path: Path, *, truth: Path | None, alignment: str | None, with_report: bool, out: Path | None, force: bool
) -> int:
    directory = run_directory(path)
    if alignment is not None and alignment not in ALIGNMENTS:
        raise UserError(f"--align {alignment}: must be one of {', '.join(ALIGNMENTS)}{nearest_hint(alignment, ALIGNMENTS)}")
    if out is not None and out.exists() and not force:
        raise UserError(f"{out}: exists already; choose another --out, or replace it with --force")
    reference = with_alignment(find_reference(directory, truth), alignment)
    evaluation = evaluate(read_estimate(directory), reference)
    if evaluation.lost:
        raise UserError(f"{directory}: {'; '.join(evaluation.lost)}")
    summary = read_json(directory / SUMMARY_FILE)
    summary.update(evaluation.summary)
    # An earlier evaluation may have had no usable reference; losses of the run itself stay.
    summary["lost"] = [text for text in summary.get("lost", []) if not text.startswith(UNUSABLE_REFERENCE)]
    target = out if out is not None else directory
    target.mkdir(parents=True, exist_ok=True)
    evaluation.write(target)
    replace_json(target / SUMMARY_FILE, summary)
    has_report = out is None and with_report and (directory / REPORT_FILE).is_file()
    if has_report:
        build_run_report(directory)
    session.answer(summary, summary_text(FinishedRun(target, summary), with_report=has_report))
    return DONE


def find_reference(directory: Path, truth: Path | None) -> Reference:
    """The given one, or that of the mission which was run."""
    if truth is None:
        mission = linked_mission(directory, "give --truth FILE or the mission directory as --truth")
        return require_reference(_mission_reference(mission), str(mission))
    if not truth.exists():
        raise UserError(f"{truth}: is missing; check the path")
    if truth.is_dir() or truth.name == MISSION_FILE:
        return require_reference(_mission_reference(mission_directory(truth)), str(truth))
    return _reference_of_file(truth, directory)


def _mission_reference(mission: Path) -> Reference:
    return read_reference(mission, read_mission_document(mission / MISSION_FILE).reference)


def _reference_of_file(truth: Path, directory: Path) -> Reference:
    """A reference of its own; lever arm and outlier limit still come from the mission, where it can be found."""
    try:
        description = read_mission_document(linked_mission(directory, "") / MISSION_FILE).reference
    except UserError:
        description = ReferenceDescription(alignment="se2")
    if truth.name == LANDMARKS_FILE:
        raise UserError(f"{truth}: holds landmarks and no trajectory; give the mission directory as --truth")
    header = read_header(truth)
    if "time_s" in header:
        return Reference(description, fixes=read_fixes(truth))
    return Reference(description, truth=read_tum(truth))
