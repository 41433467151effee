"""Windows for training: objects with their changed copies, split by recording, and the pictures to take windows without object from."""

import hashlib
from collections.abc import Sequence, Set
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssjs_cli import _core
from ssjs_cli.cascade.labelled_images import LabelledImage, LabelledImages
from ssjs_cli.cascade.settings import (
    AUGMENTATION_PREFIX,
    BACKGROUND_KEY,
    MARGIN_KEY,
    SMOOTHING_KEY,
    VALIDATION_FRACTION_KEY,
    VALIDATION_WINDOWS_KEY,
    WINDOW_HEIGHT_KEY,
    WINDOW_WIDTH_KEY,
)
from ssjs_cli.cascade.smoothing import smoothed
from ssjs_cli.cascade.window_boxes import window_box
from ssjs_cli.cascade.windows import Windows, background_windows, core_seed, no_windows, window_of, window_set
from ssjs_cli.config import Settings, part
from ssjs_cli.errors import UserError
from ssjs_cli.formats.annotations.boxes import Box
from ssjs_cli.formats.file_digest import file_digest
from ssjs_cli.formats.image_file import read_image
from ssjs_cli.segmentation.image_list import ListedImage

#: Flat windows cannot be normalised; no cascade passes them.
_LEAST_DEVIATION = 1e-9


@dataclass
class PictureSource:
    """Pictures without objects, or without them where the boxes are. Those that cannot be read are noted once."""

    paths: list[Path]
    boxes: list[tuple[Box, ...]]
    mirrored: list[bool]
    smoothing_px: int = 1
    problems: dict[str, str] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.paths)

    def read(self, index: int) -> Any:
        """The levels, or levels and valid mask; None where the picture cannot be read."""
        path = self.paths[index]
        try:
            image = read_image(path)
        except UserError as error:
            self.problems.setdefault(path.name, str(error))
            return None
        levels, valid = smoothed(image.levels, image.valid, self.smoothing_px), image.valid
        if self.boxes[index]:
            valid = np.full(levels.shape, 255, dtype=np.uint8) if valid is None else valid.copy()
            for left, top, width, height in self.boxes[index]:
                valid[top : top + height, left : left + width] = 0
        if self.mirrored[index]:
            levels = np.ascontiguousarray(levels[:, ::-1])
            valid = None if valid is None else np.ascontiguousarray(valid[:, ::-1])
        return levels if valid is None else (levels, valid)

    def digest(self) -> str:
        """Of the files' content and the boxes."""
        hash_ = hashlib.sha256(f"smoothed over {self.smoothing_px} px".encode())
        for path, boxes, mirrored in zip(self.paths, self.boxes, self.mirrored, strict=True):
            try:
                hash_.update(file_digest(path).encode())
            except OSError:
                hash_.update(b"unreadable")
            hash_.update(repr((boxes, mirrored)).encode())
        return hash_.hexdigest()[:32]


@dataclass(frozen=True)
class TrainingSamples:
    """positives: objects and copies; objects: those of them that are no copies; left_out: objects larger than their picture or flat."""

    positives: Windows
    recordings: list[int]
    objects: int
    validation_positives: Windows
    validation_negatives: Windows
    negatives: PictureSource
    validation_pictures: PictureSource
    left_out: list[tuple[str, str]]


def window_size(settings: Settings) -> tuple[int, int]:
    return int(settings.values[WINDOW_WIDTH_KEY] or 0), int(settings.values[WINDOW_HEIGHT_KEY] or 0)


def object_windows(image: LabelledImage, settings: Settings) -> tuple[list[NDArray[np.uint8]], list[tuple[str, str]]]:
    """A window (height, width) of each usable object; and the others with the reason."""
    width_px, height_px = window_size(settings)
    levels, boxes = image.read_levels(int(settings.values[SMOOTHING_KEY] or 1))
    made: list[NDArray[np.uint8]] = []
    left_out = []
    for number, box in enumerate(boxes, 1):
        name = f"{image.listed.name}, object {number}"
        grown = window_box(box, float(settings.values[MARGIN_KEY] or 0.0), (width_px, height_px), (image.width_px, image.height_px))
        window = None if grown is None else window_of(levels, grown, width_px, height_px)
        if grown is None or window is None:
            left_out.append((name, "its window is larger than the picture"))
            continue
        if float(window[1:-1, 1:-1].std()) < _LEAST_DEVIATION:
            left_out.append((name, "its window is of one level"))
            continue
        made.append(window)
    return made, left_out


def make_samples(
    labelled: LabelledImages,
    recordings: Sequence[str],
    negatives: Sequence[ListedImage],
    negative_recordings: Sequence[str],
    settings: Settings,
    seed: int,
    threads: int,
    mirrored_negatives: Set[str] = frozenset(),
) -> TrainingSamples:
    """recordings, negative_recordings: of each image; the same name means the same recording. mirrored_negatives: names."""
    names = sorted({*recordings, *negative_recordings})
    number_of = {name: number for number, name in enumerate(names)}
    groups: list[NDArray[np.uint8]] = []
    group_recordings: list[int] = []
    left_out: list[tuple[str, str]] = []
    for image, recording in zip(labelled.images, recordings, strict=True):
        made, reasons = object_windows(image, settings)
        groups += made
        group_recordings += [number_of[recording]] * len(made)
        left_out += reasons
    if len(groups) < 2:
        raise UserError(f"only {len(groups)} objects can be trained on, and at least two are needed; label more, or check the boxes")
    fraction = float(settings.values[VALIDATION_FRACTION_KEY] or 0.0)
    training, validation = _core.split_by_recording(group_recordings, fraction, core_seed(seed))
    held_back = {group_recordings[index] for index in validation}
    for_training, for_validation = _split_pictures(
        int(settings.values[SMOOTHING_KEY] or 1),
        negatives,
        [number_of[name] for name in negative_recordings],
        mirrored_negatives,
        held_back,
        fraction,
        seed,
    )
    if settings.values[BACKGROUND_KEY]:
        for image, recording in zip(labelled.images, recordings, strict=True):
            target = for_validation if number_of[recording] in held_back else for_training
            target.paths.append(image.listed.path)
            target.boxes.append(image.boxes)
            target.mirrored.append(image.mirrored)
    width_px, height_px = window_size(settings)
    nothing = no_windows(width_px, height_px)
    validation_negatives = nothing
    if len(for_validation):
        wanted = int(settings.values[VALIDATION_WINDOWS_KEY] or 0)
        name = "validation windows without object"
        validation_negatives = background_windows(
            len(for_validation), for_validation.read, wanted, width_px, height_px, seed, name, threads
        )
    objects = window_set(np.stack([groups[index] for index in training]), [group_recordings[index] for index in training])
    positives = objects.augmented(part(settings.values, AUGMENTATION_PREFIX), core_seed(seed))
    return TrainingSamples(
        positives=positives.pictures(),
        recordings=positives.recordings(),
        objects=len(training),
        validation_positives=np.stack([groups[index] for index in validation]) if validation else nothing,
        validation_negatives=validation_negatives,
        negatives=for_training,
        validation_pictures=for_validation,
        left_out=left_out,
    )


def _split_pictures(
    smoothing_px: int,
    negatives: Sequence[ListedImage],
    recordings: Sequence[int],
    mirrored: Set[str],
    held_back: set[int],
    fraction: float,
    seed: int,
) -> tuple[PictureSource, PictureSource]:
    """Pictures of recordings held back validate; of the recordings without objects some are drawn besides."""
    apart = [index for index, recording in enumerate(recordings) if recording not in held_back]
    _, drawn = _core.split_by_recording([recordings[index] for index in apart], fraction, core_seed(seed)) if apart else ([], [])
    validating = {apart[index] for index in drawn} | {index for index, recording in enumerate(recordings) if recording in held_back}
    sides = (PictureSource([], [], [], smoothing_px), PictureSource([], [], [], smoothing_px))
    for index, image in enumerate(negatives):
        side = sides[index in validating]
        side.paths.append(image.path)
        side.boxes.append(())
        side.mirrored.append(image.name in mirrored)
    return sides
