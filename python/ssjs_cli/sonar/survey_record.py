"""What a run keeps of a survey's pictures while the log streams by: a waterfall of bounded size, what was listened to, and, on disk, the
pings around every contact. Memory does not grow with the length of the mission but for a row of `reach` a second."""

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssjs_cli.formats.number_table import FloatArray

ByteImage = NDArray[np.uint8]

#: Pings before and after the one abeam of a contact.
PINGS_AROUND = 40
#: Rows of the whole waterfall: when there are more, neighbours become one.
MOST_ROWS = 10_000
#: Columns of it on each side.
MOST_COLUMNS_A_SIDE = 100
#: A row of `reach` stands for the pings of this time.
REACH_INTERVAL_S = 1.0
#: Bytes of the contacts' pictures that stay in memory; more go to a temporary file.
SPOOL_IN_MEMORY = 16_000_000


@dataclass(frozen=True)
class Picture:
    """grey (pings, columns) in ground range, port on the left, far range outside; 0 where nothing was listened to. first_index: of the
    first row's ping among those of its log; ping_interval_s: the usual time between two of them."""

    grey: ByteImage
    first_index: int
    nadir_column: int
    column_m: float
    ping_interval_s: float = 0.0


@dataclass(frozen=True)
class Reach:
    """time_s, altitude_m (n,); ground ranges (n, 4) port near, far, starboard near, far in m, NaN where the sonar was not listened to."""

    time_s: FloatArray
    altitude_m: FloatArray
    ranges_m: FloatArray


@dataclass(frozen=True)
class Stretch:
    """The block of pings with the most contacts, every pixel of it."""

    picture: Picture
    time_s: FloatArray
    log: str
    contacts: int


@dataclass
class SurveyRecord:
    """Fed block by block, in the order of time."""

    stretch: Stretch | None = None
    pings: int = 0
    pings_per_row: int = 1
    _rows: list[ByteImage] = field(default_factory=list)
    _row_times: list[FloatArray] = field(default_factory=list)
    _half_row: tuple[ByteImage, FloatArray] | None = None
    _row_count: int = 0
    _side: int = 0
    _group: int = 1
    column_m: float = 0.0
    _reach: list[FloatArray] = field(default_factory=list)
    _last_reach_s: float = -np.inf
    _spool: Any = field(default_factory=lambda: tempfile.SpooledTemporaryFile(max_size=SPOOL_IN_MEMORY))  # noqa: SIM115 - close()
    _places: list[tuple[int, tuple[int, int], int, int, float, float]] = field(default_factory=list)
    _ping_interval_s: float = 0.0

    def close(self) -> None:
        self._spool.close()

    def keep(self, picture: Mapping[str, Any]) -> int:
        """Puts the picture around a contact aside; the answer is what picture() takes."""
        grey: ByteImage = picture["grey"]
        offset = self._spool.seek(0, 2)
        self._spool.write(np.ascontiguousarray(grey).tobytes())
        shape = (int(grey.shape[0]), int(grey.shape[1]))
        nadir_column, column_m = int(picture["nadir_column"]), float(picture["column_m"])
        self._places.append((offset, shape, int(picture["first_index"]), nadir_column, column_m, self._ping_interval_s))
        return len(self._places) - 1

    def picture(self, number: int) -> Picture:
        offset, shape, first_index, nadir_column, column_m, interval_s = self._places[number]
        self._spool.seek(offset)
        pixels = np.frombuffer(self._spool.read(shape[0] * shape[1]), dtype=np.uint8)
        return Picture(pixels.reshape(shape), first_index, nadir_column, column_m, interval_s)

    def add_blocks(self, log: str, blocks: Sequence[Mapping[str, Any]], contacts: Sequence[Mapping[str, Any]]) -> None:
        for block in blocks:
            picture = Picture(block["grey"], int(block["first_index"]), int(block["nadir_column"]), float(block["column_m"]))
            if not len(picture.grey):
                continue
            time_s: FloatArray = block["time_s"]
            self.pings += len(time_s)
            if len(time_s) > 1:
                self._ping_interval_s = float(np.nanmedian(np.diff(time_s)))
            self._add_reach(time_s, block["altitude_m"], block["reach_m"])
            self._add_rows(picture, time_s)
            end = picture.first_index + len(time_s)
            here = sum(1 for contact in contacts if picture.first_index <= int(contact["index"]) < end)
            if here and (self.stretch is None or here > self.stretch.contacts):
                self.stretch = Stretch(picture, time_s, log, here)

    def reach(self) -> Reach:
        rows = np.concatenate(self._reach) if self._reach else np.zeros((0, 6))
        return Reach(rows[:, 0], rows[:, 1], rows[:, 2:])

    def waterfall(self) -> tuple[ByteImage, FloatArray]:
        """(rows, 2 columns a side) the whole survey, and (rows,) the time of each row."""
        if not self._rows:
            return np.zeros((0, 0), dtype=np.uint8), np.zeros(0)
        return np.concatenate(self._rows), np.concatenate(self._row_times)

    def _add_reach(self, time_s: FloatArray, altitude_m: FloatArray, reach_m: FloatArray) -> None:
        """The first ping of every second, and every ping at which a side falls silent or is heard again."""
        silent = np.isnan(reach_m[:, [0, 2]])
        changes = np.any(silent[1:] != silent[:-1], axis=1)
        tick = np.floor(np.nan_to_num(time_s) / REACH_INTERVAL_S)
        wanted = np.ones(len(time_s), dtype=bool)
        wanted[1:] = (tick[1:] != tick[:-1]) | changes
        wanted[0] = time_s[0] - self._last_reach_s >= REACH_INTERVAL_S
        wanted[:-1] |= changes
        wanted &= np.isfinite(time_s)
        self._reach.append(np.column_stack((time_s, altitude_m, reach_m))[wanted])
        if wanted.any():
            self._last_reach_s = float(time_s[wanted][-1])

    def _add_rows(self, picture: Picture, time_s: FloatArray) -> None:
        if not self._side:
            columns = max(picture.nadir_column, picture.grey.shape[1] - picture.nadir_column)
            self._group = -(-columns // MOST_COLUMNS_A_SIDE)
            self._side = -(-columns // self._group)
            self.column_m = picture.column_m * self._group
        rows = self._on_columns(picture)
        self._rows.append(rows if self.pings_per_row == 1 else np.zeros((0, rows.shape[1]), dtype=np.uint8))
        self._row_times.append(time_s if self.pings_per_row == 1 else np.zeros(0))
        if self.pings_per_row > 1:
            self._rows[-1], self._row_times[-1] = self._grouped(rows, time_s)
        self._row_count += len(self._rows[-1])
        if self._row_count > MOST_ROWS:
            self._halve()

    def _on_columns(self, picture: Picture) -> ByteImage:
        """The picture in the columns of the whole waterfall: cut or filled at the far ends, neighbouring columns averaged."""
        side, group = self._side, self._group
        width = side * group
        out = np.zeros((len(picture.grey), 2 * width), dtype=np.uint8)
        nadir = picture.nadir_column
        port = min(nadir, width)
        starboard = min(picture.grey.shape[1] - nadir, width)
        out[:, width - port : width] = picture.grey[:, nadir - port : nadir]
        out[:, width : width + starboard] = picture.grey[:, nadir : nadir + starboard]
        return _mean(out.reshape(len(out), 2 * side, group), axis=2)

    def _grouped(self, rows: ByteImage, time_s: FloatArray) -> tuple[ByteImage, FloatArray]:
        """Groups of pings_per_row; what is left of a block waits for the next."""
        if self._half_row is not None:
            rows, time_s = np.concatenate((self._half_row[0], rows)), np.concatenate((self._half_row[1], time_s))
        whole = len(rows) // self.pings_per_row * self.pings_per_row
        self._half_row = (rows[whole:], time_s[whole:])
        grouped = rows[:whole].reshape(-1, self.pings_per_row, rows.shape[1])
        return _mean(grouped, axis=1), time_s[:whole].reshape(-1, self.pings_per_row).mean(axis=1)

    def _halve(self) -> None:
        rows, times = self.waterfall()
        even = len(rows) // 2 * 2
        self._rows = [_mean(rows[:even].reshape(-1, 2, rows.shape[1]), axis=1)]
        self._row_times = [times[:even].reshape(-1, 2).mean(axis=1)]
        self._row_count = even // 2
        self._half_row = None
        self.pings_per_row *= 2


def _mean(values: ByteImage, axis: int) -> ByteImage:
    mean: ByteImage = np.rint(values.mean(axis=axis, dtype=np.float32)).astype(np.uint8)
    return mean
