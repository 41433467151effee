import numpy as np

from ssjs_cli.report.map_figure import MapAxes, SubmapColours
from ssjs_cli.report.replay import MAX_MOMENTS, replay_data, replay_moments, timeline_spans
from ssjs_cli.report.result_files import read_run_files


def replay_of(run_dir):
    files = read_run_files(run_dir)
    return files, replay_data(files, MapAxes.from_summary({}), SubmapColours.from_files(files))


def test_moments_are_even_in_time_and_hold_both_ends():
    # 0.1 s steps for 10 s, then 1 s steps for 90 s: 11 moments over 100 s, one every 10 s
    time_s = np.concatenate((np.arange(0.0, 10.0, 0.1), np.arange(10.0, 101.0)))
    assert time_s[replay_moments(time_s, 11)].tolist() == [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0, 100.0]


def test_short_missions_keep_every_step():
    assert replay_moments(np.arange(5.0), 11).tolist() == [0, 1, 2, 3, 4]


def test_long_mission_is_thinned_and_ends_where_the_mission_ends(full_run):
    files, replay = replay_of(full_run)
    assert MAX_MOMENTS <= len(replay["time_s"]) <= MAX_MOMENTS + 1
    final, online = replay["estimates"]
    assert (final["key"], online["key"]) == ("final", "online")
    assert final["x"][-1] == round(float(files.trajectory.position[-1, 0]), 3)
    assert len(final["covariance"][0]) == len(online["x"]) == len(replay["submap"]) == len(replay["error_m"]) == len(replay["time_s"])


def test_landmarks_are_born_with_their_submap_in_order(small_run):
    files, replay = replay_of(small_run)
    start_s = {entry["index"]: entry["start_time_s"] for entry in files.submaps.submaps}
    assert replay["landmarks"]["time_s"] == sorted(round(start_s[submap], 3) for submap in files.landmarks.submap.tolist())
    assert replay["bases"]["time_s"] == sorted(replay["bases"]["time_s"])


def test_error_is_unknown_where_no_reference_is_near(small_run):
    lines = (small_run / "errors.csv").read_text().splitlines()
    (small_run / "errors.csv").write_text("\n".join(lines[:41]) + "\n")  # the first second of 30
    _, replay = replay_of(small_run)
    known = [moment for moment, error in zip(replay["time_s"], replay["error_m"], strict=True) if error is not None]
    assert max(known) <= 0.975 + 1.0


def test_timeline_covers_the_mission(small_run):
    files = read_run_files(small_run)
    timeline = timeline_spans(files, SubmapColours.from_files(files))
    assert len(timeline["spans"]) == 6
    assert timeline["spans"][0]["start"] == 0.0
    assert timeline["spans"][-1]["start"] + timeline["spans"][-1]["width"] == 1000.0


def test_without_a_track_there_is_no_replay(small_run):
    (small_run / "trajectory.tum").unlink()
    (small_run / "trajectory_online.tum").unlink()
    assert replay_of(small_run)[1] is None
