"""ssjs-cli compare: one mission, several methods."""

from pathlib import Path

import click

from ssjs_cli.options import common_options
from ssjs_cli.session import Session
from ssjs_cli.study_options import time_limit_option


@click.command()
@click.argument("mission", type=click.Path())
@click.option("--methods", default="all", metavar="all|M,M,...", show_default=True, help="Which methods, in this order.")
@click.option("--association", default=None, metavar="METHOD", help="Data association of every run; default as the mission says.")
@click.option("--repeat", type=click.IntRange(1), default=1, show_default=True, help="Runs a method, taken in turn; times are medians.")
@time_limit_option
@click.option("--config", "config_path", type=click.Path(), default=None, help="TOML file with settings for every method.")
@click.option("--set", "assignments", multiple=True, metavar="KEY=VALUE", help="One setting by its full key; may be repeated.")
@common_options(out_help="Folder of the study (default runs/<mission>-comparison).")
@click.pass_obj
def compare(
    session: Session,
    mission: str,
    methods: str,
    association: str | None,
    repeat: int,
    config_path: str | None,
    assignments: tuple[str, ...],
    time_limit_s: float | None,
    seed: int | None,
    force: bool,
    out: str | None,
) -> int:
    """Run the mission in the directory MISSION through several methods: time, accuracy, consistency, one table and one report.

    Runs follow each other, each in a process of its own. An interrupted comparison goes on where it stopped with the same command.
    """
    from ssjs_cli.studies.comparison import ComparisonRequest
    from ssjs_cli.studies.comparison import compare as compare_methods
    from ssjs_cli.studies.comparison_text import answer_comparison

    request = ComparisonRequest(
        Path(mission),
        methods,
        repeats=repeat,
        association=association,
        config_path=None if config_path is None else Path(config_path),
        assignments=assignments,
        seed=seed,
        out=None if out is None else Path(out),
        force=force,
        time_limit_s=time_limit_s,
    )
    return answer_comparison(compare_methods(request, session), session)
