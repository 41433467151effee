import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ssjs_cli.errors import UserError
from ssjs_cli.formats.number_table import (
    EXACT,
    FIXED,
    SCIENTIFIC,
    WHOLE,
    NumberTable,
    format_rows,
    read_columns,
    read_table,
    require_positive,
    require_times_in_order,
    whole_numbers,
    write_table,
)

FINITE = st.floats(allow_nan=False, allow_infinity=False)


def table_of(tmp_path: Path, text: str | bytes, **options: Any) -> NumberTable:
    path = tmp_path / "table.csv"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return read_table(path, **{"required": ("time_s", "x_m"), **options})


def refused(tmp_path: Path, text: str | bytes, **options: Any) -> str:
    with pytest.raises(UserError) as caught:
        table_of(tmp_path, text, **options)
    return str(caught.value).removeprefix(str(tmp_path) + "/")


def test_columns_are_found_by_name_in_any_order(tmp_path: Path) -> None:
    table = table_of(tmp_path, "x_m,time_s\n5,1\n6,2\n")
    assert table["time_s"].tolist() == [1.0, 2.0]
    assert table["x_m"].tolist() == [5.0, 6.0]


@pytest.mark.parametrize("text", ["time_s,x_m\r\n1,2\r\n", "\ufefftime_s,x_m\n1,2", "# note\n\ntime_s , x_m\n\n1, 2\n# end\n"])
def test_line_ends_byte_order_marks_comments_and_spaces_do_not_matter(tmp_path: Path, text: str) -> None:
    table = table_of(tmp_path, text)
    assert (table["time_s"].tolist(), table["x_m"].tolist()) == ([1.0], [2.0])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time_s,y_m\n", "table.csv:1: unknown column 'y_m' (did you mean 'x_m'?); known columns: time_s,x_m"),
        ("time_s,x_m,x_m\n", "table.csv:1: column 'x_m' appears twice; name each column once"),
        ("time_s\n1\n", "table.csv:1: column x_m is missing; the header holds time_s"),
        ("", "table.csv:1: is empty; it needs a header line with the columns time_s,x_m"),
        ("time_s,x_m\n1,2\n2,wide\n", "table.csv:3: x_m = 'wide' is not a number; correct or remove the line"),
        ("time_s,x_m\n1,2\n\n# c\n2,3,4\n", "table.csv:5: has 3 fields where 2 are needed (time_s,x_m); complete or remove the line"),
        ("time_s,x_m\n1,2\n2\n", "table.csv:3: has 1 fields where 2 are needed (time_s,x_m); complete or remove the line"),
        ("time_s,x_m\n1,nan\n", "table.csv:2: x_m is empty or NaN; every value must be a finite number, so correct or remove the line"),
        ("time_s,x_m\n1,2\n3,\n", "table.csv:3: x_m is empty or NaN; every value must be a finite number, so correct or remove the line"),
        ("# c\ntime_s,x_m\n1,-inf\n", "table.csv:3: x_m is infinite; every value must be a finite number, so correct or remove the line"),
    ],
)
def test_every_fault_names_the_file_the_line_and_the_mend(tmp_path: Path, text: str, message: str) -> None:
    assert refused(tmp_path, text) == message


def test_binary_data_are_refused_by_line(tmp_path: Path) -> None:
    assert refused(tmp_path, b"time_s,x_m\n1,\xff\n") == "table.csv:2: is not text (byte 13 is not UTF-8); give a text file"


def test_a_missing_file_says_what_it_needs(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"none\.csv: is missing; it needs the columns time_s,x_m$"):
        read_table(tmp_path / "none.csv", required=("time_s", "x_m"))


def test_empty_fields_are_nan_where_they_are_allowed(tmp_path: Path) -> None:
    table = table_of(tmp_path, "time_s,id,x_m\n1,,3\n2,7,4\n3, ,5\n", required=("time_s", "id", "x_m"), may_be_empty=("id",))
    assert np.isnan(table["id"]).tolist() == [True, False, True]
    assert table["x_m"].tolist() == [3.0, 4.0, 5.0]


def test_a_header_without_rows_is_an_empty_table(tmp_path: Path) -> None:
    assert table_of(tmp_path, "time_s,x_m\n").rows == 0


def test_times_that_go_back_name_the_line_and_both_times(tmp_path: Path) -> None:
    table = table_of(tmp_path, "time_s,x_m\n1,0\n3,0\n3,0\n2.5,0\n")
    with pytest.raises(UserError, match=r"table\.csv:5: time_s = 2\.5 goes back from 3\.0; sort the lines by time$"):
        require_times_in_order(table)


@pytest.mark.parametrize("value", ["0", "-1"])
def test_noise_must_be_positive(tmp_path: Path, value: str) -> None:
    table = table_of(tmp_path, f"time_s,x_m\n1,2\n2,{value}\n")
    with pytest.raises(UserError, match=r"table\.csv:3: x_m = .* must be positive"):
        require_positive(table, "x_m")


def test_identities_must_be_whole(tmp_path: Path) -> None:
    table = table_of(tmp_path, "time_s,x_m\n1,2.5\n")
    with pytest.raises(UserError, match=r"table\.csv:2: x_m = 2\.5 must be a whole number"):
        whole_numbers(table, "x_m")


def test_white_space_columns_without_a_header(tmp_path: Path) -> None:
    path = tmp_path / "Robot1.dat"
    path.write_text("# Time x\n  1.5 \t  2 \n 2.5   3\n")
    table = read_columns(path, ("time_s", "x_m"))
    assert table["x_m"].tolist() == [2.0, 3.0]
    assert table.line_of(1) == 3


@given(values=arrays(np.float64, st.tuples(st.integers(1, 40), st.just(2)), elements=FINITE))
def test_exact_columns_read_back_the_same(values: np.ndarray[Any, Any], tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("table") / "table.csv"
    write_table(path, "a,b", [values[:, 0], values[:, 1]], [EXACT, EXACT])
    table = read_table(path, required=("a", "b"))
    assert np.array_equal(table.stacked(("a", "b")), values)


def test_number_formats() -> None:
    columns = [np.array([0.1, 1e22]), np.array([1.0000000004, -4e-10]), np.array([1234.5, -0.0]), np.array([7, -7])]
    rows = "".join(format_rows(columns, [EXACT, FIXED, SCIENTIFIC, WHOLE]))
    assert rows == "0.1,1.000000000,1.234500000e+03,7\n1e+22,0.000000000,0.000000000e+00,-7\n"


def test_long_tables_are_written_in_chunks_without_a_seam() -> None:
    numbers = np.arange(10_000)
    assert "".join(format_rows([numbers], [WHOLE])).split() == [str(number) for number in range(10_000)]


def test_sixty_thousand_rows_take_a_second_at_most(tmp_path: Path) -> None:
    values = np.random.default_rng(1).standard_normal((62_000, 7))
    names = [f"c{column}" for column in range(7)]
    path = tmp_path / "table.csv"
    started = time.process_time()
    write_table(path, ",".join(names), list(values.T), [EXACT] * 7)
    table = read_table(path, required=names)
    spent = time.process_time() - started
    assert np.array_equal(table.stacked(names), values)
    # About 0.6 s of one core; the limit leaves room for slower machines.
    assert spent < 3.0
