"""Pictures that stream by: what is kept of them, however long the survey is."""

from typing import Any

import numpy as np
import pytest

from ssjs_cli.formats.tum import PoseSeries
from ssjs_cli.sonar import survey_record
from ssjs_cli.sonar.survey_record import SurveyRecord


def block(first: int, pings: int, grey: Any, columns: int = 400, heard: bool = True) -> dict[str, Any]:
    reach = np.tile([1.0, 20.0, 1.0, 20.0], (pings, 1))
    return {
        "grey": np.broadcast_to(np.asarray(grey, dtype=np.uint8).reshape(-1, 1), (pings, columns)).copy(),
        "first_index": first,
        "nadir_column": columns // 2,
        "column_m": 0.1,
        "time_s": (first + np.arange(pings)) / 7.0,
        "altitude_m": np.full(pings, 5.0),
        "reach_m": reach if heard else np.full((pings, 4), np.nan),
    }


def test_a_short_survey_keeps_every_ping() -> None:
    record = SurveyRecord()
    record.add_blocks("a.xtf", [block(0, 100, np.arange(100))], [])
    record.add_blocks("a.xtf", [block(100, 60, np.arange(100, 160))], [])
    rows, time_s = record.waterfall()
    assert rows.shape == (160, 200)  # 200 columns a side become 100
    assert rows[:, 0].tolist() == list(range(160))
    assert time_s == pytest.approx(np.arange(160) / 7.0)
    assert record.column_m == pytest.approx(0.2)
    assert record.pings == 160


def test_a_long_survey_is_averaged_to_a_bounded_size(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(survey_record, "MOST_ROWS", 1000)
    record = SurveyRecord()
    pings = 17 * 350
    for first in range(0, pings, 350):
        record.add_blocks("a.xtf", [block(first, 350, np.arange(first, first + 350) // 40)], [])
    rows, time_s = record.waterfall()
    assert len(rows) == len(time_s) <= 1000
    assert record.pings_per_row == 8
    assert record.pings == pings
    # each row shows its own pings: the grey level tells which
    assert np.abs(rows[:, 0] - time_s * 7.0 / 40.0 + 0.5).max() < 1.1
    assert time_s[-1] * 7.0 > pings - 8 * 3


def test_another_range_is_cut_to_the_columns_of_the_first() -> None:
    record = SurveyRecord()
    record.add_blocks("a.xtf", [block(0, 10, np.full(10, 90))], [])
    record.add_blocks("a.xtf", [block(10, 10, np.full(10, 90), columns=200)], [])
    record.add_blocks("a.xtf", [block(20, 10, np.full(10, 90), columns=600)], [])
    rows, _ = record.waterfall()
    assert rows.shape == (30, 200)
    assert (rows[0] == 90).all() and (rows[25] == 90).all()
    assert rows[15, 0] == 0 and rows[15, 100] == 90 and rows[15, -1] == 0


def test_the_reach_has_a_row_a_second_and_every_change() -> None:
    record = SurveyRecord()
    record.add_blocks("a.xtf", [block(0, 70, np.zeros(70)), block(70, 70, np.zeros(70), heard=False)], [])
    reach = record.reach()
    assert len(reach.time_s) == pytest.approx(20, abs=3)
    assert np.all(np.diff(reach.time_s) > 0.0)
    silent = np.isnan(reach.ranges_m[:, 0])
    assert reach.time_s[silent].min() == pytest.approx(70 / 7.0)


def test_pictures_come_back_as_they_were() -> None:
    record = SurveyRecord()
    rng = np.random.default_rng(3)
    pictures = [rng.integers(0, 255, (81, 300), dtype=np.uint8) for _ in range(5)]
    entry = {"first_index": 7, "nadir_column": 150, "column_m": 0.1}
    numbers = [record.keep({**entry, "grey": picture}) for picture in pictures]
    for number, picture in reversed(list(zip(numbers, pictures, strict=True))):
        again = record.picture(number)
        assert (again.grey == picture).all()
        assert again.first_index == 7
    record.close()


def test_the_stretch_is_the_block_with_the_most_contacts() -> None:
    record = SurveyRecord()
    blocks = [block(0, 50, np.zeros(50)), block(50, 50, np.ones(50)), block(100, 50, np.full(50, 2))]
    record.add_blocks("a.xtf", blocks, [{"index": 60}, {"index": 70}, {"index": 149}])
    assert record.stretch is not None
    assert record.stretch.contacts == 2
    assert record.stretch.picture.first_index == 50


def test_a_snippet_lies_in_square_metres_around_its_contact() -> None:
    from ssjs_cli.sonar.contacts import Sighting
    from ssjs_cli.sonar.survey_pictures import SNIPPET_M, SNIPPET_PX, _row_spacing_m, _snippet

    record = SurveyRecord()
    record.add_blocks("a.xtf", [block(0, 200, np.zeros(200))], [])  # 7 pings a second
    grey = np.full((81, 600), 40, dtype=np.uint8)
    grey[38:43, 410:420] = 250  # 11 to 12 m to starboard, five pings
    number = record.keep({"grey": grey, "first_index": 60, "nadir_column": 300, "column_m": 0.1})
    found = {
        "index": 100, "first_index": 98, "last_index": 102, "time_s": 100 / 7.0, "ground_range_m": 11.5, "side": "starboard",
        "width_m": 1.0, "length_m": 1.0,
    }  # fmt: skip
    picture = record.picture(number)
    track = PoseSeries(np.array([0.0, 100.0]), np.array([[0.0, 0.0, 0.0], [140.0, 0.0, 0.0]]))  # 1.4 m/s: 0.2 m a ping
    spacing_m = _row_spacing_m(track, Sighting("a.xtf", found, number), picture)
    assert spacing_m == pytest.approx(0.2)
    import io

    from PIL import Image

    image = np.asarray(Image.open(io.BytesIO(_snippet(picture, found, spacing_m))).convert("L"))
    assert image.shape == (SNIPPET_PX, SNIPPET_PX)
    bright = image > 240
    rows, columns = np.flatnonzero(bright.any(axis=1)), np.flatnonzero(bright.any(axis=0))
    per_m = SNIPPET_PX / SNIPPET_M
    assert 0.5 * (columns[0] + columns[-1]) == pytest.approx(SNIPPET_PX / 2, abs=2)
    assert 0.5 * (rows[0] + rows[-1]) == pytest.approx(SNIPPET_PX / 2, abs=2)
    assert len(columns) == pytest.approx(1.0 * per_m, abs=3)
    assert len(rows) == pytest.approx(5 * 0.2 * per_m, abs=4)
