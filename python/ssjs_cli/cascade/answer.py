"""What the finished commands of the cascade say on the terminal."""

from ssjs_cli.finished import Finished, note_losses
from ssjs_cli.session import Session
from ssjs_cli.studies.tables import terminal_table

LAYER_COLUMNS = (
    ("layer", "layer", "d"),
    ("features", "features", "d"),
    ("detection_rate", "detection rate", ".3%"),
    ("target_detection_rate", "wanted", ".1%"),
    ("false_positive_rate", "false positives", ".4%"),
    ("target_false_positive_rate", "wanted", ".2%"),
)


def answer_training(finished: Finished, session: Session) -> int:
    directory, document = finished.directory, finished.document
    code = note_losses(finished.failures, session)
    totals = document["totals"]
    held_back = f", {totals['objects_held_back']} held back" if totals["objects_held_back"] else ""
    lines = [
        f"{totals['objects_trained_on']} objects, {totals['positives']} windows of them{held_back}; "
        f"{totals['layers']} layers, {totals['features']} features; stopped: {document['stopped_because']}",
        terminal_table(
            "Layers, validated" if totals["objects_held_back"] else "Layers, on the windows trained on", LAYER_COLUMNS, document["layers"]
        ),
    ]
    if totals["objects_left_out"]:
        first = document["left_out"][0]
        lines.append(f"{totals['objects_left_out']} objects left out, the first: {first['object']}, {first['reason']}")
    lines += [
        f"{name:<9}{directory / file}" for name, file in (("model", "cascade.json"), ("OpenCV", "cascade.xml"), ("report", "report.html"))
    ]
    session.answer({"directory": str(directory), **document}, "\n".join(lines))
    return code


def answer_detection(finished: Finished, session: Session) -> int:
    directory, document = finished.directory, finished.document
    code = note_losses(finished.failures, session)
    totals = document["totals"]
    lines = [f"{totals['detections']} detections in {totals['images']} images"]
    if totals["failed"]:
        lines.append(f"  {totals['failed']} images could not be used")
    lines += [f"{name:<11}{directory / file}" for name, file in (("detections", "detections.csv"), ("overlays", "overlays"))]
    session.answer({"directory": str(directory), **document}, "\n".join(lines))
    return code


def answer_evaluation(finished: Finished, session: Session) -> int:
    directory, document = finished.directory, finished.document
    code = note_losses(finished.failures, session)
    totals, rates = document["totals"], document["rates"]
    low, high = rates["detection_rate_band"]
    columns = (
        ("layer", "layer", "d"),
        ("features", "features", "d"),
        ("detection_rate", "detection rate", ".2%"),
        ("false_positive_rate", "false positives", ".4%"),
    )
    lines = [
        f"{totals['found']} of {totals['objects']} objects found ({rates['detection_rate']:.1%}, 95 %: {low:.1%} to {high:.1%}), "
        f"{totals['false_boxes']} false boxes in {totals['images']} images ({rates['false_boxes_per_image']:.2f} an image)",
        f"average precision {rates['average_precision']:.3f}",
    ]
    at_one = rates["detection_rate_at_one_false_box"]
    if at_one is not None:
        lines.append(f"detection rate at no more than one false box an image: {at_one:.1%}")
    lines.append(terminal_table("Layers, on windows of these images", columns, document["layers"]))
    lines.append(f"report   {directory / 'report.html'}")
    session.answer({"directory": str(directory), **document}, "\n".join(lines))
    return code
