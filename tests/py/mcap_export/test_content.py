"""What a recording holds, against the files of the run and of its mission."""

import base64
import csv
import io
import json
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from exported_survey import Survey, read_recording
from PIL import Image

from ssjs_cli.sonar.info import describe


def data_rows(path: Path) -> list[list[str]]:
    return [line.replace(",", " ").split() for line in path.read_text().splitlines() if line[:1].isdigit()]


def test_times_ascend_over_the_whole_file(survey: Survey) -> None:
    order = survey.recording.order
    assert all(before <= after for before, after in pairwise(order))
    assert len(order) == sum(len(messages) for messages in survey.recording.messages.values())
    stamps = [(time_ns, content["timestamp"]) for time_ns, content in survey.recording.messages["/pose/corrected"]]
    assert all(time_ns == stamp["sec"] * 10**9 + stamp["nsec"] for time_ns, stamp in stamps)


@pytest.mark.parametrize(
    ("topic", "file"),
    [
        ("/pose/corrected", "run/trajectory.tum"),
        ("/pose/online", "run/trajectory_online.tum"),
        ("/pose/dead_reckoning", "run/dead_reckoning.tum"),
        ("/tf", "run/trajectory.tum"),
        ("/uncertainty", "run/trajectory_covariance.csv"),
        ("/uncertainty/ellipsoid", "run/trajectory_covariance.csv"),
        ("/position", "run/trajectory.tum"),
        ("/nis", "run/consistency.csv"),
        ("/sensors/depth", "mission/depth.csv"),
        ("/sensors/altitude", "mission/altitude.csv"),
    ],
)
def test_a_topic_has_one_message_a_row(survey: Survey, topic: str, file: str) -> None:
    rows = data_rows(survey.run.parent / file)
    assert len(rows) > 10
    times_s = survey.recording.times_s(topic)
    assert len(times_s) == len(rows)
    assert times_s == pytest.approx([float(row[0]) for row in rows], abs=1e-6)


def test_poses_are_the_rows_of_the_trajectory(survey: Survey) -> None:
    rows = data_rows(survey.run / "trajectory.tum")
    for row, content in zip(rows, survey.recording.contents("/pose/corrected"), strict=True):
        pose = content["pose"]
        shown = [*(pose["position"][axis] for axis in "xyz"), *(pose["orientation"][axis] for axis in "xyzw")]
        assert shown == [float(value) for value in row[1:]]
        assert content["frame_id"] == "world"


def test_sensors_and_consistency_have_the_numbers_of_their_files(survey: Survey) -> None:
    depths = [float(row[1]) for row in data_rows(survey.mission / "depth.csv")]
    assert [content["depth_m"] for content in survey.recording.contents("/sensors/depth")] == depths
    altitudes = [float(row[1]) for row in data_rows(survey.mission / "altitude.csv")]
    assert [content["altitude_m"] for content in survey.recording.contents("/sensors/altitude")] == altitudes
    nis = [(float(row[1]), int(row[2])) for row in data_rows(survey.run / "consistency.csv")]
    assert [(content["nis"], content["dof"]) for content in survey.recording.contents("/nis")] == nis


def test_every_landmark_stands_on_the_map(survey: Survey) -> None:
    rows = data_rows(survey.run / "landmarks.csv")
    (update,) = survey.recording.contents("/map/landmarks")
    entities = {entity["id"]: entity for entity in update["entities"]}
    assert len(entities) == len(update["entities"]) == len(rows)
    for row in rows:
        sphere = entities[row[0]]["spheres"][0]
        assert [sphere["pose"]["position"][axis] for axis in "xyz"] == [float(value) for value in row[1:4]]


def test_every_contact_is_an_event_at_its_sighting(survey: Survey) -> None:
    with (survey.run / "contacts.csv").open(newline="") as file:
        rows = {int(row["id"]): row for row in csv.DictReader(file)}
    contacts = survey.recording.contents("/contacts")
    assert len(contacts) == len(rows)
    for time_s, contact in zip(survey.recording.times_s("/contacts"), contacts, strict=True):
        row = rows.pop(contact["id"])
        assert time_s == pytest.approx(float(row["time_s"]), abs=1e-6)
        assert contact["latitude_deg"] == float(row["latitude_deg"])
        assert contact["ping"] == int(row["ping"]) and contact["channel"] == row["channel"]
        assert "class" not in contact  # an empty field
    assert not rows


def test_every_tested_loop_is_an_event_and_accepted_ones_are_lines(survey: Survey) -> None:
    loops = json.loads((survey.run / "submaps.json").read_text())["loops"]
    events = survey.recording.contents("/loops")
    accepted = [loop for loop in loops if loop["accepted"]]
    assert len(events) == len(loops) and accepted
    assert sum(event["level"] == 2 for event in events) == len(accepted)
    lines = survey.recording.contents("/map/loops")
    # each message holds all lines until then: two points a loop
    assert [len(update["entities"][0]["lines"][0]["points"]) for update in lines] == [2 * (n + 1) for n in range(len(accepted))]


def test_the_strips_hold_every_ping_once(survey: Survey) -> None:
    pictures = [Image.open(io.BytesIO(base64.b64decode(content["data"], validate=True))) for content in survey.recording.contents("/sonar")]
    assert {picture.format for picture in pictures} == {"JPEG"} and {picture.mode for picture in pictures} == {"L"}
    log = describe(survey.mission / "pings" / "survey.xtf")
    assert sum(picture.height for picture in pictures) == log["pings"]
    assert all(picture.height == 64 for picture in pictures[:-1])
    assert {picture.width for picture in pictures} == {512}
    assert survey.recording.times_s("/sonar")[-1] == pytest.approx(log["start_time_s"] + log["duration_s"], abs=1e-3)
    # bottom and shadows: a picture that shows nothing would be flat
    assert min(float(np.asarray(picture).std()) for picture in pictures) > 5.0


def test_the_same_run_gives_the_same_bytes(survey: Survey, cli: Callable[..., Any], tmp_path: Path) -> None:
    assert cli("export", "mcap", survey.run, "--out", tmp_path / "again.mcap").code == 0
    assert (tmp_path / "again.mcap").read_bytes() == survey.recording_path.read_bytes()


def test_the_answer_counts_the_messages(survey: Survey, cli: Callable[..., Any], tmp_path: Path) -> None:
    answer = cli("export", "mcap", survey.run, "--out", tmp_path / "a.mcap", "--json", "--no-sonar")
    document = json.loads(answer.out)
    assert answer.code == 0 and document["lost"] == []
    assert "/sonar" not in document["messages"]
    recording = read_recording(tmp_path / "a.mcap")
    assert {topic: len(messages) for topic, messages in recording.messages.items()} == document["messages"]
    assert document["duration_s"] == pytest.approx((recording.order[-1] - recording.order[0]) / 1e9, abs=1e-6)


def test_a_planar_run_has_no_sonar_and_no_contacts(circle_run: Path, cli: Callable[..., Any], tmp_path: Path) -> None:
    assert cli("export", "mcap", circle_run, "--out", tmp_path / "a.mcap").code == 0
    recording = read_recording(tmp_path / "a.mcap")
    assert not {"/sonar", "/contacts", "/sensors/depth", "/position"} & set(recording.messages)
    assert len(recording.messages["/pose/corrected"]) == len(data_rows(circle_run / "trajectory.tum"))
    assert len(recording.contents("/map/landmarks")[0]["entities"]) == len(data_rows(circle_run / "landmarks.csv"))
