"""What the run of a sonar survey leaves beside the files of every run. Each may be absent and is then None."""

import csv
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli.errors import UserError
from ssjs_cli.formats.number_table import FloatArray, IntArray, read_table
from ssjs_cli.formats.run_directory import (
    ALTITUDE_FILE,
    CONTACTS_FILE,
    COVERAGE_FILE,
    SIGHTINGS_FILE,
    SNIPPETS_FOLDER,
    WATERFALL_FOLDER,
    WATERFALL_INDEX_FILE,
)
from ssjs_cli.report.json_object import RUN_AGAIN, read_json_object


@dataclass(frozen=True)
class Altitudes:
    """time_s, altitude_m (n,): of the sonar or the vehicle over the bottom."""

    time_s: FloatArray
    altitude_m: FloatArray


@dataclass(frozen=True)
class CoverageGrid:
    """passes (rows, columns): how often each cell was listened to; rows along x, columns along y, cells of cell_m, the first one's
    corner at corner_m. silent_s (k, 2): from when to when the sonar was not listened to."""

    passes: IntArray
    corner_m: FloatArray
    cell_m: float
    silent_s: FloatArray


@dataclass(frozen=True)
class WaterfallPictures:
    """index: the waterfall's own description; folder: where its pictures are."""

    index: dict[str, Any]
    folder: Path


@dataclass(frozen=True)
class SurveyFiles:
    """contacts, sightings: the rows of their tables as text by the name of the column."""

    contacts: list[dict[str, str]] | None = None
    sightings: list[dict[str, str]] | None = None
    snippets: Path | None = None
    altitudes: Altitudes | None = None
    coverage: CoverageGrid | None = None
    waterfall: WaterfallPictures | None = None
    time_origin_s: float = 0.0

    def counted_from(self, origin_s: float) -> "SurveyFiles":
        altitudes = self.altitudes
        if altitudes is not None:
            altitudes = replace(altitudes, time_s=altitudes.time_s - origin_s)
        coverage = self.coverage
        if coverage is not None:
            coverage = replace(coverage, silent_s=coverage.silent_s - origin_s)
        return replace(self, altitudes=altitudes, coverage=coverage, time_origin_s=origin_s)


def read_survey_files(run_dir: Path) -> SurveyFiles:
    snippets = run_dir / SNIPPETS_FOLDER
    return SurveyFiles(
        contacts=_read_rows(run_dir / CONTACTS_FILE),
        sightings=_read_rows(run_dir / SIGHTINGS_FILE),
        snippets=snippets if snippets.is_dir() else None,
        altitudes=_read_altitudes(run_dir / ALTITUDE_FILE),
        coverage=_read_coverage(run_dir / COVERAGE_FILE),
        waterfall=_read_waterfall(run_dir / WATERFALL_FOLDER),
    )


def _read_rows(path: Path) -> list[dict[str, str]] | None:
    if not path.is_file():
        return None
    with path.open(encoding="utf-8", newline="") as file:
        return [{key: value or "" for key, value in row.items() if key is not None} for row in csv.DictReader(file)]


def _read_altitudes(path: Path) -> Altitudes | None:
    if not path.is_file():
        return None
    table = read_table(path, required=("time_s", "altitude_m"))
    return Altitudes(table["time_s"], table["altitude_m"]) if table.rows else None


def _read_coverage(path: Path) -> CoverageGrid | None:
    if not path.is_file():
        return None
    try:
        with np.load(path, allow_pickle=False) as archive:
            passes = archive["passes"].astype(np.int64)
            return CoverageGrid(passes, archive["corner_m"], float(archive["cell_m"]), archive["silent_s"].reshape(-1, 2))
    except (ValueError, KeyError, OSError) as error:
        raise UserError(f"{path}: cannot be read ({error}); {RUN_AGAIN}") from error


def _read_waterfall(folder: Path) -> WaterfallPictures | None:
    path = folder / WATERFALL_INDEX_FILE
    index = read_json_object(path)
    return None if index is None else WaterfallPictures(index, folder)
