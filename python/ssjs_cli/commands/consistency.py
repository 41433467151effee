"""ssjs-cli consistency: one scenario under many seeds."""

from typing import Any

import click

from ssjs_cli.options import common_options
from ssjs_cli.session import Session
from ssjs_cli.study_options import request_of, study_options


@click.command()
@click.argument("scenario")
@click.option("--runs", type=click.IntRange(1), required=True, help="How many seeds, from --seed on.")
@click.option("--methods", default=None, metavar="all|M,M,...", help="Which methods (default: that of `run`).")
@study_options
@common_options(out_help="Folder of the study (default runs/<scenario>-consistency).")
@click.pass_obj
def consistency(session: Session, /, **options: Any) -> int:
    """Simulate and run SCENARIO (a built-in name or a TOML file) under many seeds: NEES and NIS with the bands they should keep.

    Every finished run is kept: an interrupted study goes on where it stopped with the same command.
    """
    request = request_of(**options)
    from ssjs_cli.studies.monte_carlo import study_consistency
    from ssjs_cli.studies.study_text import answer_consistency

    return answer_consistency(study_consistency(request, session), session)
