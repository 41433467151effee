"""truth_seabed.npz: the depth of the seabed on a grid, where it is known, as of a simulated survey or a sounded one."""

import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ssjs_cli.errors import UserError
from ssjs_cli.formats.number_table import FloatArray, holds_file
from ssjs_cli.formats.zip_member import check_archive_size

SURFACE_FILE = "truth_seabed.npz"
MAX_BYTES = 1024**3
#: Depths are kept to a tenth of a millimetre.
STEP_M = 1e-4
_ARRAYS = ("from_m", "cell_m", "depth_m")


@dataclass(frozen=True)
class TrueSurface:
    """depth_m (rows, columns): at from_m + cell_m (row, column) of the mission's x and y; beyond its border that of the border."""

    from_m: FloatArray
    cell_m: float
    depth_m: NDArray[np.float32]

    def at(self, x_m: FloatArray, y_m: FloatArray) -> FloatArray:
        """(n,), between the points of the grid by their distance."""
        rows, columns = self.depth_m.shape
        across = np.clip((x_m - self.from_m[0]) / self.cell_m, 0.0, rows - 1.0)
        along = np.clip((y_m - self.from_m[1]) / self.cell_m, 0.0, columns - 1.0)
        row = np.minimum(across.astype(np.int64), rows - 2)
        column = np.minimum(along.astype(np.int64), columns - 2)
        across, along = across - row, along - column
        depth = self.depth_m.astype(np.float64, copy=False)
        near = depth[row, column] * (1.0 - along) + depth[row, column + 1] * along
        far = depth[row + 1, column] * (1.0 - along) + depth[row + 1, column + 1] * along
        return np.asarray(near * (1.0 - across) + far * across)


def read_true_surface(directory: Path) -> TrueSurface | None:
    path = directory / SURFACE_FILE
    if not holds_file(path):
        return None
    try:
        check_archive_size(path, MAX_BYTES)
        with np.load(path, allow_pickle=False) as archive:
            arrays = {name: np.asarray(archive[name]) for name in _ARRAYS}
    except (zipfile.BadZipFile, ValueError, EOFError, KeyError, OSError) as error:
        if isinstance(error, OSError) and error.errno is not None:
            raise
        raise UserError(f"{path}: is damaged, or holds no {', '.join(_ARRAYS)} ({error}); simulate the mission again") from error
    from_m, cell_m, depth_m = (arrays[name] for name in _ARRAYS)
    numbers = all(array.dtype.kind == "f" and np.isfinite(array).all() for array in arrays.values())
    if not numbers or from_m.shape != (2,) or cell_m.size != 1 or not cell_m > 0.0 or depth_m.ndim != 2 or min(depth_m.shape) < 2:
        raise UserError(f"{path}: from_m (2), cell_m (1, positive) and depth_m (2 or more rows and columns) must be finite numbers")
    return TrueSurface(from_m.astype(np.float64), float(cell_m.reshape(-1)[0]), depth_m.astype(np.float32))


def write_true_surface(directory: Path, surface: TrueSurface) -> None:
    depth_m = (np.round(surface.depth_m.astype(np.float64) / STEP_M) * STEP_M).astype(np.float32)
    np.savez_compressed(directory / SURFACE_FILE, from_m=surface.from_m, cell_m=np.float64(surface.cell_m), depth_m=depth_m)
