"""Windows for training: objects with their changed copies, split by recording, and the pictures to take windows without object from."""

import hashlib
from collections.abc import Sequence, Set
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssjs_cli import _core
from ssjs_cli.cascade.copies import Variation, variation_of
from ssjs_cli.cascade.labelled_images import LabelledImage, LabelledImages
from ssjs_cli.cascade.preparation import Preparation, preparation_of
from ssjs_cli.cascade.settings import (
    BACKGROUND_KEY,
    MARGIN_KEY,
    VALIDATION_FRACTION_KEY,
    VALIDATION_WINDOWS_KEY,
    WINDOW_HEIGHT_KEY,
    WINDOW_WIDTH_KEY,
)
from ssjs_cli.cascade.window_boxes import window_box
from ssjs_cli.cascade.windows import Windows, background_windows, core_seed, no_windows, window_of
from ssjs_cli.config import Settings
from ssjs_cli.errors import UserError
from ssjs_cli.formats.annotations.boxes import Box
from ssjs_cli.formats.file_digest import file_digest
from ssjs_cli.formats.image_file import read_image
from ssjs_cli.segmentation.image_list import ListedImage

#: Flat windows cannot be normalised; no cascade passes them.
_LEAST_DEVIATION = 1e-9


@dataclass
class PictureSource:
    """Pictures without objects, or without them where the boxes are. Those that cannot be read are noted once.

    variation: of so many pictures in a row as an object has copies and itself, all but the first have other levels, drawn by seed."""

    paths: list[Path]
    boxes: list[tuple[Box, ...]]
    mirrored: list[bool]
    preparation: Preparation = field(default_factory=Preparation)
    variation: Variation = field(default_factory=Variation)
    seed: int = 0
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
        levels = _core.in_8_bits(image.levels, image.valid)
        if index % (self.variation.copies + 1):
            levels = self.variation.levels(levels, np.random.default_rng([self.seed, 1, index]))
        levels, valid = self.preparation.picture(levels, image.valid)
        if self.boxes[index]:
            free = np.full((image.height_px, image.width_px), 255, dtype=np.uint8)
            for left, top, width, height in self.boxes[index]:
                free[top : top + height, left : left + width] = 0
            free = self.preparation.continued(free)
            valid = free if valid is None else np.minimum(free, valid)
        if self.mirrored[index]:
            levels = np.ascontiguousarray(levels[:, ::-1])
            valid = None if valid is None else np.ascontiguousarray(valid[:, ::-1])
        return levels if valid is None else (levels, valid)

    def digest(self) -> str:
        """Of the files' content and the boxes."""
        hash_ = hashlib.sha256(repr((self.preparation, self.variation, self.seed)).encode())
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


def object_windows(
    image: LabelledImage, settings: Settings, seed: Sequence[int] = (0,)
) -> tuple[list[list[NDArray[np.uint8]]], list[tuple[str, str]]]:
    """A window (height, width) of each usable object with its copies after it; and the others with the reason."""
    width_px, height_px = window_size(settings)
    raw, valid, boxes = image.read_levels()
    preparation, variation = preparation_of(settings.values), variation_of(settings.values)
    levels, _ = preparation.picture(raw, valid)
    size = (levels.shape[1], levels.shape[0])
    made: list[list[NDArray[np.uint8]]] = []
    frames: list[Box] = []
    left_out = []
    for number, box in enumerate(boxes, 1):
        name = f"{image.listed.name}, object {number}"
        shown = preparation.object_in_prepared(box, image.width_px, image.height_px)
        grown = window_box(shown, float(settings.values[MARGIN_KEY] or 0.0), (width_px, height_px), size)
        window = None if grown is None else window_of(levels, grown, width_px, height_px)
        if grown is None or window is None:
            left_out.append((name, "its window is larger than the picture"))
            continue
        if float(window[1:-1, 1:-1].std()) < _LEAST_DEVIATION:
            left_out.append((name, "its window is of one level"))
            continue
        made.append([window])
        frames.append(grown)
    for copy in range(variation.copies if frames else 0):
        rng = np.random.default_rng([*seed, 0, copy])
        varied = preparation.picture(variation.levels(raw, rng), valid)[0] if variation.changes_levels else levels
        for windows, frame in zip(made, frames, strict=True):
            window = window_of(varied, variation.box(frame, width_px, size, rng), width_px, height_px)
            if window is not None:  # rounding to the window's proportions may lead out of the picture
                windows.append(variation.turned(window, copy))
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
    groups: list[list[NDArray[np.uint8]]] = []  # an object and its copies
    group_recordings: list[int] = []
    left_out: list[tuple[str, str]] = []
    for number, (image, recording) in enumerate(zip(labelled.images, recordings, strict=True)):
        made, reasons = object_windows(image, settings, (core_seed(seed), number))
        groups += made
        group_recordings += [number_of[recording]] * len(made)
        left_out += reasons
    if len(groups) < 2:
        raise UserError(f"only {len(groups)} objects can be trained on, and at least two are needed; label more, or check the boxes")
    fraction = float(settings.values[VALIDATION_FRACTION_KEY] or 0.0)
    training, validation = _core.split_by_recording(group_recordings, fraction, core_seed(seed))
    held_back = {group_recordings[index] for index in validation}
    for_training, for_validation = _split_pictures(
        settings,
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
    most = max(len(groups[index]) for index in training)
    kept = [(index, copy) for copy in range(most) for index in training if copy < len(groups[index])]
    return TrainingSamples(
        positives=np.stack([groups[index][copy] for index, copy in kept]),
        recordings=[group_recordings[index] for index, _ in kept],
        objects=len(training),
        validation_positives=np.stack([groups[index][0] for index in validation]) if validation else nothing,
        validation_negatives=validation_negatives,
        negatives=for_training,
        validation_pictures=for_validation,
        left_out=left_out,
    )


def _split_pictures(
    settings: Settings,
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
    preparation = preparation_of(settings.values)
    # what validates is as it will be in use
    sides = (
        PictureSource([], [], [], preparation, variation_of(settings.values), core_seed(seed)),
        PictureSource([], [], [], preparation),
    )
    for index, image in enumerate(negatives):
        side = sides[index in validating]
        side.paths.append(image.path)
        side.boxes.append(())
        side.mirrored.append(image.name in mirrored)
    return sides
