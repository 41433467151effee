"""ssjs-cli batch: a season of missions."""

from pathlib import Path

import click

from ssjs_cli.options import common_options, path_of, settings_options
from ssjs_cli.session import Session


@click.command()
@click.argument("missions", nargs=-1, required=True, type=click.Path())
@click.option("--method", default=None, metavar="METHOD", help="Joining method of every run.")
@click.option("--association", default=None, metavar="METHOD", help="Data association of every run.")
@settings_options
@click.option("--jobs", "workers", type=click.IntRange(1), default=None, help="Worker processes here (default: one a core).")
@click.option("--scheduler", default=None, metavar="ADDR", help="Dask scheduler, such as tcp://host:8786, instead of workers here.")
@click.option("--resume", is_flag=True, help="Go on with the batch in --out; an error where there is none.")
@click.option("--no-report", is_flag=True, help="Leave out the report.html of each run.")
@common_options(out_help="Folder of the batch (default runs/batch).")
@click.pass_obj
def batch(
    session: Session,
    missions: tuple[str, ...],
    method: str | None,
    association: str | None,
    config_path: str | None,
    assignments: tuple[str, ...],
    workers: int | None,
    scheduler: str | None,
    resume: bool,
    no_report: bool,
    seed: int | None,
    force: bool,
    out: str | None,
) -> int:
    """Run every mission directory in MISSIONS as `run` does; one that fails does not hold up the others.

    Finished missions are kept: the same command, with more missions or after a break, does the rest.
    """
    from ssjs_cli.studies.batch import run_batch
    from ssjs_cli.studies.batch_plan import BatchRequest
    from ssjs_cli.studies.batch_text import answer_batch
    from ssjs_cli.studies.scenario_runs import executor_of

    request = BatchRequest(
        list(dict.fromkeys(Path(mission) for mission in missions)),
        executor_of(workers, scheduler),
        method=method,
        association=association,
        config_path=path_of(config_path),
        assignments=assignments,
        seed=seed,
        out=path_of(out),
        force=force,
        resume=resume,
        with_reports=not no_report,
    )
    return answer_batch(run_batch(request, session), session)
