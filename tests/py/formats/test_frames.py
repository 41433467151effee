import re
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest

from ssjs_cli.errors import UserError
from ssjs_cli.formats.camera_calibration import CameraCalibration, calibration_text, read_calibration
from ssjs_cli.formats.frame_image import FrameError, decoded
from ssjs_cli.formats.frames import FrameIndex, frame_digests, read_frames
from ssjs_cli.formats.mission import Mission, input_digests, is_underwater, read_mission, read_mission_outline, write_mission
from ssjs_cli.studies.mission_manifest import signature_of

CALIBRATION = CameraCalibration(320, 240, 300.25, 301.5, 160.0, 119.5, lens="brown", distortion=(-0.2, 0.05, 0.0, 0.001, 0.0))


def mission_of(tmp_path: Path, index: str | None, **files: str) -> Path:
    directory = tmp_path / "mission"
    (directory / "frames").mkdir(parents=True)
    (directory / "mission.toml").write_text('[mission]\nname = "a"\n')
    if index is not None:
        (directory / "frames" / "index.csv").write_text(index)
    for name, text in files.items():
        (directory / name.replace("__", ".")).write_text(text)
    return directory


def written(tmp_path: Path) -> Path:
    frames = FrameIndex(Path("elsewhere"), np.array([0.1 + 0.2, 1.0, 1.0]), ("b.png", "a,1.png", "c.png"), CALIBRATION)
    directory = tmp_path / "written"
    directory.mkdir()

    def take(folder: Path) -> None:
        for name in frames.files:
            (folder / name).write_bytes(name.encode())

    write_mission(directory, Mission("seen", frames=frames, photographs=take))
    return directory


def test_what_is_written_reads_back_to_the_last_bit(tmp_path: Path) -> None:
    directory = written(tmp_path)
    read = read_mission(directory)
    assert read.frames is not None and read.has_frames_alone and is_underwater(directory)
    np.testing.assert_array_equal(read.frames.time_s, [0.1 + 0.2, 1.0, 1.0])
    assert read.frames.files == ("b.png", "a,1.png", "c.png")
    assert read.frames.calibration == CALIBRATION
    assert read.frames.path(1).read_bytes() == b"a,1.png"


def test_frames_come_with_navigation_or_alone(tmp_path: Path) -> None:
    directory = mission_of(tmp_path, "file,time_s\nx.png,0\n", imu__csv="time_s,roll_rad,pitch_rad,yaw_rad\n0,0,0,0\n1,0,0,0\n")
    read = read_mission(directory)
    assert read.frames is not None and read.navigation is not None and not read.has_frames_alone
    assert read.frames.calibration is None
    outline = read_mission_outline(directory)
    assert outline.frames is not None and outline.frames.files == ()


def test_a_change_of_any_picture_changes_digests_and_signature(tmp_path: Path) -> None:
    directory = written(tmp_path)
    digests, signature = input_digests(directory), signature_of(directory)
    assert {"frames/index.csv", "frames/camera.yaml", "frames/*"} <= set(digests)
    (directory / "frames" / "c.png").write_bytes(b"other picture")
    changed = frame_digests(directory)
    assert [name for name, digest in changed.items() if digests[name] != digest] == ["frames/*"]
    assert signature_of(directory) != signature


@pytest.mark.parametrize(
    ("index", "complaint"),
    [
        (None, r"frames/index\.csv: is missing"),
        ("", r"index\.csv: names no frame"),
        ("time_s,file\n", r"index\.csv: names no frame"),
        ("time_s,files\n0,a.png\n", r"index\.csv:1: unknown column 'files' \(did you mean 'file'"),
        ("time_s\n0\n", r"index\.csv:1: column file must be there once"),
        ("time_s,file\n# a remark\n1,a.png\n0,b.png\n", r"index\.csv:4: time_s = 0\.0 goes back"),
        ("time_s,file\n1,a.png\n1,\n", r"index\.csv:3: file = '' is no name"),
        ("time_s,file\n1,../a.png\n", r"index\.csv:2: file = '\.\./a\.png' is no name"),
        ("time_s,file\n1,index.csv\n", r"index\.csv:2: file = 'index\.csv' is no name"),
        ("time_s,file\n\n\nnoon,a.png\n", r"index\.csv:4: time_s = 'noon' is not a number"),
        ("time_s,file\n0,z.png\nnan,a.png\n", r"index\.csv:3: time_s is empty or NaN"),
        ("time_s,file\n1e15,a.png\n", r"index\.csv:2: time_s = .* convert milliseconds"),
        ("time_s,file\n1,a.png,3\n", r"index\.csv:2: has 3 fields where 2"),
        ('time_s,file\n1,"a.png\n', r"index\.csv:\d: cannot be read"),
    ],
)
def test_a_fault_of_the_index_is_named_with_its_line(tmp_path: Path, index: str | None, complaint: str) -> None:
    with pytest.raises(UserError, match=complaint):
        read_mission(mission_of(tmp_path, index))


def test_a_file_in_place_of_the_folder_is_named(tmp_path: Path) -> None:
    (tmp_path / "frames").write_text("")
    with pytest.raises(UserError, match="is no folder"):
        read_frames(tmp_path)


def test_frames_beside_odometry_in_the_plane_are_refused(tmp_path: Path) -> None:
    directory = mission_of(tmp_path, "time_s,file\n0,a.png\n", odometry__csv="time_s,speed_m_s,turn_rate_rad_s\n0,1,0\n1,1,0\n")
    with pytest.raises(UserError, match=r"remove odometry\.csv, or the folder"):
        read_mission(directory)


def test_a_calibration_that_is_none_is_named(tmp_path: Path) -> None:
    directory = mission_of(tmp_path, "time_s,file\n0,a.png\n")
    (directory / "frames" / "camera.yaml").write_text("nothing: 1\n")
    with pytest.raises(UserError, match=r"frames/camera\.yaml: has neither"):
        read_mission(directory)


@pytest.mark.parametrize(
    ("was", "becomes", "complaint"),
    [
        ("[320.0", "[-320.0", "focal_x_px = -320: must be positive"),
        ("159.5", "15900.5", "centre_x_px = 15900.5: must lie in the frame"),
        ("image_width: 320", "image_width: 1000000000", "is of 1000000000 x 240 pixels, more than 80 million"),
        ("-0.12", "-12.0", "folds inside the frame"),
    ],
)
def test_a_calibration_that_cannot_be_is_named_with_its_fault(tmp_path: Path, was: str, becomes: str, complaint: str) -> None:
    text = calibration_text(CameraCalibration(320, 240, 320.0, 320.0, 159.5, 119.5, 0.0, "brown", (-0.12, 0.02, 0.0, 0.0, 0.0)))
    (tmp_path / "camera.yaml").write_text(text.replace(was, becomes))
    assert was in text
    with pytest.raises(UserError, match=re.escape(complaint)):
        read_calibration(tmp_path / "camera.yaml")


def png_header(width: int, height: int) -> bytes:
    chunk = b"IHDR" + struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + chunk + struct.pack(">I", zlib.crc32(chunk)) + b"\0\0\0\0IDAT"


@pytest.mark.filterwarnings("ignore::PIL.Image.DecompressionBombWarning")
@pytest.mark.parametrize("size", [(2**31 - 1, 2**31 - 1), (20_000, 9_000), (12_000, 10_000)])
def test_a_frame_of_absurd_size_is_named_before_its_pixels_are_read(size: tuple[int, int]) -> None:
    with pytest.raises(FrameError, match="pixels") as refusal:
        decoded(png_header(*size))
    assert "80 million" in str(refusal.value)


def test_a_mission_without_frames_has_none(tmp_path: Path) -> None:
    assert read_frames(tmp_path) is None
    assert frame_digests(tmp_path) == {}
