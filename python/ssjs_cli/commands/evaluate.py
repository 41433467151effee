"""ssjs-cli evaluate: a finished run against a reference."""

from pathlib import Path

import click

from ssjs_cli.options import common_options
from ssjs_cli.session import Session


@click.command()
@click.argument("run_dir", type=click.Path())
@click.option(
    "--truth",
    type=click.Path(),
    default=None,
    help="A .tum trajectory, fixes (time_s,x_m,y_m[,sigma_m]) or a mission directory (default: the run's mission).",
)
@click.option(
    "--align",
    default=None,
    metavar="none|origin|yaw|se2",
    help="How the estimate is laid onto the reference (default: as the mission says).",
)
@click.option("--no-report", is_flag=True, help="Leave report.html as it is.")
@common_options(out_help="Write the evaluation here instead of into RUN_DIR.")
@click.pass_obj
def evaluate(
    session: Session, run_dir: str, truth: str | None, align: str | None, no_report: bool, seed: int | None, force: bool, out: str | None
) -> int:
    """Errors of the run in RUN_DIR against a reference; updates its summary, error tables and report."""
    from ssjs_cli.run_evaluation import evaluate_run

    return evaluate_run(
        session,
        Path(run_dir),
        truth=None if truth is None else Path(truth),
        alignment=align,
        with_report=not no_report,
        out=None if out is None else Path(out),
        force=force,
    )
