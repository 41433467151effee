"""Tables of numbers as text, read and written in bulk; every complaint names the file and the line."""

import io
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ssjs_cli.errors import UserError, nearest_hint

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

EXACT = "%r"  # the shortest text that reads back as the same number
FIXED = "%.9f"
SCIENTIFIC = "%.9e"
WHOLE = "%d"
TEXT = "%s"

MAX_LINE_BYTES = 1024 * 1024
MAX_TABLE_BYTES = 4 * 1024**3
_ROWS_PER_CHUNK = 4096
_EMPTY_FIELD = re.compile(r"(?m)(?:(?<=,)|^)[ \t]*(?=,|$)")


@dataclass(frozen=True)
class NumberTable:
    """columns: name -> (rows,) values, as in the file."""

    path: Path
    columns: dict[str, FloatArray]
    rows: int

    def __getitem__(self, name: str) -> FloatArray:
        return self.columns[name]

    def __contains__(self, name: str) -> bool:
        return name in self.columns

    def stacked(self, names: Sequence[str]) -> FloatArray:
        """(rows, len(names))"""
        return np.column_stack([self.columns[name] for name in names])

    def line_of(self, row: int) -> int:
        """The 1-based line of the file that holds a row."""
        text = read_text(self.path)
        data_lines = [number for number, line in enumerate(text.split("\n"), 1) if _holds_data(line)]
        has_header = len(data_lines) > self.rows
        return data_lines[row + (1 if has_header else 0)]

    def where(self, row: int) -> str:
        return f"{self.path}:{self.line_of(row)}"


def _holds_data(line: str) -> bool:
    stripped = line.strip()
    return bool(stripped) and not stripped.startswith("#")


def read_text(path: Path) -> str:
    """Of a table: its lines end in a newline alone."""
    data = _read_lines(path)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise UserError(f"{path}:{line}: is not text (byte {error.start} is not UTF-8); give a text file") from error
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _read_lines(path: Path) -> bytes:
    """The whole file, unless it is larger than a table may be, or holds a line longer than any has: that is told at the first such line."""
    size = path.stat().st_size
    if size > MAX_TABLE_BYTES:
        raise UserError(f"{path}: holds {size} bytes, more than the {MAX_TABLE_BYTES} that a table may; split the mission")
    with path.open("rb") as file:
        number = 0
        while line := file.readline(MAX_LINE_BYTES + 1):
            number += 1
            if len(line) > MAX_LINE_BYTES and b"\r" not in line:
                raise UserError(f"{path}:{number}: is longer than {MAX_LINE_BYTES} bytes, which no line of a table is; check the file")
        file.seek(0)
        return file.read()


def holds_file(path: Path) -> bool:
    """Whether a file of a mission is there. A directory, a pipe or a link to nothing under its name is none, and is not passed over."""
    if path.is_file():
        return True
    if path.is_symlink() and not path.exists():
        raise UserError(f"{path}: is a link to nothing; mend or remove it")
    if path.exists():
        raise UserError(f"{path}: is {'a directory' if path.is_dir() else 'no regular file'} where a file is wanted; remove or rename it")
    return False


def read_table(
    path: Path,
    *,
    required: Sequence[str],
    optional: Sequence[str] = (),
    may_be_empty: Sequence[str] = (),
    other_columns_allowed: bool = False,
    delimiter: str = ",",
) -> NumberTable:
    """A table with a header line. Empty fields become NaN, and only columns of `may_be_empty` may have them."""
    if not path.is_file():
        raise UserError(f"{path}: is missing; it needs the columns {','.join(required)}")
    text = read_text(path)
    header_line, header_number, body = _split_header(text)
    if header_line is None:
        raise UserError(f"{path}:1: is empty; it needs a header line with the columns {','.join(required)}")
    names = [name.strip() for name in header_line.split(delimiter)]
    known = [*required, *optional]
    for name in names:
        if names.count(name) > 1:
            raise UserError(f"{path}:{header_number}: column '{name}' appears twice; name each column once")
        if not other_columns_allowed and name not in known:
            raise UserError(f"{path}:{header_number}: unknown column '{name}'{nearest_hint(name, known)}; known columns: {','.join(known)}")
    missing = [name for name in required if name not in names]
    if missing:
        raise UserError(f"{path}:{header_number}: column {','.join(missing)} is missing; the header holds {','.join(names)}")
    wanted = known if other_columns_allowed else names
    wanted = [name for name in wanted if name in names]
    values = _parse_body(path, body, header_number + 1, names, delimiter, [names.index(name) for name in wanted])
    columns = {name: values[:, position] for position, name in enumerate(wanted)}
    table = NumberTable(path, columns, len(values))
    for name in wanted:
        if name not in may_be_empty:
            require_finite(table, name)
    return table


def read_header(path: Path, delimiter: str = ",") -> list[str]:
    """The column names of a table with a header line."""
    if not path.is_file():
        raise UserError(f"{path}: is missing; check the path")
    header_line, _, _ = _split_header(read_text(path))
    return [] if header_line is None else [name.strip() for name in header_line.split(delimiter)]


def read_columns(path: Path, names: Sequence[str]) -> NumberTable:
    """A table of white-space separated columns without a header; '#' starts a comment."""
    if not path.is_file():
        raise UserError(f"{path}: is missing; it needs the columns {' '.join(names)}")
    values = _parse_body(path, read_text(path), 1, list(names), None, list(range(len(names))))
    table = NumberTable(path, {name: values[:, position] for position, name in enumerate(names)}, len(values))
    for name in names:
        require_finite(table, name)
    return table


def _split_header(text: str) -> tuple[str | None, int, str]:
    """The first line with data, its number, and everything after it."""
    start = 0
    number = 0
    while start < len(text):
        number += 1
        end = text.find("\n", start)
        end = len(text) if end < 0 else end
        line = text[start:end]
        if _holds_data(line):
            return line, number, text[end + 1 :]
        start = end + 1
    return None, number, ""


def _parse_body(path: Path, body: str, first_line: int, names: list[str], delimiter: str | None, wanted: list[int]) -> FloatArray:
    """(rows, len(wanted))"""
    if not any(_holds_data(line) for line in io.StringIO(body)):
        return np.empty((0, len(wanted)))
    if delimiter == "," and (",," in body or ",\n" in body or "\n," in body or body.startswith(",") or body.endswith(",")):
        body = "\n".join(_EMPTY_FIELD.sub("nan", line) if _holds_data(line) else line for line in body.split("\n"))
    try:
        return _load_numbers(body, names, delimiter, wanted)
    except ValueError as error:
        raise _first_fault(path, body, first_line, names, delimiter, wanted, error) from error


def _load_numbers(body: str, names: list[str], delimiter: str | None, wanted: list[int]) -> FloatArray:
    whole_rows = wanted == list(range(len(names)))
    values = np.loadtxt(
        io.StringIO(body), delimiter=delimiter, comments="#", ndmin=2, usecols=None if whole_rows else wanted, dtype=np.float64
    )
    if whole_rows and values.shape[1] != len(names):
        raise ValueError(f"{values.shape[1]} fields in a row")
    return values


def _first_fault(
    path: Path, body: str, first_line: int, names: list[str], delimiter: str | None, wanted: list[int], error: ValueError
) -> UserError:
    for number, line in enumerate(body.split("\n"), first_line):
        if not _holds_data(line):
            continue
        fields = [text.strip() for text in line.split("#")[0].split(delimiter)]
        if len(fields) != len(names):
            return UserError(
                f"{path}:{number}: has {len(fields)} fields where {len(names)} are needed ({','.join(names)}); complete or remove the line"
            )
        for position in wanted:
            if not _is_number(fields[position]):
                return UserError(f"{path}:{number}: {names[position]} = '{fields[position]}' is not a number; correct or remove the line")
    return UserError(f"{path}: cannot be read as numbers ({error}); correct the file")


def _is_number(field: str) -> bool:
    """As numpy reads it: without the underscores and the digits of other scripts that Python allows."""
    try:
        float(field)
    except ValueError:
        return False
    return field.isascii() and "_" not in field


def require_finite(table: NumberTable, name: str) -> None:
    bad = ~np.isfinite(table[name])
    if bad.any():
        row = int(np.argmax(bad))
        value = table[name][row]
        shown = "empty or NaN" if np.isnan(value) else "infinite"
        raise UserError(f"{table.where(row)}: {name} is {shown}; every value must be a finite number, so correct or remove the line")


def require_times_in_order(table: NumberTable, name: str = "time_s") -> None:
    backwards = np.diff(table[name]) < 0.0
    if backwards.any():
        row = int(np.argmax(backwards)) + 1
        raise UserError(
            f"{table.where(row)}: {name} = {float(table[name][row])!r} goes back from {float(table[name][row - 1])!r}; "
            "sort the lines by time"
        )


def require_positive(table: NumberTable, name: str, mend: str = "give the noise of the sensor") -> None:
    bad = ~(table[name] > 0.0)
    if bad.any():
        row = int(np.argmax(bad))
        raise UserError(f"{table.where(row)}: {name} = {float(table[name][row])!r} must be positive; {mend}")


def require_positive_range(table: NumberTable) -> None:
    require_positive(table, "range_m", "correct or remove the line")


def whole_numbers(table: NumberTable, name: str) -> IntArray:
    """The column as integers; a fraction, or a number too large to be held exactly, is refused."""
    values = table[name]
    bad = (values != np.round(values)) | (np.abs(values) >= 2.0**53)
    if bad.any():
        row = int(np.argmax(bad))
        raise UserError(f"{table.where(row)}: {name} = {float(values[row])!r} must be a whole number below 2^53; correct the line")
    return values.astype(np.int64)


def format_rows(columns: Sequence[FloatArray | IntArray], formats: Sequence[str], separator: str = ",") -> Iterator[str]:
    """Rows of text in chunks. The same numbers give the same bytes: fixed formats, no negative zero."""
    prepared = [_prepare(column, number_format) for column, number_format in zip(columns, formats, strict=True)]
    row_format = separator.join(formats) + "\n"
    rows = len(prepared[0]) if prepared else 0
    for start in range(0, rows, _ROWS_PER_CHUNK):
        chunk = [column[start : start + _ROWS_PER_CHUNK].tolist() for column in prepared]
        count = len(chunk[0])
        yield (row_format * count) % tuple(chain.from_iterable(zip(*chunk, strict=True)))


def _prepare(column: FloatArray | IntArray, number_format: str) -> FloatArray | IntArray:
    if number_format == TEXT:
        return column
    if number_format == WHOLE:
        return np.asarray(column, dtype=np.int64)
    values = np.asarray(column, dtype=np.float64)
    if number_format == FIXED:
        values = np.where(np.abs(values) < 0.5e-9, 0.0, values)
    return values + 0.0


def write_table(path: Path, header: str, columns: Sequence[FloatArray | IntArray], formats: Sequence[str], separator: str = ",") -> None:
    """`header` is the first line, without its line end; an empty header writes none."""
    with path.open("w", encoding="utf-8", newline="\n") as file:
        if header:
            file.write(header + "\n")
        for chunk in format_rows(columns, formats, separator):
            file.write(chunk)
