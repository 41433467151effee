"""The options that the studies of a scenario share, and the request made of them."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from ssjs_cli.studies.scenario_runs import StudyRequest


time_limit_option = click.option(
    "--time-limit-s",
    type=click.FloatRange(0.0, min_open=True),
    default=None,
    metavar="SECONDS",
    help="Wall time after which a run is ended and its row says so (default: none).",
)


def study_options(command: Callable[..., Any]) -> Callable[..., Any]:
    for option in (
        time_limit_option,
        click.option("--scheduler", default=None, metavar="ADDR", help="Dask scheduler, such as tcp://host:8786, instead of workers here."),
        click.option("--jobs", "workers", type=click.IntRange(1), default=None, help="Worker processes here (default: one a core)."),
        click.option("--set", "assignments", multiple=True, metavar="KEY=VALUE", help="One setting by its full key; may be repeated."),
        click.option("--config", "config_path", type=click.Path(), default=None, help="TOML file with settings."),
        click.option("--association", default=None, metavar="METHOD", help="Data association; default as the scenario says."),
    ):
        command = option(command)
    return command


def request_of(
    *,
    scenario: str,
    methods: str | None,
    seed: int | None,
    config_path: str | None,
    out: str | None,
    workers: int | None,
    scheduler: str | None,
    **rest: Any,
) -> "StudyRequest":
    from ssjs_cli.errors import UserError
    from ssjs_cli.methods import chosen_methods
    from ssjs_cli.simulation import read_scenario
    from ssjs_cli.studies.scenario_runs import StudyRequest

    if workers is not None and scheduler is not None:
        raise UserError("--jobs and --scheduler: the workers of a scheduler are counted there; give one of the two")
    return StudyRequest(
        scenario,
        methods=chosen_methods(methods, read_scenario(scenario, seed).kind),
        seed=seed,
        config_path=None if config_path is None else Path(config_path),
        out=None if out is None else Path(out),
        workers=workers,
        scheduler=scheduler,
        **rest,
    )
