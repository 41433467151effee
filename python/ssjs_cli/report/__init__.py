"""The report of a run: one self-contained page, built from the files of the run directory and nothing else."""

from pathlib import Path

from ssjs_cli.formats.atomic import write_file
from ssjs_cli.report.page import render_page
from ssjs_cli.report.result_files import read_run_files

__all__ = ["build_report"]


def build_report(run_dir: Path) -> Path:
    """Reads the result files in run_dir and writes run_dir/report.html, which replaces an older one only when it is complete.

    Needs summary.json; whatever else is missing, the page says so. The same files give the same bytes. Throws UserError.
    """
    report = run_dir / "report.html"
    write_file(report, render_page(read_run_files(run_dir)).encode("utf-8", errors="replace"))
    return report
