"""Five threshold methods on real sonar images: side-scan tiles with and without objects, forward-looking frames.

SSJS_DATA=... python benchmarks/segmentation_real.py                the tables of docs/segmentation.md
SSJS_DATA=... python benchmarks/segmentation_real.py --choose all   the search on the first half that the settings come from

Side-scan recordings are split by the time in their names, those within five seconds of each other being one (two frequencies of one
pass): every other recording is for choosing, the rest for scoring. Forward-looking frames: the first half of the sequence is for
choosing. All on one thread a process; results do not depend on --jobs.
"""

import argparse
import itertools
import re
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from datetime import datetime
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy import ndimage
from step_times import data_directory, machine_text

from ssjs_cli import _core
from ssjs_cli.formats.image_file import read_image, read_mask
from ssjs_cli.segmentation.one_comparison import METHODS

Chain = dict[str, Any]

SAME_RECORDING_S = 5.0
WALL_CLASS, FIRST_CLASS, LAST_CLASS = 11, 1, 10
SMALLEST_FLS_OBJECT_PX = 100
SIDE_SCAN, QUIET, FORWARD_LOOKING = "sdvd", "sdvd/negatives", "marine_debris_fls"
CHOOSING, SCORING, ALL = "choosing", "scoring", "all"

#: The paper's chain with its settings for side-scan pictures of low resolution: no filter, no gain normalisation.
RAW: Chain = {"improved_otsu.spot_px": 15}
#: Chosen with --choose: the best hit rate with a recall of at least 0.78 on the first half.
FILTERED: Chain = {
    "filter.kind": "gaussian",
    "filter.sigma_px": 2.5,
    "gain.kind": "local_mean",
    "gain.window_px": 51,
    "gain.target_level": 40.0,
    "improved_otsu.spot_px": 15,
    "smallest_area_px": 15,
    "dilations": 3,
}
#: The paper's settings for forward-looking pictures but for the gate, and with gain normalisation.
FLS_RAW: Chain = {"improved_otsu.spot_px": 40}
FLS_GAIN: Chain = {**FLS_RAW, "gain.kind": "local_mean"}

AXES: dict[str, Sequence[Any]] = {
    "filter.sigma_px": (1.0, 1.5, 2.0, 2.5),
    "gain.window_px": (51, 65, 97, 129),
    "gain.target_level": (40.0, 64.0, 90.0),
    "dilations": (1, 2, 3),
    "power_law.enabled": (False, True),
    "smallest_area_px": (15, 30),
}
#: Along these a neighbour's score says something about a setting's own.
ORDERED_AXES = ("filter.sigma_px", "gain.window_px", "gain.target_level", "dilations")
FIXED: Chain = {"filter.kind": "gaussian", "gain.kind": "local_mean", "improved_otsu.spot_px": 15}
RECALL_TO_KEEP = 0.78
LOCAL_AXES: dict[str, Sequence[Any]] = {
    "filter.sigma_px": (1.5, 2.0, 2.5, 3.0),
    "local.window_px": (21, 31, 51),
    "local.offset_levels": (8.0, 12.0, 16.0, 20.0, 26.0),
    "dilations": (1, 2),
    "gain.kind": ("none", "local_mean"),
    "smallest_area_px": (30, 45, 60),
}
LOCAL_FIXED: Chain = {
    "method": "local",
    "filter.kind": "gaussian",
    "gain.window_px": 65,
    "gain.target_level": 40.0,
    "power_law.enabled": False,
}


@dataclass(frozen=True)
class Picture:
    """valid: without padding, or the fan without walls; truth: the core's; group: the recording."""

    levels: Any
    valid: Any
    truth: Any
    group: str


@dataclass(frozen=True)
class Score:
    hit_rate: float | None
    recall: float | None
    mask_iou: float | None
    false_regions: float
    false_area: float
    centroid_error_px: float | None
    found: float | None
    second_pass: float | None
    hit_band: tuple[float, float] | None

    @property
    def hit_and_quiet(self) -> float:
        """hit x (1 - false area)."""
        return (self.hit_rate or 0.0) * (1.0 - self.false_area)


def recordings(paths: Iterable[Path]) -> list[list[Path]]:
    """In the order of time."""

    def time_of(path: Path) -> datetime:
        match = re.search(r"_(\d{14})", path.name)
        if match is None:
            raise SystemExit(f"{path}: has no time in its name")
        return datetime.strptime(match.group(1), "%Y%m%d%H%M%S")

    groups: list[list[Path]] = []
    for path in sorted(paths, key=lambda path: (time_of(path), path.name)):
        if not groups or (time_of(path) - time_of(groups[-1][-1])).total_seconds() > SAME_RECORDING_S:
            groups.append([])
        groups[-1].append(path)
    return groups


@cache
def side_scan(half: str, without_padding: bool) -> tuple[Picture, ...]:
    folder = data_directory() / SIDE_SCAN
    groups = recordings((folder / "images").glob("*.png"))
    chosen = {CHOOSING: groups[0::2], SCORING: groups[1::2], ALL: groups}[half]
    pictures = []
    for group in chosen:
        for path in group:
            levels = read_image(path).levels
            truth = _core.GroundTruth.of_labels(read_mask(folder / "masks" / path.name))  # one effigy a tile
            pictures.append(Picture(levels, padding_mask(levels) if without_padding else None, truth, group[0].name))
    return tuple(pictures)


@cache
def quiet_side_scan(without_padding: bool) -> tuple[Picture, ...]:
    pictures = []
    for path in sorted((data_directory() / QUIET).iterdir()):
        levels = read_image(path).levels
        truth = _core.GroundTruth.of_mask(np.zeros(levels.shape, dtype=np.uint8))
        pictures.append(Picture(levels, padding_mask(levels) if without_padding else None, truth, path.name))
    return tuple(pictures)


@cache
def forward_looking(half: str) -> tuple[Picture, ...]:
    """The fan is where any frame ever shows an echo; walls are masked away; objects of more than 100 pixels count."""
    folder = data_directory() / FORWARD_LOOKING
    paths = sorted((folder / "images").glob("*.png"), key=lambda path: int(path.stem.rsplit("-", 1)[-1]))
    frames = [read_image(path).levels for path in paths]
    classes = [read_image(folder / "masks" / path.name).levels for path in paths]
    fan = ndimage.binary_fill_holes(np.max(frames, axis=0) > 0)
    middle = len(paths) // 2
    span = {CHOOSING: slice(0, middle), SCORING: slice(middle, None), ALL: slice(None)}[half]
    pictures = []
    for path, levels, labels in list(zip(paths, frames, classes, strict=True))[span]:
        valid = np.where(fan & (labels != WALL_CLASS), 255, 0).astype(np.uint8)
        pictures.append(Picture(levels, valid, _core.GroundTruth.of_labels(objects_of_classes(labels)), path.name))
    return tuple(pictures)


def padding_mask(levels: Any) -> Any:
    """What --padding 0 does."""
    return np.where(_core.fill_holes((levels > 0).astype(np.uint8)) != 0, 255, 0).astype(np.uint8)


def objects_of_classes(classes: Any) -> Any:
    objects = np.zeros(classes.shape, dtype=np.int32)
    count = 0
    for value in range(FIRST_CLASS, LAST_CLASS + 1):
        labels, parts = ndimage.label(classes == value, structure=np.ones((3, 3)))
        for part in range(1, parts + 1):
            inside = labels == part
            if int(inside.sum()) > SMALLEST_FLS_OBJECT_PX:
                count += 1
                objects[inside] = count
    return objects


def pictures_of(data: str, half: str, without_padding: bool) -> tuple[Picture, ...]:
    if data == SIDE_SCAN:
        return side_scan(half, without_padding)
    return quiet_side_scan(without_padding) if data == QUIET else forward_looking(half)


def score(data: str, half: str, chain: Chain, without_padding: bool) -> Score:
    """Hit rate over all objects; recall, mask IoU, false regions and false area are means over the images; the centroid error is the
    mean, over all objects, of the distance to the nearest region's centroid, so that a miss counts as well."""
    _core.set_image_threads(1)
    hits: dict[str, list[int]] = {}
    recalls, ious, regions, areas, errors, fired, found, objects = [], [], [], [], [], [], 0, 0
    for picture in pictures_of(data, half, without_padding):
        result = _core.segment(picture.levels, picture.valid, chain)
        answer = _core.segmentation_score(result["regions"], picture.truth)
        count = len(answer["objects"])
        objects += count
        hit = hits.setdefault(picture.group, [0, 0])
        hit[0] += answer["hits"]
        hit[1] += count
        found += count - answer["false_negatives"]
        regions.append(answer["false_positives"])
        areas.append(answer["false_area_fraction"])
        if count:
            recalls.append(answer["pixel_recall"])
            ious.append(answer["mask_iou"])
            centroids = result["regions"].centroid_px
            if len(centroids):
                errors += [float(np.hypot(*(centroids - true).T).min()) for true in picture.truth.centroid_px]
        if result["improved_otsu"] is not None:
            fired.append(result["improved_otsu"]["second_pass_fired"])
    counts = np.array(list(hits.values()))
    return Score(
        hit_rate=float(counts[:, 0].sum() / objects) if objects else None,
        recall=mean(recalls),
        mask_iou=mean(ious),
        false_regions=float(np.mean(regions)),
        false_area=float(np.mean(areas)),
        centroid_error_px=mean(errors),
        found=found / objects if objects else None,
        second_pass=mean(fired),
        hit_band=bootstrap_band(counts) if objects else None,
    )


def mean(values: Sequence[float]) -> float | None:
    return float(np.mean(values)) if values else None


def bootstrap_band(counts: Any) -> tuple[float, float]:
    """5 % and 95 % of the hit rate over recordings drawn anew. counts (recordings, 2): hits, objects."""
    rng = np.random.default_rng(1)
    drawn = counts[rng.integers(0, len(counts), (1000, len(counts)))].sum(axis=1)
    low, high = np.quantile(drawn[:, 0] / drawn[:, 1], (0.05, 0.95))
    return float(low), float(high)


def shown(value: float | None, digits: int = 2) -> str:
    return "–" if value is None else f"{value:.{digits}f}"


def table(title: str, rows: Sequence[tuple[str, Score]]) -> None:
    print(f"\n{title}\n")
    heads = ["", "hit rate [5 %, 95 %]", "recall", "mask IoU", "found", "false regions", "false area %", "centroid px", "second pass"]
    print("| " + " | ".join([*heads, "hit x (1 - false area)"]) + " |")
    print("|---" * (len(heads) + 1) + "|")
    for name, entry in rows:
        band = "" if entry.hit_band is None else f" [{entry.hit_band[0]:.2f}, {entry.hit_band[1]:.2f}]"
        numbers = [
            *(shown(entry.hit_rate, 3) + band, shown(entry.recall, 3), shown(entry.mask_iou), shown(entry.found)),
            *(shown(entry.false_regions, 1), shown(100 * entry.false_area, 1), shown(entry.centroid_error_px, 1)),
            *(shown(entry.second_pass), shown(None if entry.hit_rate is None else entry.hit_and_quiet, 3)),
        ]
        print(f"| {name} | " + " | ".join(numbers) + " |")


def best_preset() -> Chain:
    return {key.removeprefix("segmentation."): value for key, value in _core.segmentation_preset("best").items()}


Task = tuple[str, str, str, Chain, bool]


def scored(task: Task) -> Score:
    _, data, half, chain, without_padding = task
    return score(data, half, chain, without_padding)


def five(name: str, data: str, half: str, chain: Chain, without_padding: bool) -> list[Task]:
    return [(f"{name}: {method}", data, half, {**chain, "method": method}, without_padding) for method in METHODS]


def print_tables(executor: ProcessPoolExecutor) -> None:
    best = best_preset()
    sections: list[tuple[str, list[Task]]] = [
        ("sdvd, second half", [
            *five("paper's chain", SIDE_SCAN, SCORING, RAW, False),
            *five("filtered chain", SIDE_SCAN, SCORING, FILTERED, True),
            *five("`best`", SIDE_SCAN, SCORING, best, True),
        ]),
        ("sdvd, all tiles", [
            *five("paper's chain", SIDE_SCAN, ALL, RAW, False),
            ("filtered chain: improved-otsu", SIDE_SCAN, ALL, FILTERED, True),
            ("`best`", SIDE_SCAN, ALL, best, True),
        ]),
        ("sdvd/negatives: nothing there", [
            *five("paper's chain", QUIET, ALL, RAW, False),
            *five("filtered chain", QUIET, ALL, FILTERED, True),
            ("`best`", QUIET, ALL, best, True),
        ]),
        ("marine_debris_fls, all frames", [
            *five("raw", FORWARD_LOOKING, ALL, FLS_RAW, False),
            *five("gain", FORWARD_LOOKING, ALL, FLS_GAIN, False),
            ("`best`", FORWARD_LOOKING, ALL, best, False),
        ]),
        ("marine_debris_fls, second half", five("gain", FORWARD_LOOKING, SCORING, FLS_GAIN, False)),
    ]  # fmt: skip
    for title, tasks in sections:
        table(title, [(task[0], answer) for task, answer in zip(tasks, executor.map(scored, tasks), strict=True)])


def choose(executor: ProcessPoolExecutor, method: str) -> None:
    """A setting is judged by the mean over itself and its neighbours on the grid: the highest of many noisy numbers flatters."""
    grids = {"improved-otsu": (AXES, FIXED), "local": (LOCAL_AXES, LOCAL_FIXED)}
    for name, (axes, fixed) in grids.items():
        if method not in (name, "all"):
            continue
        grid = [dict(zip(axes, values, strict=True)) for values in itertools.product(*axes.values())]
        tasks: list[Task] = [("", SIDE_SCAN, CHOOSING, {**fixed, **entry}, True) for entry in grid]
        scores = list(executor.map(scored, tasks, chunksize=8))
        print(f"\n{name}: {len(grid)} settings on the first half")
        hit, recall, quiet = (
            neighbour_mean([getattr(entry, key) for entry in scores], axes) for key in ("hit_rate", "recall", "hit_and_quiet")
        )
        for title, value in (
            (f"hit rate where recall >= {RECALL_TO_KEEP}", np.where(recall >= RECALL_TO_KEEP, hit, 0.0)),
            ("hit x (1 - false area)", quiet),
        ):
            print(title)
            for index in np.argsort(-value, kind="stable")[:5]:
                entry = scores[index]
                numbers = f"hit {entry.hit_rate:.3f} recall {entry.recall:.3f} false area {entry.false_area:.3f}"
                print(f"  {value[index]:.3f} ({numbers}) {grid[index]}")


def neighbour_mean(values: Sequence[float | None], axes: dict[str, Sequence[Any]]) -> Any:
    cube = np.array(values, dtype=np.float64).reshape([len(steps) for steps in axes.values()])
    size = [3 if name in ORDERED_AXES or name.startswith("local.") else 1 for name in axes]
    return ndimage.uniform_filter(cube, size=size, mode="nearest").ravel()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--choose", choices=("improved-otsu", "local", "all"), help="search the grid of a method on the first half")
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    print(machine_text())
    with ProcessPoolExecutor(arguments.jobs) as executor:
        if arguments.choose:
            choose(executor, arguments.choose)
        else:
            print_tables(executor)


if __name__ == "__main__":
    main()
