"""ssjs-cli export: a finished run in the formats of other programs."""

import click

from ssjs_cli.options import common_options, path_of
from ssjs_cli.session import Session


@click.group()
def export() -> None:
    """A finished run for other programs."""


@export.command()
@click.argument("run_dir", type=click.Path())
@click.option("--mission", "mission_dir", type=click.Path(), default=None, help="Where the run's mission lies now, if it was moved.")
@click.option("--pings-per-strip", type=click.IntRange(1, 4096), default=64, show_default=True, help="Rows of a picture of the sonar.")
@click.option("--no-sonar", is_flag=True, help="Leave out the pictures of the sonar.")
@common_options(out_help="The recording (default RUN_DIR.mcap).")
@click.pass_obj
def mcap(
    session: Session,
    run_dir: str,
    mission_dir: str | None,
    pings_per_strip: int,
    no_sonar: bool,
    seed: int | None,
    force: bool,
    out: str | None,
) -> int:
    """One MCAP file of RUN_DIR for viewers with a time slider (Foxglove, Lichtblick): tracks, ellipsoids, map, loops, sonar, NIS."""
    from pathlib import Path

    from ssjs_cli.mcap_export.export import export_mcap
    from ssjs_cli.mcap_export.mission_topics import StripSize

    strips = None if no_sonar else StripSize(pings=pings_per_strip)
    return export_mcap(Path(run_dir), path_of(out), session, mission_path=path_of(mission_dir), strips=strips, force=force)
