"""ssjs-cli cascade: Haar cascades trained, run, evaluated and shown."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from ssjs_cli.options import common_options
from ssjs_cli.session import Session


@click.group()
def cascade() -> None:
    """Haar cascades for objects with a shadow: train, detect, evaluate, show."""


def _options(*options: Callable[..., Any]) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    def decorate(command: Callable[..., Any]) -> Callable[..., Any]:
        for option in reversed(options):
            command = option(command)
        return command

    return decorate


_settings_options = _options(
    click.option("--config", "config_path", type=click.Path(), default=None, help="TOML file, such as the config.toml of a result."),
    click.option("--set", "assignments", multiple=True, metavar="KEY=VALUE", help="One setting by its full key; may be repeated."),
)
_mirrored_option = click.option(
    "--mirrored", default=None, metavar="REGEX", help="Images of the other side of the vehicle, by name: shadows fall the other way there."
)
_label_options = _options(
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


def _settings(options: dict[str, Any]) -> Any:
    from ssjs_cli.cascade.settings import SettingsRequest

    path = options["config_path"]
    return SettingsRequest(None if path is None else Path(path), options["assignments"], options["seed"])


def _path(text: str | None) -> Path | None:
    return None if text is None else Path(text)


@cascade.command()
@click.option(
    "--positives", multiple=True, required=True, metavar="DIR", help="Images with objects: a folder, a file or a pattern; may be repeated."
)
@_label_options
@click.option("--negatives", multiple=True, metavar="DIR", help="Images without objects; may be repeated.")
@click.option(
    "--plan", type=click.Path(), default=None, metavar="FILE", help="Targets of the layers as TOML (default: seven layers, Table 4.1)."
)
@_settings_options
@click.option("--jobs", type=click.IntRange(1), default=None, help="Threads (default: one a core); the result does not depend on them.")
@click.option("--resume", is_flag=True, help="Carry on after the last finished layer of an interrupted training.")
@click.option("--no-report", is_flag=True, help="Leave out report.html.")
@common_options(out_help="Result directory (default runs/<folder of the positives>-cascade).")
@click.pass_obj
def train(session: Session, /, **options: Any) -> int:
    """Train a cascade from labelled images: cascade.json, cascade.xml for OpenCV 4, a report.

    \b
    ssjs-cli cascade train --positives tiles/ --masks masks/ --negatives seabed/
    ssjs-cli cascade train --positives img/ --annotations info.dat --negatives bg/ --plan plan.toml --set training.feature_set=side_scan
    """
    from ssjs_cli.cascade.answer import answer_training
    from ssjs_cli.cascade.labelled_images import label_source
    from ssjs_cli.cascade.train import TrainingRequest
    from ssjs_cli.cascade.train import train as train_cascade

    request = TrainingRequest(
        options["positives"],
        label_source(options["masks"], options["annotations"], options["label"], options["mirrored"]),
        options["negatives"],
        plan=_path(options["plan"]),
        recordings=options["recordings"],
        settings=_settings(options),
        threads=options["jobs"],
        resume=options["resume"],
        with_report=not options["no_report"],
        out=_path(options["out"]),
        force=options["force"],
    )
    finished = train_cascade(request, session)
    return answer_training(finished, session)


@cascade.command()
@click.argument("model", type=click.Path())
@click.argument("images", nargs=-1, required=True)
@_mirrored_option
@_settings_options
@click.option("--jobs", type=click.IntRange(1), default=None, help="Workers (default: one a core); the result does not depend on them.")
@click.option("--no-overlays", is_flag=True, help="Leave out the pictures with boxes.")
@common_options(out_help="Result directory (default runs/<first folder or image>-detections).")
@click.pass_obj
def detect(session: Session, /, model: str, images: tuple[str, ...], **options: Any) -> int:
    """Find the objects of MODEL in images: detections.csv, detections.json, overlays.

    MODEL is a cascade.json, the directory of a training, or OpenCV's cascade XML.

    \b
    ssjs-cli cascade detect runs/tiles-cascade survey/ --set detector.min_neighbours=5 --set detector.max_width_px=80
    """
    from ssjs_cli.cascade.answer import answer_detection
    from ssjs_cli.cascade.detect import DetectionRequest
    from ssjs_cli.cascade.detect import detect as detect_objects

    request = DetectionRequest(
        Path(model),
        images,
        settings=_settings(options),
        mirrored=options["mirrored"],
        jobs=options["jobs"],
        with_overlays=not options["no_overlays"],
        out=_path(options["out"]),
        force=options["force"],
    )
    finished = detect_objects(request, session)
    return answer_detection(finished, session)


@cascade.command()
@click.argument("model", type=click.Path())
@click.argument("images", nargs=-1, required=True)
@_label_options
@_settings_options
@click.option("--jobs", type=click.IntRange(1), default=None, help="Workers (default: one a core); the result does not depend on them.")
@click.option("--no-report", is_flag=True, help="Leave out report.html.")
@common_options(out_help="Result directory (default runs/<first folder or image>-cascade-evaluation).")
@click.pass_obj
def evaluate(session: Session, /, model: str, images: tuple[str, ...], **options: Any) -> int:
    """What MODEL finds in labelled images: a table of its layers, FROC, precision and recall, its best and worst detections.

    \b
    ssjs-cli cascade evaluate runs/tiles-cascade test/ --masks test-masks/ --recordings '(\\d{14})'
    """
    from ssjs_cli.cascade.answer import answer_evaluation
    from ssjs_cli.cascade.evaluate import EvaluationRequest
    from ssjs_cli.cascade.evaluate import evaluate as evaluate_cascade
    from ssjs_cli.cascade.labelled_images import label_source

    request = EvaluationRequest(
        Path(model),
        images,
        label_source(options["masks"], options["annotations"], options["label"], options["mirrored"]),
        recordings=options["recordings"],
        settings=_settings(options),
        jobs=options["jobs"],
        with_report=not options["no_report"],
        out=_path(options["out"]),
        force=options["force"],
    )
    finished = evaluate_cascade(request, session)
    return answer_evaluation(finished, session)


@cascade.command()
@click.argument("model", type=click.Path())
@common_options(out_help="Page to write (default runs/<model>-shown.html).")
@click.pass_obj
def show(session: Session, /, model: str, **options: Any) -> int:
    """Draw MODEL: every feature of every layer over the mean object, and a table of layers.

    \b
    ssjs-cli cascade show runs/tiles-cascade
    ssjs-cli cascade show haarcascade_frontalface_default.xml --out faces.html
    """
    from ssjs_cli.cascade.show import show_model

    return show_model(Path(model), _path(options["out"]), session, force=options["force"])
