"""ssjs-cli demo: the whole chain on a built-in mission."""

from pathlib import Path

import click

from ssjs_cli.options import common_options
from ssjs_cli.session import Session

SCENARIO = "remus-survey"


@click.command()
@click.option("--scenario", default=SCENARIO, show_default=True, metavar="SCENARIO", help="What to simulate; see `simulate`.")
@click.option("--method", default=None, metavar="METHOD", help="Joining method; see `run`.")
@common_options(out_help="Run directory (default runs/<mission>-<method>); the mission goes to <out>-mission.")
@click.pass_obj
def demo(session: Session, scenario: str, method: str | None, seed: int | None, force: bool, out: str | None) -> int:
    """Simulate a survey, run it and build its report: sonar pings of an underwater vehicle in, contacts and corrected track out.

    `--scenario grid-survey` is one of a land vehicle, 441 landmarks over 2 km.
    """
    from ssjs_cli.config import METHOD_KEY, layer_from_flag, resolve
    from ssjs_cli.formats.atomic import check_replaceable
    from ssjs_cli.formats.run_directory import why_not_a_run
    from ssjs_cli.mission_output import write_new_mission
    from ssjs_cli.mission_run import RUN_KIND, RunRequest, default_out, run_mission
    from ssjs_cli.run_summary import finish_run
    from ssjs_cli.simulation import read_scenario, simulate_mission

    chosen = read_scenario(scenario, seed)
    settings = resolve([layer_from_flag("--method", METHOD_KEY, method, chosen.kind)], chosen.kind)
    directory = Path(out) if out is not None else default_out(chosen.name, settings.method)
    check_replaceable(directory, force=force, why_not_ours=why_not_a_run, kind=RUN_KIND)
    mission_path = directory.with_name(directory.name + "-mission")
    session.message(f"simulating {chosen.name}, seed {chosen.seed}, in {mission_path}")
    write_new_mission(mission_path, lambda: simulate_mission(chosen), force=force, session=session)
    session.message("running it")
    request = RunRequest(mission_path, out=directory, seed=chosen.seed, method=method, force=force)
    return finish_run(run_mission(request, session), session, with_report=True)
