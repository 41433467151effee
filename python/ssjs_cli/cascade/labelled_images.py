"""Images with the boxes of their objects, from masks or from annotations; what cannot be used is named, and left out."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ssjs_cli import _core
from ssjs_cli.cascade.settings import MASK_GAP_KEY, MIN_OBJECT_KEY
from ssjs_cli.config import Settings
from ssjs_cli.errors import UserError
from ssjs_cli.formats.annotations.annotation_source import Annotations, BoxFinder, read_annotations
from ssjs_cli.formats.annotations.boxes import Box
from ssjs_cli.formats.file_digest import file_digest
from ssjs_cli.formats.image_file import read_image
from ssjs_cli.formats.image_levels import LevelImage, Mask
from ssjs_cli.segmentation.image_list import ListedImage, listed_images
from ssjs_cli.segmentation.picture_input import MaskSource


@dataclass(frozen=True)
class LabelSource:
    """Exactly one of masks and annotations; label: only objects of that class; mirrored: see mirrored_names()."""

    masks: Path | None = None
    annotations: Path | None = None
    label: str | None = None
    mirrored: str | None = None


@dataclass(frozen=True)
class LabelledImage:
    """boxes: of the objects, within the picture; digest: of the file; mirrored: shadows fall the other way than in the other images."""

    listed: ListedImage
    boxes: tuple[Box, ...]
    width_px: int
    height_px: int
    digest: str
    mirrored: bool = False

    def read_levels(self) -> tuple[NDArray[np.uint8], NDArray[np.uint8] | None, tuple[Box, ...]]:
        """In 8 bits, where they are valid, and the boxes, all turned left to right where the image is mirrored."""
        picture = read_image(self.listed.path)
        levels: NDArray[np.uint8] = _core.in_8_bits(picture.levels, picture.valid)
        if not self.mirrored:
            return levels, picture.valid, self.boxes
        boxes = tuple((self.width_px - left - width, top, width, height) for left, top, width, height in self.boxes)
        valid = None if picture.valid is None else np.ascontiguousarray(picture.valid[:, ::-1])
        return np.ascontiguousarray(levels[:, ::-1]), valid, boxes


@dataclass(frozen=True)
class LabelledImages:
    """problems: name and reason of what could not be used; unlabelled: images that the annotations do not name."""

    images: list[LabelledImage]
    problems: list[tuple[str, str]] = field(default_factory=list)
    unlabelled: int = 0

    @property
    def objects(self) -> int:
        return sum(len(image.boxes) for image in self.images)


def label_source(masks: str | None, annotations: str | None, label: str | None, mirrored: str | None = None) -> LabelSource:
    if (masks is None) == (annotations is None):
        raise UserError("give either --masks DIR or --annotations FILE: they say where the objects are")
    if masks is not None and label is not None:
        raise UserError("--label: masks have no classes; use --annotations, or leave --label out")
    if masks is not None and not Path(masks).is_dir():
        raise UserError(f"{masks}: is no folder; --masks takes the folder that holds a mask for each image")
    return LabelSource(None if masks is None else Path(masks), None if annotations is None else Path(annotations), label, mirrored)


def read_labelled_images(arguments: Sequence[str], source: LabelSource, settings: Settings) -> LabelledImages:
    """The images of a command line (files, folders, patterns) with their objects, in their order."""
    listed = listed_images(arguments)
    annotations = None if source.annotations is None else read_annotations(source.annotations).of_label(source.label)
    if annotations is not None:
        listed = _with_annotated(listed, arguments, annotations)
    finder = None if annotations is None else BoxFinder(annotations)
    images: list[LabelledImage] = []
    problems = list(annotations.problems) if annotations is not None else []
    if annotations is not None and finder is not None:
        known = [image.path for image in listed]
        problems += [(name, f"{annotations.path}: names '{name}', which is not among the images; add it") for name in finder.unfound(known)]
    unlabelled = 0
    turned = mirrored_names(listed, source.mirrored)
    for entry in listed:
        try:
            image = read_image(entry.path)
            if finder is None:
                boxes = _boxes_of_mask(MaskSource(source.masks or Path()).read_for(entry.path, image), image, settings)
            else:
                found = finder.find(entry.path)
                unlabelled += found is None
                boxes, refused = [], []
                for labelled in found or []:
                    try:
                        boxes.append(labelled.in_pixels(image.width_px, image.height_px))
                    except UserError as error:
                        refused.append((entry.name, str(error)))
                problems += refused
                if refused and not boxes:
                    continue  # what such an image shows is not known
        except UserError as error:
            problems.append((entry.name, str(error)))
            continue
        least = int(settings.values[MIN_OBJECT_KEY] or 1)
        kept = tuple(box for box in boxes if box[2] >= least and box[3] >= least)
        images.append(LabelledImage(entry, kept, image.width_px, image.height_px, file_digest(entry.path), entry.name in turned))
    if not images:
        raise UserError("\n".join(reason for _, reason in problems[:20]) or "no image could be used")
    return LabelledImages(images, problems, unlabelled)


def _with_annotated(listed: list[ListedImage], arguments: Sequence[str], annotations: Annotations) -> list[ListedImage]:
    """Annotations may name images in folders below the one given: those belong to it."""
    folders = [Path(argument) for argument in arguments if Path(argument).is_dir()]
    if annotations.by_stem or not folders:
        return listed
    below = []
    for name in annotations.images:
        for folder in folders:
            candidate = folder / name.replace("\\", "/")
            if "/" in name and candidate.is_file():
                below.append(str(candidate))
                break
    return listed_images([*(str(image.path) for image in listed), *below]) if below else listed


def _boxes_of_mask(mask: Mask, image: LevelImage, settings: Settings) -> list[Box]:
    """Around the parts of the mask, those near each other in one."""
    regions = _core.find_regions(mask, image.levels)
    if len(regions) == 0:
        return []
    groups = _core.group_regions(regions, float(settings.values[MASK_GAP_KEY] or 0.0))
    return [(int(x), int(y), int(width), int(height)) for x, y, width, height in groups["bounding_box_px"]]


def mirrored_names(images: Sequence[ListedImage], pattern: str | None) -> set[str]:
    """Images whose name the pattern matches are of the other side of the vehicle: there, shadows fall the other way."""
    if pattern is None:
        return set()
    try:
        expression = re.compile(pattern)
    except re.error as error:
        raise UserError(f"--mirrored {pattern}: is no regular expression ({error}); for example '^right_'") from error
    return {image.name for image in images if expression.search(image.name)}


def recording_names(images: Sequence[ListedImage], pattern: str | None) -> list[str]:
    """What tells an image's recording: the part of its name that `pattern` matches (its first group, if it has one). An image that does
    not match, and every image without a pattern, is a recording of its own."""
    if pattern is None:
        return [image.name for image in images]
    try:
        expression = re.compile(pattern)
    except re.error as error:
        raise UserError(f"--recordings {pattern}: is no regular expression ({error}); for example '(\\d{{8}}_\\d{{6}})'") from error
    matches = [expression.search(image.name) for image in images]
    return [
        image.name if match is None else match.group(1 if expression.groups else 0) or image.name
        for image, match in zip(images, matches, strict=True)
    ]
