"""ssjs-cli cascade: Haar cascades trained, run, evaluated and shown."""

from pathlib import Path
from typing import Any

import click

from ssjs_cli.options import common_options, options, path_of, pixel_size_option, settings_options
from ssjs_cli.session import Session


@click.group()
def cascade() -> None:
    """Haar cascades for objects with a shadow: train, detect, evaluate, show."""


_mirrored_option = click.option(
    "--mirrored", default=None, metavar="REGEX", help="Images of the other side of the vehicle, by name: shadows fall the other way there."
)
_label_options = options(
    _mirrored_option,
    click.option("--masks", type=click.Path(), default=None, metavar="DIR", help="A mask for each image, of the same name."),
    click.option(
        "--annotations",
        type=click.Path(),
        default=None,
        metavar="FILE|DIR",
        help="info.dat, COCO .json, .csv, VOC .xml, or a folder of VOC or YOLO files.",
    ),
    click.option("--label", default=None, metavar="NAME", help="Only objects of this class."),
    click.option(
        "--recordings", default=None, metavar="REGEX", help="Part of an image's name that tells its recording (default: each image is one)."
    ),
)


_detector_options = options(
    click.option(
        "--nadir",
        default=None,
        metavar="left|middle|right|COLUMN",
        help="Where the sonar passed: port lies left of it, starboard right of it.",
    ),
    pixel_size_option,
    click.option("--verify", default=None, metavar="contour", help="Drop boxes whose echo has another contour than known objects."),
    settings_options,
    click.option("--jobs", type=click.IntRange(1), default=None, help="Workers (default: one a core); the result does not depend on them."),
)


def _shared(given: dict[str, Any]) -> dict[str, Any]:
    """What the requests of training, detection and evaluation have in common."""
    from ssjs_cli.cascade.settings import SettingsRequest

    settings = SettingsRequest(
        path_of(given["config_path"]),
        given["assignments"],
        given["seed"],
        nadir=given.get("nadir"),
        pixel_size=given.get("pixel_size"),
        verify=given.get("verify"),
    )
    return {"settings": settings, "out": path_of(given["out"]), "force": given["force"]}


def _labels(given: dict[str, Any]) -> dict[str, Any]:
    from ssjs_cli.cascade.labelled_images import label_source

    labels = label_source(given["masks"], given["annotations"], given["label"], given["mirrored"])
    return {"labels": labels, "recordings": given["recordings"], "with_report": not given["no_report"]}


@cascade.command()
@click.option(
    "--positives", multiple=True, required=True, metavar="DIR", help="Images with objects: a folder, a file or a pattern; may be repeated."
)
@_label_options
@click.option("--negatives", multiple=True, metavar="DIR", help="Images without objects; may be repeated.")
@click.option(
    "--plan", type=click.Path(), default=None, metavar="FILE", help="Targets of the layers as TOML (default: seven layers, Table 4.1)."
)
@settings_options
@click.option("--jobs", type=click.IntRange(1), default=None, help="Threads (default: one a core); the result does not depend on them.")
@click.option("--resume", is_flag=True, help="Carry on after the last finished layer of an interrupted training.")
@click.option("--no-report", is_flag=True, help="Leave out report.html.")
@common_options(out_help="Result directory (default runs/<folder of the positives>-cascade).")
@click.pass_obj
def train(session: Session, /, **given: Any) -> int:
    """Train a cascade from labelled images: cascade.json, cascade.xml for OpenCV 4, a report.

    \b
    ssjs-cli cascade train --positives tiles/ --masks masks/ --negatives seabed/
    ssjs-cli cascade train --positives img/ --annotations info.dat --negatives bg/ --plan plan.toml --set training.feature_set=side_scan
    """
    from ssjs_cli.cascade.answer import answer_training
    from ssjs_cli.cascade.train import TrainingRequest
    from ssjs_cli.cascade.train import train as train_cascade

    request = TrainingRequest(
        positives=given["positives"],
        negatives=given["negatives"],
        plan=path_of(given["plan"]),
        threads=given["jobs"],
        resume=given["resume"],
        **_labels(given),
        **_shared(given),
    )
    return answer_training(train_cascade(request, session), session)


@cascade.command()
@click.argument("model", type=click.Path())
@click.argument("images", nargs=-1, required=True)
@_mirrored_option
@_detector_options
@click.option("--no-overlays", is_flag=True, help="Leave out the pictures with boxes.")
@common_options(out_help="Result directory (default runs/<first folder or image>-detections).")
@click.pass_obj
def detect(session: Session, /, model: str, images: tuple[str, ...], **given: Any) -> int:
    """Find the objects of MODEL in images: detections.csv, detections.json, overlays.

    MODEL is a cascade.json, the directory of a training, or OpenCV's cascade XML.

    \b
    ssjs-cli cascade detect runs/tiles-cascade survey/ --set detector.min_neighbours=5 --set detector.max_width_px=80
    ssjs-cli cascade detect runs/tiles-cascade waterfall.png --nadir middle --pixel-size-m 0.1,0.05 --set detector.min_width_m=2
    ssjs-cli cascade detect runs/tiles-cascade survey/ --verify contour
    """
    from ssjs_cli.cascade.answer import answer_detection
    from ssjs_cli.cascade.detect import DetectionRequest
    from ssjs_cli.cascade.detect import detect as detect_objects

    request = DetectionRequest(
        Path(model), images, mirrored=given["mirrored"], jobs=given["jobs"], with_overlays=not given["no_overlays"], **_shared(given)
    )
    return answer_detection(detect_objects(request, session), session)


@cascade.command()
@click.argument("model", type=click.Path())
@click.argument("images", nargs=-1, required=True)
@_label_options
@_detector_options
@click.option("--no-report", is_flag=True, help="Leave out report.html.")
@common_options(out_help="Result directory (default runs/<first folder or image>-cascade-evaluation).")
@click.pass_obj
def evaluate(session: Session, /, model: str, images: tuple[str, ...], **given: Any) -> int:
    """What MODEL finds in labelled images: a table of its layers, FROC, precision and recall, its best and worst detections.

    \b
    ssjs-cli cascade evaluate runs/tiles-cascade test/ --masks test-masks/ --recordings '(\\d{14})'
    """
    from ssjs_cli.cascade.answer import answer_evaluation
    from ssjs_cli.cascade.evaluate import EvaluationRequest
    from ssjs_cli.cascade.evaluate import evaluate as evaluate_cascade

    request = EvaluationRequest(Path(model), images, jobs=given["jobs"], **_labels(given), **_shared(given))
    return answer_evaluation(evaluate_cascade(request, session), session)


@cascade.command()
@click.argument("model", type=click.Path())
@common_options(out_help="Page to write (default runs/<model>-shown.html).")
@click.pass_obj
def show(session: Session, /, model: str, **given: Any) -> int:
    """Draw MODEL: every feature of every layer over the mean object, and a table of layers.

    \b
    ssjs-cli cascade show runs/tiles-cascade
    ssjs-cli cascade show haarcascade_frontalface_default.xml --out faces.html
    """
    from ssjs_cli.cascade.show import show_model

    return show_model(Path(model), path_of(given["out"]), session, force=given["force"])
