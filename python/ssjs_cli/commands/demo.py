"""ssjs-cli demo: the whole chain on the built-in mission."""

from pathlib import Path

import click

from ssjs_cli.options import common_options
from ssjs_cli.session import Session

SCENARIO = "grid-survey"


@click.command()
@click.option("--method", default=None, metavar="METHOD", help="Joining method; see `run`.")
@common_options(out_help="Run directory (default runs/<mission>-<method>); the mission goes to <out>-mission.")
@click.pass_obj
def demo(session: Session, method: str | None, seed: int | None, force: bool, out: str | None) -> int:
    """Simulate a survey of 441 landmarks over 2 km, run it and build its report."""
    from ssjs_cli.config import ASSOCIATION_KEY, METHOD_KEY, defaults, layer_from_flag, resolve
    from ssjs_cli.formats.atomic import check_replaceable
    from ssjs_cli.formats.run_directory import why_not_a_run
    from ssjs_cli.mission_output import write_new_mission
    from ssjs_cli.mission_run import RUN_KIND, RunRequest, default_out, run_mission
    from ssjs_cli.run_summary import finish_run
    from ssjs_cli.simulation import read_scenario, simulate_mission

    settings = resolve([layer_from_flag("--method", METHOD_KEY, method)])
    directory = Path(out) if out is not None else default_out(SCENARIO, settings.method)
    check_replaceable(directory, force=force, why_not_ours=why_not_a_run, kind=RUN_KIND)
    mission_path = directory.with_name(directory.name + "-mission")
    scenario = read_scenario(SCENARIO, seed)
    session.message(f"simulating {SCENARIO}, seed {scenario.seed}, in {mission_path}")
    write_new_mission(mission_path, lambda: simulate_mission(scenario), force=force, session=session)
    session.message(f"running it, association {defaults()[ASSOCIATION_KEY]} unless the scenario says otherwise")
    request = RunRequest(mission_path, out=directory, seed=scenario.seed, method=method, force=force)
    return finish_run(run_mission(request, session), session, with_report=True)
