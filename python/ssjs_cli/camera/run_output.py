"""What the run of a camera mission leaves beside its estimate: what became of every frame, pictures, and the errors of its landmarks."""

import csv
import io
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ssjs_cli.camera.frame_reading import LOST_KINDS, FrameOutcome
from ssjs_cli.camera.landmark_truth import landmark_numbers
from ssjs_cli.config import Scalar
from ssjs_cli.formats.mission import Mission
from ssjs_cli.formats.run_directory import FRAMES_FILE, Estimate
from ssjs_cli.optical.camera_output import write_camera_pictures

FRAME_COLUMNS = ("time_s", "file", "left_out", "reason", "regions", "keypoints")
MAX_LEFT_OUT_FRACTION = 0.1


def write_camera(
    directory: Path,
    mission: Mission,
    estimate: Estimate,
    result: Mapping[str, Any],
    settings: Mapping[str, Scalar],
    outcomes: Sequence[FrameOutcome],
) -> dict[str, Any]:
    """The answer: what summary.json says of it."""
    (directory / FRAMES_FILE).write_text(_frames_csv(outcomes), encoding="utf-8")
    numbers = frame_numbers(outcomes)
    if mission.frames is not None:
        used = [(outcome.time_s, outcome.file) for outcome in outcomes if not outcome.kind]
        altitude = None if mission.navigation is None else mission.navigation.altitude
        with_region, ids = numbers["frames_with_region"], estimate.landmarks.ids
        write_camera_pictures(directory, mission.frames, used, with_region, estimate.final, altitude, result, settings, ids)
    return {**numbers, **landmark_numbers(mission, result, settings)}


def frame_numbers(outcomes: Sequence[FrameOutcome]) -> dict[str, Any]:
    used = [outcome for outcome in outcomes if not outcome.kind]
    return {
        "frames": len(outcomes),
        "frames_used": len(used),
        "frames_with_region": sum(outcome.regions > 0 for outcome in used),
        "frames_left_out": dict(sorted(Counter(outcome.kind for outcome in outcomes if outcome.kind).items())),
        "keypoints": sum(outcome.keypoints for outcome in used),
    }


def doubtful_frames(outcomes: Sequence[FrameOutcome]) -> list[str]:
    """Frames that show nothing are no loss, unless they are many."""
    texts = []
    for kind, count in frame_numbers(outcomes)["frames_left_out"].items():
        if kind not in LOST_KINDS and count > MAX_LEFT_OUT_FRACTION * len(outcomes):
            first = next(outcome for outcome in outcomes if outcome.kind == kind)
            texts.append(
                f"{count} of {len(outcomes)} frames are {kind} and were left out, the first is {first.file}; see {FRAMES_FILE}, "
                "and the settings frames.limits.*"
            )
    return texts


def _frames_csv(outcomes: Sequence[FrameOutcome]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(FRAME_COLUMNS)
    writer.writerows((repr(o.time_s), o.file, o.kind, o.reason, o.regions, o.keypoints) for o in outcomes)
    return text.getvalue()
