"""Folders of images as missions."""

import json
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from ssjs_cli.camera.frame_times import exif_time, time_in_name
from ssjs_cli.formats.camera_calibration import CameraCalibration, calibration_text
from ssjs_cli.formats.mission import read_mission


def picture(seed: int, width: int = 48, height: int = 32) -> Image.Image:
    return Image.fromarray(np.random.default_rng(seed).integers(0, 255, (height, width, 3), dtype=np.uint8))


def folder_of(tmp_path: Path, *names: str) -> Path:
    folder = tmp_path / "images"
    folder.mkdir()
    for number, name in enumerate(names):
        picture(number).save(folder / name)
    return folder


def test_a_folder_becomes_a_mission_with_the_very_images(cli: Callable[..., Any], tmp_path: Path) -> None:
    folder = folder_of(tmp_path, "f10.png", "f9.png", "f1.png")
    (folder / "imu.csv").write_text("time_s,roll_rad,pitch_rad,yaw_rad\n0,0,0,0\n1,0,0,0\n")
    (folder / "truth_trajectory.tum").write_text("0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n")
    calibration = CameraCalibration(48, 32, 50.0, 50.0, 24.0, 16.0, lens="brown", distortion=(0.1, 0.0, 0.0, 0.0, 0.0))
    (tmp_path / "lens.yaml").write_text(calibration_text(calibration))
    out = tmp_path / "mission"
    answer = cli("import", "frames", folder, "--interval", "0.5", "--calibration", tmp_path / "lens.yaml", "--out", out, "--json")
    assert answer.code == 0, answer.err
    assert json.loads(answer.out)["frames"] == 3
    mission = read_mission(out)
    assert mission.frames is not None and mission.navigation is not None and mission.reference.truth is not None
    assert mission.frames.files == ("f1.png", "f9.png", "f10.png")
    np.testing.assert_array_equal(mission.frames.time_s, [0.0, 0.5, 1.0])
    assert mission.frames.calibration == calibration
    assert (out / "frames" / "f9.png").read_bytes() == (folder / "f9.png").read_bytes()


def test_damaged_repeated_and_missing_frames_are_named_and_none_is_fatal(cli: Callable[..., Any], tmp_path: Path) -> None:
    folder = folder_of(tmp_path, "a.png", "b.png", "d.png", "f.png", "stray.png")
    (folder / "c.png").write_bytes((folder / "a.png").read_bytes())
    whole = (folder / "d.png").read_bytes()
    (folder / "d.png").write_bytes(whole[: len(whole) // 2])
    (folder / "e.png").write_bytes(b"")
    (tmp_path / "times.csv").write_text("time_s,file\n" + "".join(f"{n},{name}.png\n" for n, name in enumerate("abcdefg")))
    (tmp_path / "lens.yaml").write_text(calibration_text(CameraCalibration(48, 32, 50.0, 50.0, 24.0, 16.0)))
    picture(9, width=40).save(folder / "f.png")
    out = tmp_path / "mission"
    answer = cli(
        "import", "frames", folder, "--times", tmp_path / "times.csv", "--calibration", tmp_path / "lens.yaml", "--out", out, "--json"
    )
    assert answer.code == 3
    lost = json.loads(answer.out)["lost"]
    assert lost[0] == "g.png of times.csv is missing among the images"
    assert lost[1] == "stray.png has no time in times.csv and was not taken along"
    assert lost[2] == "c.png is a duplicate of a.png"
    assert lost[3].startswith("d.png is damaged or cut off (")
    assert lost[4] == "e.png is empty (0 bytes)"
    assert lost[5] == "f.png has 40 x 32 pixels, and the calibration is of 48 x 32"
    assert len(lost) == 6
    mission = read_mission(out)
    assert mission.frames is not None and mission.frames.files == ("a.png", "b.png", "f.png")
    assert tomllib.loads((out / "mission.toml").read_text())["import"]["counts"] == {"images": 7, "frames": 3}


@pytest.mark.parametrize(
    ("name", "time_s"),
    [
        ("ESC.970621_234744.0001.png", 866936864.0),  # date -ud '1997-06-21 23:47:44' +%s
        ("20230615T101530.jpg", 1686824130.0),  # date -ud '2023-06-15 10:15:30' +%s
        ("cam_2023-06-15_10-15-30_left.png", 1686824130.0),
        ("1423232339.25.png", 1423232339.25),
        ("1423232339250000000.png", 1423232339.25),
        ("frame000123.png", None),
        ("971321_234744.png", None),  # there is no month 13
    ],
)
def test_the_time_in_a_name(name: str, time_s: float | None) -> None:
    assert time_in_name(name) == time_s


def test_exif_tells_the_time_where_names_do_not(cli: Callable[..., Any], tmp_path: Path) -> None:
    folder = folder_of(tmp_path)
    for number, second in ((1, 31), (2, 30)):
        exif = Image.Exif()
        exif.get_ifd(0x8769)[0x9003] = f"2023:06:15 10:15:{second}"
        exif.get_ifd(0x8769)[0x9291] = "25"
        picture(number).save(folder / f"{number}.jpg", exif=exif)
    assert exif_time(folder / "1.jpg") == 1686824131.25
    answer = cli("import", "frames", folder, "--out", tmp_path / "mission")
    assert answer.code == 0
    frames = read_mission(tmp_path / "mission").frames
    assert frames is not None and frames.files == ("2.jpg", "1.jpg")


@pytest.mark.parametrize(
    ("names", "options", "complaint"),
    [
        ((), (), "holds no image"),
        (("a.png",), (), "a.png: neither its name nor its EXIF tells when it was taken; give --times FILE"),
        (("a.png",), ("--interval", "1", "--times", "t.csv"), "--times and --interval: give one of them"),
        (("a.png",), ("--times", "none.csv"), "none.csv: is missing; it needs the columns time_s,file"),
        (("a.png",), ("--interval", "1", "--calibration", "none.yaml"), "none.yaml: No such file"),
    ],
)
def test_what_cannot_be_imported_is_told(
    cli: Callable[..., Any], tmp_path: Path, names: tuple[str, ...], options: tuple[str, ...], complaint: str
) -> None:
    answer = cli("import", "frames", folder_of(tmp_path, *names), *options, "--out", tmp_path / "mission")
    assert answer.code == 2
    assert complaint in answer.err
    assert not (tmp_path / "mission").exists()


def test_jason_stills_of_skerki_bank(cli: Callable[..., Any], data_set: Callable[[str], Path], tmp_path: Path) -> None:
    answer = cli("import", "frames", data_set("skerki") / "images", "--out", tmp_path / "mission", "--json")
    assert answer.code == 0
    frames = read_mission(tmp_path / "mission").frames
    assert frames is not None and len(frames.files) == 266
    contiguous = np.array([539 <= int(name.split(".")[2]) <= 790 for name in frames.files])
    assert float(np.median(np.diff(frames.time_s[contiguous]))) == 13.0
