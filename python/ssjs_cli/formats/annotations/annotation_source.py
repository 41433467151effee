"""The boxes of an image, whatever form they are written in."""

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

from ssjs_cli.errors import UserError
from ssjs_cli.formats.annotations.box_csv import read_box_csv
from ssjs_cli.formats.annotations.boxes import LabelledBox
from ssjs_cli.formats.annotations.coco import read_coco
from ssjs_cli.formats.annotations.info_dat import read_info_dat
from ssjs_cli.formats.annotations.voc import read_voc_file
from ssjs_cli.formats.annotations.yolo import CLASS_FILE, read_class_names, read_yolo_file

INFO_SUFFIXES = (".dat", ".txt", ".info")


@dataclass(frozen=True)
class Annotations:
    """images: boxes by the name that the annotations use; by_stem: names are those of files without their suffix; problems: what of
    the annotations cannot be used, and why."""

    kind: str
    path: Path
    images: dict[str, list[LabelledBox]]
    by_stem: bool = False
    problems: list[tuple[str, str]] = field(default_factory=list)

    def labels(self) -> list[str]:
        return sorted({box.label for boxes in self.images.values() for box in boxes})

    def of_label(self, label: str | None) -> "Annotations":
        """Only the boxes of that class; None: of all."""
        if label is None:
            return self
        if label not in self.labels():
            known = ", ".join(f"'{name}'" for name in self.labels()) or "none"
            raise UserError(f"{self.path}: no box has the label '{label}'; its labels are {known}")
        chosen = {name: [box for box in boxes if box.label == label] for name, boxes in self.images.items()}
        return Annotations(self.kind, self.path, chosen, self.by_stem, self.problems)


class BoxFinder:
    """Boxes by the file of an image: the annotated name that is the same up to folders in front."""

    def __init__(self, annotations: Annotations) -> None:
        self._annotations = annotations
        self._by_last: dict[str, list[str]] = defaultdict(list)
        for name in annotations.images:
            self._by_last[self._parts(name)[-1]].append(name)

    def find(self, image: Path) -> list[LabelledBox] | None:
        """None: the annotations do not name the image."""
        parts = self._parts(image.absolute().as_posix())
        best, best_depth = None, 0
        for name in self._by_last.get(parts[-1], ()):
            depth = _common_end(parts, self._parts(name))
            if depth > best_depth:
                best, best_depth = name, depth
            elif depth == best_depth and best is not None:
                raise UserError(
                    f"{self._annotations.path}: both '{best}' and '{name}' may mean {image}; give names with their folders there"
                )
        return None if best is None else self._annotations.images[best]

    def unfound(self, images: list[Path]) -> Iterator[str]:
        """Names of the annotations that none of the images answers to."""
        known = {self._parts(image.as_posix())[-1] for image in images}
        for name in self._annotations.images:
            if self._parts(name)[-1] not in known:
                yield name

    def _parts(self, name: str) -> tuple[str, ...]:
        path = PurePosixPath(name.replace("\\", "/"))
        return (path.with_suffix("") if self._annotations.by_stem and path.suffix else path).parts or ("",)


def _common_end(one: tuple[str, ...], other: tuple[str, ...]) -> int:
    depth = 0
    for a, b in zip(reversed(one), reversed(other), strict=False):
        if a != b:
            break
        depth += 1
    return depth


def read_annotations(path: Path) -> Annotations:
    """By the kind of the path (see the package). A folder's files that cannot be read are among the problems."""
    if path.is_dir():
        return _folder(path)
    if not path.exists():
        raise UserError(f"{path}: No such file or directory; check the path of --annotations")
    suffix = path.suffix.lower()
    if suffix == ".json":
        return Annotations("COCO", path, read_coco(path))
    if suffix == ".csv":
        return Annotations("table", path, read_box_csv(path))
    if suffix == ".xml":
        name, boxes = read_voc_file(path)
        return Annotations("Pascal VOC", path, {name or path.name: boxes}, by_stem=not name)
    if suffix in INFO_SUFFIXES:
        return Annotations("info.dat", path, read_info_dat(path))
    raise UserError(
        f"{path}: is of no known kind; give .json (COCO), .csv, .xml (Pascal VOC), {', '.join(INFO_SUFFIXES)} (OpenCV), or a folder of "
        ".xml (Pascal VOC) or .txt (YOLO)"
    )


def _folder(path: Path) -> Annotations:
    entries = sorted(entry for entry in path.rglob("*") if entry.is_file() and not entry.name.startswith("."))
    xml = [entry for entry in entries if entry.suffix.lower() == ".xml"]
    texts = [entry for entry in entries if entry.suffix.lower() == ".txt" and entry.name != CLASS_FILE]
    if not xml and not texts:
        raise UserError(f"{path}: holds neither .xml (Pascal VOC) nor .txt (YOLO); give the folder of the annotations")
    class_names = [] if xml else read_class_names(path)
    images: dict[str, list[LabelledBox]] = {}
    problems = []
    for entry in xml or texts:
        try:
            boxes = read_voc_file(entry)[1] if xml else read_yolo_file(entry, class_names)
        except UserError as error:
            problems.append((entry.name, str(error)))
            continue
        images[entry.relative_to(path).as_posix()] = boxes
    if not images:
        raise UserError(problems[0][1])
    return Annotations("Pascal VOC" if xml else "YOLO", path, images, by_stem=True, problems=problems)
