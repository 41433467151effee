"""ssjs-cli sonar: side-scan logs looked at."""

from pathlib import Path

import click

from ssjs_cli.options import common_options
from ssjs_cli.session import Session


@click.group()
def sonar() -> None:
    """Side-scan sonar logs (XTF, JSF): what they hold, their picture, their contacts."""


@sonar.command()
@click.argument("log", metavar="LOG", type=click.Path())
@click.option(
    "--layback",
    type=click.Choice(["auto", "apply", "ignore"]),
    default="auto",
    show_default=True,
    help="Whether positions are moved from the ship to the towed sonar; auto: as the format means it.",
)
@common_options(out_help="Also write the JSON document to this file.")
@click.pass_obj
def info(session: Session, log: str, layback: str, seed: int | None, force: bool, out: str | None) -> int:
    """What LOG holds: pings, channels, range, where positions come from, and everything that was wrong with it."""
    from ssjs_cli.sonar.info import show_info

    return show_info(Path(log), None if out is None else Path(out), session, layback=layback, force=force)


@sonar.command()
@click.argument("log", metavar="LOG", type=click.Path())
@click.option("--scale", type=click.Choice(["log", "linear"]), default="log", show_default=True, help="From echo strength to grey.")
@click.option("--frequency-khz", type=click.FloatRange(0.0, min_open=True), default=None, help="Of several, to 5 % (default: the first).")
@common_options(out_help="The picture, a PNG (default runs/<log>-waterfall.png).")
@click.pass_obj
def waterfall(session: Session, log: str, scale: str, frequency_khz: float | None, seed: int | None, force: bool, out: str | None) -> int:
    """LOG as a picture in slant range: first ping at the top, port on the left, the track in the middle."""
    from ssjs_cli.sonar.waterfall import draw_waterfall

    target = None if out is None else Path(out)
    return draw_waterfall(Path(log), target, session, scale=scale, frequency_khz=frequency_khz, force=force)


@sonar.command()
@click.argument("log", metavar="LOG", type=click.Path())
@click.option(
    "--altitude",
    type=click.Choice(["log", "bottom_tracking", "log_else_tracking"]),
    default="log_else_tracking",
    show_default=True,
    help="Where the height above the bottom comes from.",
)
@click.option(
    "--detector",
    type=click.Choice(["highlight_shadow", "improved_otsu"]),
    default="highlight_shadow",
    show_default=True,
    help="What proposes contacts; both are measured by their shadows.",
)
@click.option("--layback", type=click.Choice(["auto", "apply", "ignore"]), default="auto", show_default=True, help="As of sonar info.")
@common_options(out_help="The contacts, a CSV (default runs/<log>-contacts.csv).")
@click.pass_obj
def detect(session: Session, log: str, altitude: str, detector: str, layback: str, seed: int | None, force: bool, out: str | None) -> int:
    """The contacts of LOG: where they lie, how long, wide and high they are."""
    from ssjs_cli.sonar.detect import detect_contacts

    target = None if out is None else Path(out)
    config: dict[str, float | int | bool | str | None] = {"altitude": altitude, "detector": detector}
    return detect_contacts(Path(log), target, session, config=config, layback=layback, force=force)
