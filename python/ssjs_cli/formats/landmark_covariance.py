"""landmark_covariance.npz of a run directory: the joint covariance of the rows of landmarks.csv, x, y, depth of each. At most 3.2 MB: runs
with more than 300 landmarks, and methods that do not know it, leave it out."""

import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from ssjs_cli.errors import UserError
from ssjs_cli.formats.number_table import FloatArray

LANDMARK_COVARIANCE_FILE = "landmark_covariance.npz"


def write_landmark_covariance(directory: Path, covariance: Any) -> None:
    """covariance (3n, 3n), or None where there is none; stored as its upper triangle, row by row."""
    if covariance is None:
        return
    values = np.asarray(covariance, dtype=np.float64)
    np.savez(directory / LANDMARK_COVARIANCE_FILE, upper=values[np.triu_indices(len(values))])


def read_landmark_covariance(directory: Path, landmarks: int) -> FloatArray | None:
    """(3n, 3n) of n landmarks, None where the run has left it out."""
    path = directory / LANDMARK_COVARIANCE_FILE
    if not path.is_file():
        return None
    try:
        with np.load(path, allow_pickle=False) as archive:
            upper = np.asarray(archive["upper"], dtype=np.float64)
    except (zipfile.BadZipFile, KeyError, ValueError, EOFError) as error:
        raise UserError(f"{path}: is damaged ({error}); run the mission again") from error
    rows = 3 * landmarks
    if upper.shape != (rows * (rows + 1) // 2,):
        raise UserError(f"{path}: holds {upper.size} numbers, which is no triangle of {landmarks} landmarks; run the mission again")
    covariance = np.zeros((rows, rows))
    covariance[np.triu_indices(rows)] = upper
    return covariance + np.triu(covariance, 1).T
