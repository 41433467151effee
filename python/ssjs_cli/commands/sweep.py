"""ssjs-cli sweep: the two tuning values of submap joining."""

from typing import Any

import click

from ssjs_cli.options import common_options
from ssjs_cli.session import Session
from ssjs_cli.study_options import request_of, study_options


@click.command()
@click.argument("scenario")
@click.option(
    "--submap-size",
    "sizes",
    required=True,
    metavar="N,N,...",
    help="Values of submap.max_landmarks, or, under water, of split.max_distance_m.",
)
@click.option(
    "--fusion-threshold",
    "thresholds",
    default=None,
    metavar="F,F,...",
    help="Values of joining.fusion_threshold, or, under water, of fusing.fusion_threshold (default: the setting's).",
)
@click.option("--runs", type=click.IntRange(1), default=1, show_default=True, help="Seeds for every pair of values, from --seed on.")
@click.option("--methods", default=None, metavar="all|M,M,...", help="Which methods (default: that of `run`).")
@study_options
@common_options(out_help="Folder of the study (default runs/<scenario>-sweep).")
@click.pass_obj
def sweep(session: Session, /, sizes: str, thresholds: str | None, **options: Any) -> int:
    """Cost, accuracy and consistency on SCENARIO (a built-in name or a TOML file) for every pair of submap size and fusion threshold.

    Under water the size is the length of a submap, and the limits of its landmarks and its uncertainty are laid aside.

    Times are taken while --jobs runs stand side by side; for times to compare with others give --jobs 1.
    """
    request = request_of(**options)
    from ssjs_cli.simulation import read_scenario
    from ssjs_cli.studies.study_text import answer_sweep
    from ssjs_cli.studies.sweep import axes_of, listed_values
    from ssjs_cli.studies.sweep import sweep as sweep_values

    kind = read_scenario(request.scenario, request.seed).kind
    axes = axes_of(kind)
    size_values = listed_values("--submap-size", axes.size_key, sizes, kind)
    threshold_values = None if thresholds is None else listed_values("--fusion-threshold", axes.threshold_key, thresholds, kind)
    return answer_sweep(sweep_values(request, size_values, threshold_values, session), session)
