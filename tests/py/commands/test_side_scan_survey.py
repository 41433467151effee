"""A survey from sonar pictures to a map: simulated, detected, corrected."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ssjs_cli.app import main
from ssjs_cli.formats.mission import read_mission
from ssjs_cli.sonar.log_blocks import open_log


def run(*arguments: str | Path) -> int:
    with pytest.raises(SystemExit) as ended:
        main([str(argument) for argument in arguments])
    return int(ended.value.code or 0)


@pytest.fixture(scope="module")
def survey(tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("survey") / "mission"
    assert run("simulate", "side-scan-survey", "--seed", "3", "--out", directory) == 0
    return directory


def test_the_mission_holds_navigation_pings_and_truth(survey: Path) -> None:
    mission = read_mission(survey)
    assert mission.navigation is not None and mission.points is None
    assert [path.name for path in mission.sonar_logs] == ["survey.xtf"]
    assert mission.reference.landmarks is not None and len(mission.reference.landmarks.ids) == 60
    log = open_log(mission.sonar_logs[0])
    block = log.read(100_000)
    assert block is not None and not log.info()["problems"]
    time_s = block["pings"]["time_s"]
    assert abs(time_s[0] - mission.time_s[0]) < 0.01 and abs(time_s[-1] - mission.time_s[-1]) < 0.2


def test_contacts_correct_the_track(survey: Path, tmp_path: Path) -> None:
    assert run("run", survey, "--out", tmp_path / "run", "--no-report") == 0
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["loop_closures"] > 0
    assert summary["trajectory_rmse_m"] < summary["dead_reckoning_rmse_m"]
    assert summary["map_error_matched"] >= 30


def test_the_run_leaves_a_picture_of_each_contact_and_its_coverage(survey: Path, tmp_path: Path) -> None:
    directory = tmp_path / "run"
    assert run("run", survey, "--out", directory) == 0
    with (directory / "contacts.csv").open(newline="") as file:
        named = [row["snippet"] for row in csv.DictReader(file) if row["snippet"]]
    assert len(named) >= 40
    assert len(set(named)) == len(named)
    assert all((directory / name).is_file() for name in named)
    with (directory / "sightings.csv").open(newline="") as file:
        sightings = list(csv.DictReader(file))
    summary = json.loads((directory / "summary.json").read_text())
    assert len(sightings) == summary["sightings"] == summary["observations"]
    assert {row["contact"] for row in sightings} >= {
        name.removeprefix("snippets/contact-").removesuffix(".png").lstrip("0") for name in named
    } - {""}
    # five lines of 120 m, 20 m apart, with 29 m to each side, and cross lines: the whole of 120 m x 80 m and what lies around it
    assert 120 * 80 < summary["coverage_area_m2"] < summary["surveyed_area_m2"] < 200 * 170
    assert summary["coverage_twice_fraction"] < summary["coverage_fraction"] < 1.0
    page = (directory / "report.html").read_text(encoding="utf-8")
    assert page.count('class="contact-card"') == len(named)
    assert len(page) < 15e6


def test_a_survey_can_be_replaced(survey: Path) -> None:
    before = (survey / "pings" / "survey.xtf").read_bytes()
    assert run("simulate", "side-scan-survey", "--seed", "3", "--out", survey, "--force") == 0
    assert (survey / "pings" / "survey.xtf").read_bytes() == before


@pytest.fixture(scope="module")
def tiles(survey: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("tiles") / "tiles"
    assert run("sonar", "tiles", survey, "--out", folder) == 0
    return folder


def test_tiles_hold_the_objects_that_are_shown_whole(tiles: Path) -> None:
    document = json.loads((tiles / "annotations.json").read_text())
    images = {image["id"]: image for image in document["images"]}
    assert {image["file_name"].split("_")[0] for image in images.values()} == {"port", "starboard"}
    assert len(document["annotations"]) > 60
    shadows = []
    for entry in document["annotations"]:
        image = images[entry["image_id"]]
        x, y, width, height = entry["bbox"]
        assert x >= 0 and y >= 0 and x + width <= image["width"] and y + height <= image["height"]
        levels, alpha = np.asarray(Image.open(tiles / "objects" / image["file_name"])).transpose(2, 0, 1)
        assert (alpha[y : y + height, x : x + width] > 0).all()
        box = levels[y : y + height, x : x + width].astype(float)
        behind = box[:, : width // 2] if image["file_name"].startswith("port") else box[:, width // 2 :]
        shadows.append(behind.mean() < box.mean())
    # What lies behind an object, seen from the nadir, is its shadow.
    assert np.mean(shadows) > 0.8


def test_pictures_without_objects_come_from_between_them(tiles: Path) -> None:
    document = json.loads((tiles / "annotations.json").read_text())
    objects = {image["file_name"]: image for image in document["images"]}
    empty = sorted((tiles / "empty").iterdir())
    assert empty
    for path in empty:
        rows = Image.open(path).height
        assert rows >= 48
        if path.name in objects:
            assert rows <= objects[path.name]["height"]


PLAN = "".join(
    f"[[layer]]\ndetection_rate = {found}\nfalse_positive_rate = {false}\nmax_features = {most}\n"
    for found, false, most in ((0.99, 0.3, 4), (0.98, 0.03, 10))
)


@pytest.fixture(scope="module")
def model(tiles: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("model")
    (folder / "plan.toml").write_text(PLAN)
    settings = (
        "window.width_px=24", "window.height_px=10", "training.feature_set=side_scan", "training.negatives_per_layer=500",
        "validation.windows=2000", "augmentation.copies=0",
    )  # fmt: skip
    sets = [part for setting in settings for part in ("--set", setting)]
    given = ("--positives", tiles / "objects", "--annotations", tiles / "annotations.json", "--negatives", tiles / "empty")
    assert run("cascade", "train", *given, "--mirrored", "^port_", "--plan", folder / "plan.toml", *sets, "--out", folder / "model") == 0
    return folder / "model"


def test_a_cascade_trained_on_tiles_finds_contacts_and_contours_verify(survey: Path, model: Path, tmp_path: Path) -> None:
    log = survey / "pings" / "survey.xtf"
    counts = {}
    for name, flags in {"all": (), "surer": ("--min-score", "5"), "verified": ("--verify", "contour")}.items():
        out = tmp_path / f"{name}.csv"
        assert run("sonar", "detect", log, "--detector", "cascade", "--model", model, *flags, "--out", out) == 0
        counts[name] = len(out.read_text().splitlines()) - 1
    assert counts["all"] > 60
    assert counts["surer"] < counts["all"]
    assert counts["verified"] < counts["all"]


def test_a_run_takes_the_cascade_and_remembers_it(survey: Path, model: Path, tmp_path: Path) -> None:
    sets = ("--set", "sonar.detector=cascade", "--set", f"sonar.cascade_model={model}")
    assert run("run", survey, *sets, "--out", tmp_path / "run", "--no-report") == 0
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["trajectory_rmse_m"] < summary["dead_reckoning_rmse_m"]
    assert len(summary["input_digests"]["sonar.cascade_model"]) == 64
    # The settings of the run give it again.
    assert run("run", survey, "--config", tmp_path / "run" / "config.toml", "--out", tmp_path / "again", "--no-report") == 0
    assert (tmp_path / "again" / "landmarks.csv").read_bytes() == (tmp_path / "run" / "landmarks.csv").read_bytes()


def test_another_model_under_the_same_name_is_another_run(survey: Path, model: Path, tmp_path: Path) -> None:
    copy, season = tmp_path / "model.json", tmp_path / "season"
    copy.write_text((model / "cascade.json").read_text())
    command = ("batch", survey, "--set", "sonar.detector=cascade", "--set", f"sonar.cascade_model={copy}", "--no-report", "--out", season)
    assert run(*command) == 0
    assert run(*command) == 0
    assert len(list((season / "missions").iterdir())) == 1
    copy.write_text(copy.read_text() + "\n")
    assert run(*command) == 0
    assert len(list((season / "missions").iterdir())) == 2


def test_a_cascade_that_cannot_be_used_is_named(survey: Path, model: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cascade = ("--set", "sonar.detector=cascade")
    assert run("run", survey, *cascade, "--out", tmp_path / "a") == 2
    assert "sonar.detector = cascade: needs a model; give sonar.cascade_model" in capsys.readouterr().err
    assert run("run", survey, *cascade, "--set", "sonar.cascade_model=none.json", "--out", tmp_path / "a") == 2
    assert "none.json: No such file or directory" in capsys.readouterr().err
    (tmp_path / "wrong.json").write_text("{}")
    assert run("run", survey, *cascade, "--set", f"sonar.cascade_model={tmp_path / 'wrong.json'}", "--out", tmp_path / "a") == 2
    assert "wrong.json" in capsys.readouterr().err
    verify = ("--set", "sonar.cascade.verify=contour", "--set", f"sonar.cascade_model={model / 'cascade.xml'}")
    assert run("run", survey, *cascade, *verify, "--out", tmp_path / "a") == 2
    assert "holds no contours to verify detections with" in capsys.readouterr().err
    document = json.loads((model / "cascade.json").read_text())
    smoothed = json.dumps(document).replace('"image.smoothing_px": "1"', '"image.smoothing_px": "3"')
    assert smoothed != json.dumps(document)
    (tmp_path / "smoothed.json").write_text(smoothed)
    assert run("run", survey, *cascade, "--set", f"sonar.cascade_model={tmp_path / 'smoothed.json'}", "--out", tmp_path / "a") == 2
    assert "smoothed or continued beyond their borders" in capsys.readouterr().err
    assert run("sonar", "detect", survey / "pings" / "survey.xtf", "--model", model, "--out", tmp_path / "a.csv") == 2
    assert "--model: is of the detector cascade; add --detector cascade" in capsys.readouterr().err
    assert run("sonar", "tiles", tmp_path / "nothing", "--out", tmp_path / "tiles") == 2
