import math

import numpy as np
import pytest
from plotly.graph_objects import Figure

from ssjs_cli.report.map_figure import MAX_TRACK_POINTS, MapAxes, SubmapColours, draw_map
from ssjs_cli.report.result_files import read_run_files


def drawing_of(run_dir, summary=None):
    files = read_run_files(run_dir)
    return draw_map(files, MapAxes.from_summary(summary or {}), SubmapColours.from_files(files))


def layer(drawing, key):
    return next(layer for layer in drawing.layers if layer.key == key)


def traces(drawing, key):
    return [drawing.figure["data"][index] for index in layer(drawing, key).traces]


def test_every_layer_is_there_and_plotly_accepts_the_figure(small_run):
    drawing = drawing_of(small_run)
    Figure(drawing.figure)
    assert [layer.key for layer in drawing.layers] == [
        "landmarks", "ellipses", "outlines", "bases", "final", "online", "dead_reckoning", "reference",
    ]  # fmt: skip


def test_axes_have_equal_scale_and_units(small_run):
    layout = drawing_of(small_run).figure["layout"]
    assert (layout["yaxis"]["scaleanchor"], layout["yaxis"]["scaleratio"]) == ("x", 1)
    assert (layout["xaxis"]["title"]["text"], layout["yaxis"]["title"]["text"]) == ("x [m]", "y [m]")


def test_one_landmark_trace_for_each_colour_and_none_lost(full_run):
    drawing = drawing_of(full_run)
    dots = traces(drawing, "landmarks")
    colours = [trace["marker"]["color"] for trace in dots]
    assert len(colours) == len(set(colours)) <= 10
    assert sum(len(trace["x"]) for trace in dots) == 1500
    assert len(traces(drawing, "ellipses")) == len(dots)


def test_long_tracks_are_thinned_and_the_caption_says_how(full_run):
    drawing = drawing_of(full_run)
    (final,) = traces(drawing, "final")
    assert len(final["x"]) <= MAX_TRACK_POINTS
    assert f"final track {len(final['x']):,} of 60,000 points, within 0.01" in drawing.notes[0]


def test_refused_pairs_start_hidden_and_carry_their_reason(full_run):
    drawing = drawing_of(full_run)
    lines, marks = traces(drawing, "refused")
    assert not layer(drawing, "refused").visible
    assert lines["visible"] is False
    assert any("too few pairs: 6 needed" in text for text in marks["text"])
    assert layer(drawing, "loops").visible


def test_trace_types_are_svg_only(full_run):
    assert {trace["type"] for trace in drawing_of(full_run).figure["data"]} == {"scatter"}


def test_north_east_down_is_drawn_with_north_up():
    axes = MapAxes.from_summary({"axis_names": ["north", "east", "down"]})
    assert axes.titles() == ("east [m]", "north [m]")
    # 3 m north, 5 m east: 5 across, 3 up; variance 1 north, 4 east, covariance 0.5
    assert axes.drawn(np.array([3.0, 5.0])).tolist() == [5.0, 3.0]
    assert axes.drawn_covariance(np.array([[1.0, 0.5, 4.0]])).tolist() == [[4.0, 0.5, 1.0]]
    # heading 0 is north, up on paper; heading +90 degrees is east, to the right
    assert axes.drawn_heading(np.array([0.0, math.pi / 2.0])) == pytest.approx([math.pi / 2.0, 0.0])


def test_names_of_axes_are_escaped():
    assert MapAxes.from_summary({"axis_names": ["<b>", "y"]}).titles()[0] == "&lt;b&gt; [m]"


def test_nothing_to_draw(tmp_path):
    (tmp_path / "summary.json").write_text("{}")
    assert drawing_of(tmp_path) is None


def test_landmarks_alone_make_a_map(small_run):
    for name in ("trajectory.tum", "trajectory_online.tum", "dead_reckoning.tum", "reference.csv", "submaps.json"):
        (small_run / name).unlink()
    drawing = drawing_of(small_run)
    assert [layer.key for layer in drawing.layers] == ["landmarks", "ellipses"]
