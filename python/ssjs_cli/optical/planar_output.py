"""What the run of a mission of frames alone leaves beside its estimate: the mosaic, matches drawn between frames, and their numbers."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli.formats.frame_image import Frame
from ssjs_cli.formats.number_table import FloatArray
from ssjs_cli.formats.run_directory import PICTURES_FOLDER, Estimate
from ssjs_cli.optical.frame_settings import FrameSettings
from ssjs_cli.optical.landmark_patches import Looks, patch_sheet
from ssjs_cli.optical.match_pictures import shown_links
from ssjs_cli.optical.mosaic_picture import draw_mosaic
from ssjs_cli.optical.picture_index import PictureIndex
from ssjs_cli.optical.planar_survey import PlanarSurvey


def write_planar_survey(directory: Path, survey: PlanarSurvey, settings: FrameSettings, estimate: Estimate) -> dict[str, Any]:
    """The answer: what summary.json says of it."""
    pose = _poses(estimate, survey.frames.time_s)
    reader = settings.reader(survey.lens)
    index = PictureIndex(directory / PICTURES_FOLDER, settings.length_unit)
    drawn = survey.connected()

    def pixels() -> Iterator[Frame]:
        return (survey.frames.pixels_of(number) for number in drawn)

    index.add_mosaic(draw_mosaic(pixels, survey.placed_on_map(pose)[drawn], reader, settings.of_mosaic))
    positions = survey.frames.positions_px()
    for first, second in shown_links(survey.links):
        rows = survey.links[first, second]["inliers"]
        index.add_matches(
            (survey.frames.paths[first].name, survey.frames.paths[second].name),
            (reader.corrected(survey.frames.pixels_of(first)), reader.corrected(survey.frames.pixels_of(second))),
            (positions[first][rows[:, 0]], positions[second][rows[:, 1]]),
            seconds_apart=float(survey.frames.time_s[second] - survey.frames.time_s[first]),
        )
    if estimate.landmarks.ids_are_of_source:
        sheet = patch_sheet(
            _looks(survey, estimate), survey.frames.size_px, lambda number: reader.corrected(survey.frames.pixels_of(number))
        )
        if sheet is not None:
            index.add_landmarks(sheet, lambda number: survey.frames.paths[number].name)
    index.frames(given=survey.frames.given, used=len(survey.frames.paths), with_region=survey.frames.with_region)
    index.write()
    lens = None if survey.lens is None else list(survey.lens["distortion"])
    return {
        "length_unit": settings.length_unit,
        "axis_names": ["x, ahead at the start", "y, to its left"],
        "frames": survey.frames.given,
        "frames_used": len(survey.frames.paths),
        "frames_with_region": survey.frames.with_region,
        "frames_on_mosaic": len(drawn),
        "frames_registered": int(np.sum(survey.registered)),
        "frame_revisits": survey.revisits,
        "frame_rounds": survey.rounds,
        "lens_distortion": lens,
        "lens_estimated": survey.lens_is_estimated,
    }


def _looks(survey: PlanarSurvey, estimate: Estimate) -> Looks:
    """Of the landmarks on the map."""
    landmark = np.concatenate([identity for _, _, identity in survey.seen])
    frame = np.concatenate([np.full(len(identity), number, dtype=np.int64) for number, _, identity in survey.seen])
    pixel = np.concatenate([pixel for _, pixel, _ in survey.seen])
    rows = np.isin(landmark, estimate.landmarks.ids)
    return Looks(landmark[rows], frame[rows], pixel[rows])


def _poses(estimate: Estimate, time_s: FloatArray) -> FloatArray:
    """(n, 3): of several poses at one time the last."""
    rows = np.searchsorted(estimate.final.time_s, time_s, side="right") - 1
    return estimate.final.pose[np.maximum(rows, 0)]
