"""Windows for training: objects with their changed copies, split by recording, and the pictures to take windows without object from."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssjs_cli import _core
from ssjs_cli.cascade.labelled_images import LabelledImage, LabelledImages, file_digest
from ssjs_cli.cascade.settings import (
    AUGMENTATION_PREFIX,
    BACKGROUND_KEY,
    COPIES_KEY,
    MARGIN_KEY,
    VALIDATION_FRACTION_KEY,
    VALIDATION_WINDOWS_KEY,
    WINDOW_HEIGHT_KEY,
    WINDOW_WIDTH_KEY,
    part,
)
from ssjs_cli.cascade.window_boxes import window_box
from ssjs_cli.config import Settings
from ssjs_cli.errors import UserError
from ssjs_cli.formats.annotations.boxes import Box
from ssjs_cli.formats.image_file import read_image
from ssjs_cli.segmentation.image_list import ListedImage

Windows = NDArray[np.uint8]
#: Flat windows cannot be normalised; no cascade passes them.
_LEAST_DEVIATION = 1e-9


@dataclass
class PictureSource:
    """Pictures without objects, or without them where the boxes are. Those that cannot be read are noted once."""

    paths: list[Path]
    boxes: list[tuple[Box, ...]]
    problems: dict[str, str] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.paths)

    def read(self, index: int) -> tuple[NDArray[Any], NDArray[np.uint8] | None] | None:
        path = self.paths[index]
        try:
            image = read_image(path)
        except UserError as error:
            self.problems.setdefault(path.name, str(error))
            return None
        if not self.boxes[index]:
            return image.levels, image.valid
        valid = np.full(image.levels.shape, 255, dtype=np.uint8) if image.valid is None else image.valid.copy()
        for left, top, width, height in self.boxes[index]:
            valid[top : top + height, left : left + width] = 0
        return image.levels, valid

    def digest(self) -> str:
        """Of the files' content and the boxes."""
        hash_ = hashlib.sha256()
        for path, boxes in zip(self.paths, self.boxes, strict=True):
            try:
                hash_.update(file_digest(path).encode())
            except OSError:
                hash_.update(b"unreadable")
            hash_.update(repr(boxes).encode())
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


def object_windows(image: LabelledImage, settings: Settings, seed: int, *, copies: int) -> tuple[list[Windows], list[tuple[str, str]]]:
    """For each usable object an array (1 + copies at most, height, width), itself first; and the others with the reason."""
    width_px, height_px = window_size(settings)
    picture = read_image(image.listed.path)
    levels = _core.in_8_bits(picture.levels, picture.valid)
    made: list[Windows] = []
    left_out = []
    for number, box in enumerate(image.boxes, 1):
        name = f"{image.listed.name}, object {number}"
        grown = window_box(box, float(settings.values[MARGIN_KEY] or 0.0), (width_px, height_px), (picture.width_px, picture.height_px))
        window = None if grown is None else _core.training_window(levels, grown, width_px, height_px)
        if grown is None or window is None:
            left_out.append((name, "its window is larger than the picture"))
            continue
        if float(window[1:-1, 1:-1].std()) < _LEAST_DEVIATION:
            left_out.append((name, "its window is of one level"))
            continue
        parts = [window[np.newaxis]]
        if copies:
            changes = part(settings.values, AUGMENTATION_PREFIX)
            parts.append(_core.augmented_windows(levels, grown, width_px, height_px, copies, changes, seed, name))
        made.append(np.concatenate(parts))
    return made, left_out


def make_samples(
    labelled: LabelledImages,
    recordings: Sequence[str],
    negatives: Sequence[ListedImage],
    negative_recordings: Sequence[str],
    settings: Settings,
    seed: int,
    threads: int,
) -> TrainingSamples:
    """recordings, negative_recordings: of each image; the same name means the same recording."""
    names = sorted({*recordings, *negative_recordings})
    number_of = {name: number for number, name in enumerate(names)}
    groups: list[Windows] = []
    group_recordings: list[int] = []
    left_out: list[tuple[str, str]] = []
    for image, recording in zip(labelled.images, recordings, strict=True):
        made, reasons = object_windows(image, settings, seed, copies=int(settings.values[COPIES_KEY] or 0))
        groups += made
        group_recordings += [number_of[recording]] * len(made)
        left_out += reasons
    if len(groups) < 2:
        raise UserError(f"only {len(groups)} objects can be trained on, and at least two are needed; label more, or check the boxes")
    fraction = float(settings.values[VALIDATION_FRACTION_KEY] or 0.0)
    training, validation = _core.split_by_recording(group_recordings, fraction, seed)
    held_back = {group_recordings[index] for index in validation}
    for_training, for_validation = _split_pictures(negatives, [number_of[name] for name in negative_recordings], held_back, fraction, seed)
    if settings.values[BACKGROUND_KEY]:
        for image, recording in zip(labelled.images, recordings, strict=True):
            target = for_validation if number_of[recording] in held_back else for_training
            target.paths.append(image.listed.path)
            target.boxes.append(image.boxes)
    width_px, height_px = window_size(settings)
    nothing = np.zeros((0, height_px, width_px), dtype=np.uint8)
    validation_negatives = nothing
    if len(for_validation):
        wanted = int(settings.values[VALIDATION_WINDOWS_KEY] or 0)
        name = "validation windows without object"
        validation_negatives = _core.background_windows(
            len(for_validation), for_validation.read, wanted, width_px, height_px, seed, name, threads
        )
    return TrainingSamples(
        positives=np.concatenate([groups[index] for index in training]),
        recordings=[group_recordings[index] for index in training for _ in range(len(groups[index]))],
        objects=len(training),
        validation_positives=np.concatenate([nothing, *(groups[index][:1] for index in validation)]),
        validation_negatives=validation_negatives,
        negatives=for_training,
        validation_pictures=for_validation,
        left_out=left_out,
    )


def _split_pictures(
    negatives: Sequence[ListedImage], recordings: Sequence[int], held_back: set[int], fraction: float, seed: int
) -> tuple[PictureSource, PictureSource]:
    """Pictures of recordings held back validate; of the recordings without objects some are drawn besides."""
    apart = [index for index, recording in enumerate(recordings) if recording not in held_back]
    _, drawn = _core.split_by_recording([recordings[index] for index in apart], fraction, seed) if apart else ([], [])
    validating = {apart[index] for index in drawn} | {index for index, recording in enumerate(recordings) if recording in held_back}
    sides: tuple[list[Path], list[Path]] = ([], [])
    for index, image in enumerate(negatives):
        sides[index in validating].append(image.path)
    return PictureSource(sides[0], [()] * len(sides[0])), PictureSource(sides[1], [()] * len(sides[1]))
