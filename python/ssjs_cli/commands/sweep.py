"""ssjs-cli sweep: the two tuning values of submap joining."""

from typing import Any

import click

from ssjs_cli.options import common_options
from ssjs_cli.session import Session
from ssjs_cli.study_options import request_of, study_options


@click.command()
@click.argument("scenario")
@click.option("--submap-size", "sizes", required=True, metavar="N,N,...", help="Values of submap.max_landmarks.")
@click.option("--fusion-threshold", "thresholds", required=True, metavar="F,F,...", help="Values of joining.fusion_threshold.")
@click.option("--runs", type=click.IntRange(1), default=1, show_default=True, help="Seeds for every pair of values, from --seed on.")
@click.option("--methods", default=None, metavar="all|M,M,...", help="Which methods (default: that of `run`).")
@study_options
@common_options(out_help="Folder of the study (default runs/<scenario>-sweep).")
@click.pass_obj
def sweep(session: Session, /, sizes: str, thresholds: str, **options: Any) -> int:
    """Cost and accuracy on SCENARIO (a built-in name or a TOML file) for every pair of submap size and fusion threshold.

    Times are taken while --jobs runs stand side by side; for times to compare with others give --jobs 1.
    """
    request = request_of(**options)
    from ssjs_cli.studies.study_text import answer_sweep
    from ssjs_cli.studies.sweep import SIZE_KEY, THRESHOLD_KEY, listed_values
    from ssjs_cli.studies.sweep import sweep as sweep_values

    size_values = listed_values("--submap-size", SIZE_KEY, sizes)
    threshold_values = listed_values("--fusion-threshold", THRESHOLD_KEY, thresholds)
    return answer_sweep(sweep_values(request, size_values, threshold_values, session), session)
