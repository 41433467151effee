"""ssjs-cli simulate: a mission with truth."""

from pathlib import Path

import click

from ssjs_cli.options import common_options
from ssjs_cli.session import Session


@click.command()
@click.argument("scenario")
@click.option("--set", "assignments", multiple=True, metavar="KEY=VALUE", help="Of aekf-loop-images: a setting of its pictures.")
@common_options(out_help="Mission directory (default missions/<scenario>).")
@click.pass_obj
def simulate(session: Session, scenario: str, assignments: tuple[str, ...], seed: int | None, force: bool, out: str | None) -> int:
    """Simulate SCENARIO: a built-in name such as grid-survey, or a TOML file (docs/scenarios.md).

    `ssjs-cli config dump --of pictures` shows every setting of the pictures of aekf-loop-images.
    """
    from ssjs_cli.mission_output import answer_mission, write_new_mission
    from ssjs_cli.mission_run import path_name
    from ssjs_cli.simulation import read_scenario, simulate_mission

    chosen = read_scenario(scenario, seed, assignments)
    directory = Path(out) if out is not None else Path("missions") / path_name(chosen.name)
    mission = write_new_mission(directory, lambda: simulate_mission(chosen), force=force, session=session)
    return answer_mission(directory, mission, session)
