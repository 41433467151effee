"""ssjs-cli sonar: side-scan logs looked at."""

from pathlib import Path

import click

from ssjs_cli.options import common_options, path_of
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
    type=click.Choice(["highlight_shadow", "improved_otsu", "cascade"]),
    default="highlight_shadow",
    show_default=True,
    help="What proposes contacts; all are measured by their shadows.",
)
@click.option("--model", type=click.Path(), default=None, help="cascade: a cascade.json, or the folder of a training.")
@click.option("--min-score", type=float, default=None, help="cascade: detections with a lower score are dropped.")
@click.option("--verify", type=click.Choice(["contour"]), default=None, help="cascade: look at the contour of each detection's echo.")
@click.option("--layback", type=click.Choice(["auto", "apply", "ignore"]), default="auto", show_default=True, help="As of sonar info.")
@common_options(out_help="The contacts, a CSV (default runs/<log>-contacts.csv).")
@click.pass_obj
def detect(
    session: Session,
    log: str,
    altitude: str,
    detector: str,
    model: str | None,
    min_score: float | None,
    verify: str | None,
    layback: str,
    seed: int | None,
    force: bool,
    out: str | None,
) -> int:
    """The contacts of LOG: where they lie, how long, wide and high they are."""
    from ssjs_cli.errors import UserError
    from ssjs_cli.sonar.detect import detect_contacts

    config: dict[str, float | int | bool | str | None] = {"altitude": altitude, "detector": detector}
    of_cascade = {"--model": model, "--min-score": min_score, "--verify": verify}
    given = [flag for flag, value in of_cascade.items() if value is not None]
    if given and detector != "cascade":
        raise UserError(f"{given[0]}: is of the detector cascade; add --detector cascade")
    if min_score is not None:
        config["cascade.min_score"] = min_score
    if verify is not None:
        config["cascade.verify"] = verify
    return detect_contacts(Path(log), path_of(out), session, config=config, layback=layback, force=force, model=path_of(model))


@sonar.command()
@click.argument("missions", metavar="MISSION...", nargs=-1, required=True, type=click.Path())
@click.option("--pings", type=click.IntRange(32), default=400, show_default=True, help="Rows of a tile.")
@click.option(
    "--object-size-m",
    "object_size",
    default="2.4,3.6",
    metavar="ALONG,ACROSS",
    show_default=True,
    help="Box about an object and its shadow.",
)
@common_options(out_help="Folder of the tiles (default runs/tiles).")
@click.pass_obj
def tiles(session: Session, missions: tuple[str, ...], pings: int, object_size: str, seed: int | None, force: bool, out: str | None) -> int:
    """Pictures and boxes for `cascade train`, from surveys whose objects and track are known, such as simulated ones."""
    from ssjs_cli.sonar.tiles import TileRequest, size_of, write_tiles

    target = path_of(out) or Path("runs") / "tiles"
    request = TileRequest([Path(mission) for mission in missions], target, pings, size_of(object_size), force)
    return write_tiles(request, session)
