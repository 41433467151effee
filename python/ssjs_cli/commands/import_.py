"""ssjs-cli import: logs of other systems as mission directories."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ssjs_cli.options import common_options
from ssjs_cli.session import Session

if TYPE_CHECKING:
    from ssjs_cli.formats.mission import Mission

OUT_HELP = "Mission directory (default missions/<name>)."


@click.group(name="import")
def import_() -> None:
    """Make a mission directory from logs of other systems. Raw data are kept: detection belongs to `run`."""


def _import(session: Session, out: str | None, name: str, force: bool, read: Callable[[], "Mission"]) -> int:
    from ssjs_cli.mission_output import answer_mission, write_new_mission

    directory = Path(out) if out is not None else Path("missions") / name
    return answer_mission(directory, write_new_mission(directory, read, force=force, session=session), session)


@import_.command(name="victoria-park")
@click.argument("source", metavar="SRC", type=click.Path())
@common_options(out_help=OUT_HELP)
@click.pass_obj
def victoria_park(session: Session, source: str, seed: int | None, force: bool, out: str | None) -> int:
    """The Victoria Park drive: SRC holds victoria_park_ascii.zip (or LASER.txt), aa3_dr.mat and aa3_gpsx.mat."""
    from ssjs_cli.formats.victoria_park import read_victoria_park

    return _import(session, out, "victoria-park", force, lambda: read_victoria_park(Path(source)))


@import_.command()
@click.argument("source", metavar="SRC", type=click.Path())
@click.option("--robot", type=click.IntRange(1, 5), required=True, help="Which of the five robots.")
@click.option("--skip-unknown-barcodes", is_flag=True, help="Drop and count measurements whose barcode is unknown, instead of stopping.")
@common_options(out_help=OUT_HELP)
@click.pass_obj
def mrclam(session: Session, source: str, robot: int, skip_unknown_barcodes: bool, seed: int | None, force: bool, out: str | None) -> int:
    """One robot of a UTIAS multi-robot data set in the directory SRC."""
    from ssjs_cli.formats.mrclam import read_mrclam

    name = f"mrclam-robot{robot}"
    return _import(session, out, name, force, lambda: read_mrclam(Path(source), robot, skip_unknown_barcodes=skip_unknown_barcodes))


@import_.command()
@click.argument("source", metavar="SRC", type=click.Path())
@common_options(out_help=OUT_HELP)
@click.pass_obj
def aracati(session: Session, source: str, seed: int | None, force: bool, out: str | None) -> int:
    """ARACATI 2017, a vehicle with a forward-looking sonar in a marina: SRC holds keyframes.csv and sonar_points_body.csv."""
    from ssjs_cli.formats.aracati import read_aracati

    return _import(session, out, "aracati2017", force, lambda: read_aracati(Path(source)))


@import_.command()
@click.argument("source", metavar="SRC", type=click.Path())
@click.option(
    "--landmarks", type=click.IntRange(1), default=None, metavar="N", help="Simulate N posts along the way, and what is seen of them."
)
@common_options(out_help=OUT_HELP)
@click.pass_obj
def stpere(session: Session, source: str, landmarks: int | None, seed: int | None, force: bool, out: str | None) -> int:
    """The Ictineu log in the marina of Sant Pere Pescador: SRC holds *_MTI.log, *_DVL.log and *_DGPS.log.

    With --landmarks the mission is half real: the log, and posts as a scanning sonar would have seen them from where DGPS was.
    """
    from ssjs_cli.config import DEFAULT_SEED
    from ssjs_cli.formats.stpere import read_stpere

    name = "stpere" if landmarks is None else "stpere-half-real"
    chosen_seed = DEFAULT_SEED if seed is None else seed
    return _import(session, out, name, force, lambda: read_stpere(Path(source), landmarks=landmarks or 0, seed=chosen_seed))


@import_.command()
@click.argument("source", metavar="SRC", type=click.Path())
@click.option("--range-sigma-m", type=click.FloatRange(0.0, min_open=True), default=None, help="Range noise instead of the file's.")
@click.option("--bearing-sigma-rad", type=click.FloatRange(0.0, min_open=True), default=None, help="Bearing noise instead of the file's.")
@common_options(out_help=OUT_HELP)
@click.pass_obj
def graph(
    session: Session,
    source: str,
    range_sigma_m: float | None,
    bearing_sigma_rad: float | None,
    seed: int | None,
    force: bool,
    out: str | None,
) -> int:
    """A pose and landmark graph: the file SRC with lines ODOMETRY and LANDMARK."""
    from ssjs_cli.formats.graph import graph_name, read_graph
    from ssjs_cli.mission_run import path_name

    name = path_name(graph_name(Path(source)))
    return _import(
        session, out, name, force, lambda: read_graph(Path(source), range_sigma_m=range_sigma_m, bearing_sigma_rad=bearing_sigma_rad)
    )


@import_.command(name="csv")
@click.argument("source", metavar="SRC", type=click.Path())
@click.option("--odometry", default=None, metavar="FILE", help="Odometry file in the directory SRC (default odometry.csv).")
@click.option("--observations", default=None, metavar="FILE", help="Observations file (default observations.csv, where it exists).")
@click.option("--fixes", default=None, metavar="FILE", help="Reference fixes (default reference_fixes.csv, where it exists).")
@click.option("--landmarks", default=None, metavar="FILE", help="Surveyed landmarks (default truth_landmarks.csv, where it exists).")
@click.option(
    "--map",
    "mappings",
    multiple=True,
    metavar="TARGET=SOURCE[:UNIT]",
    help="A column under another name or unit, e.g. time_s=t:ms, bearing_rad=brg:-deg, odometry.speed_m_s=v:km/h; may be repeated.",
)
@click.option("--delimiter", default=",", show_default=True, help="Character between the fields; 'tab' for a tabulator.")
@click.option("--name", default=None, help="Name of the mission (default: the name of SRC).")
@common_options(out_help=OUT_HELP)
@click.pass_obj
def csv_(
    session: Session,
    source: str,
    odometry: str | None,
    observations: str | None,
    fixes: str | None,
    landmarks: str | None,
    mappings: tuple[str, ...],
    delimiter: str,
    name: str | None,
    seed: int | None,
    force: bool,
    out: str | None,
) -> int:
    """Tables with a header line: SRC is the odometry file, or the directory that holds it and the others.

    The odometry has time_s,speed_m_s,steering_rad or time_s,speed_m_s,turn_rate_rad_s or increments with their sigmas; the
    observations have time_s,range_m,bearing_rad (or x_m,y_m) and optionally landmark_id and variances.
    """
    from ssjs_cli.errors import UserError
    from ssjs_cli.formats.csv_log import find_log_files, parse_mappings, read_csv_log
    from ssjs_cli.mission_run import path_name

    path = Path(source)
    separator = "\t" if delimiter == "tab" else delimiter
    if len(separator) != 1 or separator.isalnum():
        raise UserError(f"--delimiter {delimiter}: must be one character that is no letter or digit, or 'tab'")
    chosen_name = name if name is not None else path.resolve().stem
    files = find_log_files(path, {"odometry": odometry, "observations": observations, "fixes": fixes, "landmarks": landmarks})
    columns = parse_mappings(mappings)
    return _import(session, out, path_name(chosen_name), force, lambda: read_csv_log(files, columns, name=chosen_name, delimiter=separator))


def _import_sonar_log(session: Session, kind: str, source: str, force: bool, out: str | None) -> int:
    from ssjs_cli.mission_run import path_name
    from ssjs_cli.sonar.import_log import import_sonar_log

    directory = Path(out) if out is not None else Path("missions") / path_name(Path(source).stem)
    return import_sonar_log(Path(source), kind, directory, session, force=force)


@import_.command()
@click.argument("source", metavar="SRC", type=click.Path())
@common_options(out_help=OUT_HELP)
@click.pass_obj
def xtf(session: Session, source: str, seed: int | None, force: bool, out: str | None) -> int:
    """A side-scan survey: the XTF log SRC, its pings kept, its navigation as tables."""
    return _import_sonar_log(session, "xtf", source, force, out)


@import_.command()
@click.argument("source", metavar="SRC", type=click.Path())
@common_options(out_help=OUT_HELP)
@click.pass_obj
def jsf(session: Session, source: str, seed: int | None, force: bool, out: str | None) -> int:
    """A side-scan survey: the JSF log SRC, its pings kept, its navigation as tables."""
    return _import_sonar_log(session, "jsf", source, force, out)


@import_.command()
@click.argument("source", metavar="SRC", type=click.Path())
@click.option(
    "--topic",
    "topics",
    multiple=True,
    metavar="ROLE=TOPIC",
    help="Topic of imu, velocity, depth, altitude or fix, or ROLE=none; may be repeated (default: found by type).",
)
@click.option(
    "--axes",
    type=click.Choice(["ros", "marine"]),
    default="ros",
    show_default=True,
    help="Of the recording; ros: east-north-up and forward-left-up; marine: north-east-down and forward-starboard-down.",
)
@click.option("--surface-pressure-pa", type=click.FloatRange(0.0), default=101_325.0, show_default=True, help="Pressure of the air.")
@click.option(
    "--water-density-kg-m3", type=click.FloatRange(0.0, min_open=True), default=1025.0, show_default=True, help="From pressure to depth."
)
@common_options(out_help=OUT_HELP)
@click.pass_obj
def rosbag(
    session: Session,
    source: str,
    topics: tuple[str, ...],
    axes: str,
    surface_pressure_pa: float,
    water_density_kg_m3: float,
    seed: int | None,
    force: bool,
    out: str | None,
) -> int:
    """An underwater vehicle recorded by ROS: a .bag of ROS 1, or of ROS 2 the directory, its .mcap or its .db3."""
    from ssjs_cli.mission_run import path_name
    from ssjs_cli.rosbag.mission import BagOptions, read_rosbag

    options = BagOptions(topics, axes == "marine", surface_pressure_pa, water_density_kg_m3)
    return _import(session, out, path_name(Path(source).stem), force, lambda: read_rosbag(Path(source), options))


@import_.command()
@click.argument("source", metavar="SRC", type=click.Path())
@click.option(
    "--calibration", default=None, metavar="FILE", help="Of the camera: OpenCV, ROS, Kalibr, Calib_Results.mat (default: SRC/camera.yaml)."
)
@click.option("--times", default=None, metavar="FILE", help="Table time_s,file (default: SRC/index.csv, the names, or EXIF).")
@click.option("--interval", "interval_s", type=click.FloatRange(0.0, min_open=True), default=None, metavar="S", help="A frame every S s.")
@common_options(out_help=OUT_HELP)
@click.pass_obj
def frames(
    session: Session,
    source: str,
    calibration: str | None,
    times: str | None,
    interval_s: float | None,
    seed: int | None,
    force: bool,
    out: str | None,
) -> int:
    """Frames of a down-looking camera: the images in the folder SRC, and imu.csv, dvl.csv, depth.csv, altitude.csv where they lie there."""
    from ssjs_cli.camera.import_frames import import_frames
    from ssjs_cli.mission_run import path_name

    files = (None if calibration is None else Path(calibration), None if times is None else Path(times))
    return _import(session, out, path_name(Path(source).resolve().name), force, lambda: import_frames(Path(source), *files, interval_s))
