"""ssjs-cli run: the main job."""

from pathlib import Path
from typing import Any

import click

from ssjs_cli.options import common_options
from ssjs_cli.session import Session


@click.command()
@click.argument("mission", type=click.Path())
@click.option("--method", default=None, metavar="METHOD", help="Joining method, short for --set method=...")
@click.option("--association", default=None, metavar="METHOD", help="Data association; short for --set association.method=...")
@click.option("--calibrate", is_flag=True, help="First estimate mounting, steering and side slip without a reference.")
@click.option(
    "--smooth", is_flag=True, help="Afterwards least squares over every pose and landmark; short for --set smoothing.enabled=true."
)
@click.option("--config", "config_path", type=click.Path(), default=None, help="TOML file with settings, such as the config.toml of a run.")
@click.option("--set", "assignments", multiple=True, metavar="KEY=VALUE", help="One setting by its full key; may be repeated.")
@click.option("--no-report", is_flag=True, help="Leave out report.html.")
@common_options(out_help="Run directory (default runs/<mission>-<method>).")
@click.pass_obj
def run(session: Session, /, mission: str, out: str | None, config_path: str | None, no_report: bool, **options: Any) -> int:
    """Run the mission in the directory MISSION: corrected trajectory, map, consistency, and a report.

    Settings: defaults < mission.toml < --config < --set < --method, --association, --smooth. `ssjs-cli config dump` shows them all.
    """
    from ssjs_cli.mission_run import RunRequest, run_mission
    from ssjs_cli.run_summary import finish_run

    request = RunRequest(
        Path(mission),
        out=None if out is None else Path(out),
        config_path=None if config_path is None else Path(config_path),
        **options,
    )
    return finish_run(run_mission(request, session), session, with_report=not no_report)
