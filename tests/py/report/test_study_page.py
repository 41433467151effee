from ssjs_cli.report.comparison_figures import MethodCurves, cumulative_time, errors, maps, nees, nis, nis_per_dof, time_split
from ssjs_cli.report.method_colours import method_colours
from ssjs_cli.report.sheet import sheet
from ssjs_cli.report.study_page import seeds_text
from ssjs_cli.report.submap_colours import PALETTE


def test_a_method_keeps_its_colour_whatever_else_is_compared() -> None:
    known = ("ssjs", "ekf", "lmj")
    assert method_colours(["lmj"], known) == {"lmj": PALETTE[2]}
    assert method_colours(["lmj", "ssjs"], known) == {"lmj": PALETTE[2], "ssjs": PALETTE[0]}
    assert method_colours(["other"], known) == {"other": PALETTE[3]}


def test_a_sheet_leaves_out_what_nobody_knows() -> None:
    columns = (("method", "method", None, 1.0), ("share", "share [%]", 1, 100.0), ("unknown", "unknown", 2, 1.0))
    rows = [{"method": "a", "share": 0.955}, {"method": "b", "share": None, "reason": "died"}]
    made = sheet("id", "heading", columns, rows)
    assert made.columns == ["method", "share [%]"]
    assert [[cell.text for cell in row.cells] for row in made.rows] == [["a", "95.5"], ["b", "–"]]
    assert [row.refused for row in made.rows] == [False, True]


def test_seeds_in_words() -> None:
    assert seeds_text([7]) == "7"
    assert seeds_text([3, 4, 5]) == "3 to 5"


def curves(**record: object) -> list[MethodCurves]:
    return [MethodCurves("ssjs", "#123456", record, {"time_local_s": 1.0, "time_global_s": 0.5, "time_total_s": 1.5})]


def test_figures_are_absent_where_the_record_has_nothing() -> None:
    empty = curves()
    assert cumulative_time(empty) is None
    assert errors(empty, "final") is None
    assert nees(empty, "final", 3) is None
    assert nis(empty) is None
    assert maps(empty) is None
    assert cumulative_time([]) is None
    assert time_split([]) is None


def test_the_bar_is_the_sum_of_the_known_parts() -> None:
    figure = time_split(curves())
    assert figure is not None
    assert [trace["x"] for trace in figure["data"]] == [[1.0], [0.0], [0.5], [0.0]]
    assert figure["layout"]["annotations"][0]["text"] == "1.5 s"


def test_the_band_of_nees_is_that_of_a_single_value() -> None:
    figure = nees(curves(nees={"time_s": [1.0, 2.0], "final": [2.0, None], "online": [900.0, 1.0]}), "final", 3)
    assert figure is not None
    # chi-squared of 3: 0.216 and 9.348 (tables)
    assert [round(value, 3) for value in (figure["data"][1]["y"][0], figure["data"][2]["y"][0])] == [0.216, 9.348]
    assert figure["layout"]["yaxis"]["range"][0] == 0.0
    assert figure["data"][3]["y"] == [2.0, None]
    # one value a hundred times above the band: a logarithmic axis
    high = nees(curves(nees={"time_s": [1.0, 2.0], "final": [2.0, None], "online": [900.0, 1.0]}), "online", 3)
    assert high is not None
    assert high["layout"]["yaxis"]["type"] == "log"


def test_a_span_without_an_update_is_a_gap_in_curve_and_band() -> None:
    curve = {"time_s": [1.0, 2.0, 3.0], "nis": [4.0, 0.0, 3.0], "dof": [2.0, 0.0, 6.0]}
    assert nis_per_dof(curve) == [2.0, None, 0.5]
    figure = nis(curves(nis=curve))
    assert figure is not None
    assert figure["data"][1]["x"] == [1.0, None, 3.0]
