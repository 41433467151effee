import csv
import hashlib
import json
import os
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tifffile
from PIL import Image

from ssjs_cli.segmentation.contact_sheet import MAX_IMAGES, shown_positions
from ssjs_cli.segmentation.result_files import OBJECT_KEYS, REGION_KEYS

Cli = Callable[..., Any]
Folder = Callable[..., Path]
#: The morphology of the chain widens a region by one pixel on each side.
DILATION_PX = 1


def table(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def digests(directory: Path, *, without: tuple[str, ...] = ()) -> dict[str, str]:
    return {
        str(path.relative_to(directory)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(directory.rglob("*"))
        if path.is_file() and path.name not in without
    }


def truth_of(folder: Path, stem: str) -> tuple[float, float, int]:
    """Centroid x, y and area of the drawn object."""
    mask = np.asarray(Image.open(folder / "masks" / f"{stem}.png")) != 0
    y, x = np.nonzero(mask)
    return float(x.mean()), float(y.mean()), int(mask.sum())


def test_each_object_is_found_where_it_was_drawn(cli: Cli, scene_folder: Folder, tmp_path: Path) -> None:
    folder = scene_folder(3)
    answer = cli("segment", folder, "--out", tmp_path / "out", "--json")
    assert answer.code == 0, answer.err
    document = json.loads(answer.out)
    assert document["totals"] == {
        "images": 3, "failed": 0, "without_threshold": 0, "second_pass_fired": 0, "regions": 3, "objects": 3
    }  # fmt: skip
    regions = table(tmp_path / "out" / "regions.csv")
    assert tuple(regions[0]) == REGION_KEYS
    assert tuple(table(tmp_path / "out" / "objects.csv")[0]) == OBJECT_KEYS
    for row in regions:
        x_px, y_px, _ = truth_of(folder, row["image"].removesuffix(".png"))
        assert abs(float(row["x_px"]) - x_px) < 0.5
        assert abs(float(row["y_px"]) - y_px) < 0.5
        assert int(row["area_px"]) == (20 + 2 * DILATION_PX) * (12 + 2 * DILATION_PX)
        mask = np.asarray(Image.open(tmp_path / "out" / "masks" / row["image"]))
        assert set(np.unique(mask)) == {0, 255}
        assert int((mask != 0).sum()) == int(row["area_px"])
        assert Image.open(tmp_path / "out" / "overlays" / row["image"]).size == (128, 96)


def test_metres_are_counted_from_the_upper_left_corner_and_from_the_nadir(cli: Cli, scene_folder: Folder, tmp_path: Path) -> None:
    image = scene_folder(1) / "000.png"
    assert cli("segment", image, "--out", tmp_path / "a", "--pixel-size-m", "0.1,0.05").code == 0
    assert cli("segment", image, "--out", tmp_path / "b", "--pixel-size-m", "0.1,0.05", "--nadir", "middle").code == 0
    corner, nadir = table(tmp_path / "a" / "objects.csv")[0], table(tmp_path / "b" / "objects.csv")[0]
    x_px, y_px = float(corner["x_px"]), float(corner["y_px"])
    assert float(corner["along_m"]) == pytest.approx(0.1 * (y_px + 0.5), abs=1e-4)
    assert float(corner["across_m"]) == pytest.approx(0.05 * (x_px + 0.5), abs=1e-4)
    assert float(nadir["across_m"]) == pytest.approx(0.05 * (x_px + 0.5 - 64), abs=1e-4)
    assert float(corner["area_m2"]) == pytest.approx(0.005 * int(corner["area_px"]))


@pytest.mark.parametrize("jobs", [2, 3])
def test_the_same_bytes_at_any_number_of_workers(cli: Cli, scene_folder: Folder, tmp_path: Path, jobs: int) -> None:
    folder = scene_folder(5)
    assert cli("segment", folder, "--out", tmp_path / "one", "--jobs", 1).code == 0
    assert cli("segment", folder, "--out", tmp_path / "more", "--jobs", jobs).code == 0
    one = digests(tmp_path / "one", without=("timing.json",))
    assert one == digests(tmp_path / "more", without=("timing.json",))
    assert {"segmentation.json", "regions.csv", "objects.csv", "config.toml", "contact_sheet.png", "report.html"} < set(one)


def test_its_configuration_gives_the_same_results_again(cli: Cli, scene_folder: Folder, tmp_path: Path) -> None:
    folder = scene_folder(2)
    options = ("--preset", "fls", "--set", "segmentation.gain.kind=local_mean", "--padding", 0, "--method", "max-entropy")
    assert cli("segment", folder, "--out", tmp_path / "one", *options).code == 0
    assert cli("segment", folder, "--out", tmp_path / "two", "--config", tmp_path / "one" / "config.toml").code == 0
    for name in ("regions.csv", "objects.csv", "config.toml"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()
    settings = tomllib.loads((tmp_path / "one" / "config.toml").read_text())
    assert settings["segmentation"]["method"] == "max-entropy"
    assert settings["segmentation"]["dilations"] == 2
    assert settings["segmentation"]["gain"]["kind"] == "local_mean"


def test_one_damaged_file_among_a_hundred_costs_itself_alone(cli: Cli, scene_folder: Folder, tmp_path: Path) -> None:
    folder = scene_folder(100)
    data = (folder / "041.png").read_bytes()
    (folder / "041.png").write_bytes(data[: len(data) // 2])
    answer = cli("segment", folder, "--out", tmp_path / "out", "--jobs", 2, "--json")
    assert answer.code == 3
    document = json.loads(answer.out)
    assert (document["totals"]["images"], document["totals"]["failed"]) == (99, 1)
    assert [entry["image"] for entry in document["failed"]] == ["041.png"]
    assert f"{folder / '041.png'}: is damaged or cut off" in answer.err
    assert len(list((tmp_path / "out" / "masks").iterdir())) == 99
    assert len({row["image"] for row in table(tmp_path / "out" / "regions.csv")}) == 99


def test_nothing_is_left_when_no_image_can_be_used(cli: Cli, tmp_path: Path) -> None:
    (tmp_path / "a.png").write_text("no picture")
    answer = cli("segment", tmp_path / "a.png", "--out", tmp_path / "out")
    assert answer.code == 2
    assert "a.png: is not an image of a known kind" in answer.err
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["a.png"]


def test_flat_and_empty_pictures_have_no_threshold_and_say_so(cli: Cli, tmp_path: Path) -> None:
    folder = tmp_path / "flat"
    folder.mkdir()
    Image.fromarray(np.full((1, 1), 7, dtype=np.uint8)).save(folder / "one_pixel.png")
    Image.fromarray(np.full((40, 50), 90, dtype=np.uint8)).save(folder / "flat.png")
    tifffile.imwrite(folder / "nothing.tif", np.full((30, 20), np.nan, dtype=np.float32))
    answer = cli("segment", folder, "--out", tmp_path / "out", "--json")
    assert answer.code == 0, answer.err
    images = {entry["image"]: entry for entry in json.loads(answer.out)["images"]}
    assert images["flat.png"]["threshold"] is None
    assert images["flat.png"]["reason"] == "its valid pixels have fewer than two levels"
    assert images["one_pixel.png"]["reason"] == "its valid pixels have fewer than two levels"
    assert images["nothing.tif"]["reason"] == "it has no valid pixel"
    assert all(entry["regions"] == 0 for entry in images.values())


@pytest.mark.parametrize("method", ["improved-otsu", "otsu", "local", "iterative", "max-entropy"])
def test_every_method_finds_a_bright_object_on_a_quiet_seabed(cli: Cli, scene_folder: Folder, tmp_path: Path, method: str) -> None:
    folder = scene_folder(2)
    answer = cli("segment", folder, "--method", method, "--out", tmp_path / "out", "--json")
    assert answer.code == 0, answer.err
    document = json.loads(answer.out)
    assert document["method"] == method
    assert (document["images"][0]["threshold"] is None) == (method == "local")
    for stem in ("000", "001"):
        x_px, y_px, _ = truth_of(folder, stem)
        places = [
            (float(row["x_px"]), float(row["y_px"])) for row in table(tmp_path / "out" / "regions.csv") if row["image"] == f"{stem}.png"
        ]
        assert min(np.hypot(x - x_px, y - y_px) for x, y in places) < 1.0


def test_invalid_pixels_never_vote_and_are_never_foreground(cli: Cli, scene_folder: Folder, tmp_path: Path) -> None:
    """A bright block that is masked away leaves the answer for the rest as it was without it."""
    folder = scene_folder(1)
    levels = np.asarray(Image.open(folder / "000.png")).copy()
    valid = np.full(levels.shape, 255, dtype=np.uint8)
    valid[:6, :] = 0
    Image.fromarray(valid).save(tmp_path / "valid.png")
    numbers = []
    for name, value in (("quiet", 0), ("loud", 255)):
        levels[:6, :] = value
        (tmp_path / name).mkdir()
        Image.fromarray(levels).save(tmp_path / name / "a.png")
        assert cli("segment", tmp_path / name, "--mask", tmp_path / "valid.png", "--out", tmp_path / f"{name}-out").code == 0
        mask = np.asarray(Image.open(tmp_path / f"{name}-out" / "masks" / "a.png"))
        assert not mask[:6].any()
        numbers.append((tmp_path / f"{name}-out" / "regions.csv").read_bytes())
    assert numbers[0] == numbers[1]


def test_masks_of_a_folder_go_with_their_images(cli: Cli, scene_folder: Folder, tmp_path: Path) -> None:
    folder = scene_folder(2)
    (folder / "masks" / "001.png").unlink()
    answer = cli("segment", folder, "--mask", folder / "masks", "--out", tmp_path / "out")
    assert answer.code == 3
    assert "has no mask 001.png" in answer.err


def test_a_mask_of_another_size_is_refused(cli: Cli, scene_folder: Folder, tmp_path: Path) -> None:
    Image.fromarray(np.full((5, 5), 255, dtype=np.uint8)).save(tmp_path / "valid.png")
    answer = cli("segment", scene_folder(1), "--mask", tmp_path / "valid.png", "--out", tmp_path / "out")
    assert answer.code == 2
    assert "has 5 x 5 pixels and" in answer.err


def test_padding_and_a_stated_value_are_invalid(cli: Cli, scene_folder: Folder, tmp_path: Path) -> None:
    levels = np.asarray(Image.open(scene_folder(1) / "000.png")).copy()
    levels = np.maximum(levels, 1)
    padded = np.pad(levels, ((0, 40), (0, 0)))
    padded[50:53, 5:8] = 0  # dark, but inside the picture: a measurement
    Image.fromarray(padded).save(tmp_path / "a.png")
    for options, invalid in ((("--padding", 0), 40 * 128), (("--invalid-value", 0), 40 * 128 + 9), ((), 0)):
        out = tmp_path / f"out{invalid}"
        answer = cli("segment", tmp_path / "a.png", "--out", out, *options, "--json")
        assert answer.code == 0, answer.err
        assert json.loads(answer.out)["images"][0]["valid_fraction"] == pytest.approx(1 - invalid / padded.size, abs=1e-6)


def test_images_of_one_name_from_two_folders_do_not_collide(cli: Cli, scene_folder: Folder, tmp_path: Path) -> None:
    east, west = scene_folder(2, "east"), scene_folder(2, "west")
    assert cli("segment", east, west, "--out", tmp_path / "out").code == 0
    assert sorted(path.name for path in (tmp_path / "out" / "masks").iterdir()) == [
        "east--000.png", "east--001.png", "west--000.png", "west--001.png"
    ]  # fmt: skip
    assert [row["image"] for row in table(tmp_path / "out" / "regions.csv")] == [
        "east/000.png", "east/001.png", "west/000.png", "west/001.png"
    ]  # fmt: skip


def test_intermediates_hold_every_stage(cli: Cli, scene_folder: Folder, tmp_path: Path) -> None:
    answer = cli(
        "segment", scene_folder(1), "--keep-intermediates", "--set", "segmentation.filter.kind=gaussian", "--out", tmp_path / "out"
    )
    assert answer.code == 0, answer.err
    folder = tmp_path / "out" / "intermediates" / "000"
    names = ["1_filtered", "2_normalised", "3_contrasted", "4_thresholded", "5_cleaned", "6_bridged", "7_dilated"]
    assert sorted(path.stem for path in folder.iterdir()) == names
    thresholded = np.asarray(Image.open(folder / "4_thresholded.png"))
    contrasted = np.asarray(Image.open(folder / "3_contrasted.png"))
    threshold = json.loads((tmp_path / "out" / "segmentation.json").read_text())["images"][0]["threshold"]
    np.testing.assert_array_equal(thresholded != 0, contrasted > threshold)


def test_a_highlight_with_a_shadow_is_an_object_with_a_height(cli: Cli, tmp_path: Path) -> None:
    """Ground ranges: h = altitude (tip - start) / tip. The block ends 60 columns from the nadir, its shadow 90."""
    rng = np.random.default_rng(2)
    levels = np.clip(90 * rng.gamma(30.0, 1.0 / 30.0, (100, 200)), 0, 255).astype(np.uint8)
    levels[40:52, 150:160] = 250
    levels[40:52, 160:190] = 2
    levels[70:82, 20:40] = 250  # bright without a shadow
    Image.fromarray(levels).save(tmp_path / "a.png")
    answer = cli(
        "segment", tmp_path / "a.png", "--out", tmp_path / "out", "--objects", "shadows", "--nadir", "middle", "--altitude-m", 10,
        "--pixel-size-m", "0.1,0.1", "--set", "objects.ranges=ground", "--set", "shadows.median_px=3", "--set", "shadows.levels=grey",
    )  # fmt: skip
    assert answer.code == 0, answer.err
    objects = table(tmp_path / "out" / "objects.csv")
    assert [row["side"] for row in objects] == ["starboard"]
    (row,) = objects
    assert float(row["x_px"]) == pytest.approx(154.5, abs=1.0)
    assert float(row["shadow_length_px"]) == pytest.approx(30, abs=2)
    assert float(row["height_m"]) == pytest.approx(10 * 30 / 90, abs=0.3)
    assert row["shadow_is_cut"] == "false"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ("--method", "outsu"),
            "--method: segmentation.method = 'outsu': must be one of improved-otsu, otsu, local, iterative, max-entropy",
        ),
        (("--preset", "sss"), "--preset sss: must be one of auto, sss-high, sss-low, fls"),
        (("--set", "segmentation.dilation=2"), "--set: unknown key 'segmentation.dilation' (did you mean 'segmentation.dilations'?)"),
        (("--set", "segmentation.filter.median_px=4"), "segmentation.filter.median_px = 4: must be odd"),
        (("--set", "segmentation.dilations=-1"), "--set: segmentation.dilations = -1: must lie in"),
        (("--pixel-size-m", "0.1"), "--pixel-size-m 0.1: must be two numbers ALONG,ACROSS"),
        (("--pixel-size-m", "0.1,-1"), "--pixel-size-m: image.pixel_across_m = -1.0: must be positive"),
        (("--objects", "shadows"), "image.nadir: objects from shadows need it"),
        (("--nadir", "centre"), "--nadir centre: must be left, middle, right, none or a column"),
        (("--mask", "absent.png"), "absent.png: No such file or directory; check the path of --mask"),
        (("--invalid-value", "-3"), "--invalid-value: image.invalid_value = -3: must lie in [0, 65535]"),
    ],
)
def test_wrong_settings_are_named_with_the_mend(
    cli: Cli, scene_folder: Folder, tmp_path: Path, arguments: tuple[str, ...], message: str
) -> None:
    answer = cli("segment", scene_folder(1), "--out", tmp_path / "out", *arguments)
    assert answer.code == 2
    assert message in answer.err
    assert not (tmp_path / "out").exists()


def test_results_are_replaced_only_when_asked_for_and_only_if_ours(cli: Cli, scene_folder: Folder, tmp_path: Path) -> None:
    folder = scene_folder(1)
    assert cli("segment", folder, "--out", tmp_path / "out").code == 0
    assert cli("segment", folder, "--out", tmp_path / "out").code == 2
    assert cli("segment", folder, "--out", tmp_path / "out", "--force").code == 0
    (tmp_path / "out" / "mine.txt").write_text("x")
    answer = cli("segment", folder, "--out", tmp_path / "out", "--force")
    assert answer.code == 2
    assert "it also holds mine.txt" in answer.err


def test_results_hold_no_path_of_this_machine(cli: Cli, scene_folder: Folder, tmp_path: Path) -> None:
    assert cli("segment", scene_folder(2), "--out", tmp_path / "out").code == 0
    for path in (tmp_path / "out").rglob("*"):
        if path.is_file():
            assert os.fsencode(tmp_path) not in path.read_bytes(), path


def test_the_page_fetches_nothing_and_escapes_names(cli: Cli, scene_folder: Folder, tmp_path: Path) -> None:
    folder = scene_folder(1)
    (folder / "000.png").rename(folder / "a&b <i>'.png")
    assert cli("segment", folder, "--out", tmp_path / "out").code == 0
    page = (tmp_path / "out" / "report.html").read_text()
    assert "<i>'" not in page
    assert "a&amp;b &lt;i&gt;" in page
    assert "http://" not in page
    assert "https://" not in page
    assert 'href="overlays/a%26b%20%3Ci%3E%27.png"' in page


def test_sheets_show_a_bounded_number_of_images_evenly() -> None:
    assert shown_positions(5) == [0, 1, 2, 3, 4]
    shown = shown_positions(1000)
    assert len(shown) == MAX_IMAGES
    assert (shown[0], shown[-1]) == (0, 999)
    assert len(set(shown)) == MAX_IMAGES
    gaps = np.diff(shown)
    assert gaps.max() - gaps.min() <= 1


def test_real_side_scan_tiles(cli: Cli, data_set: Callable[[str], Path], tmp_path: Path) -> None:
    """The eight tiles of one recording: what is told of the second pass agrees with itself."""
    folder = data_set("sdvd") / "images"
    answer = cli("segment", f"{folder}/*20240429113709*.png", f"{folder}/*20240429113711*.png", "--out", tmp_path / "out", "--json")
    assert answer.code == 0, answer.err
    document = json.loads(answer.out)
    assert document["totals"]["images"] == 8
    for entry in document["images"]:
        assert (entry["width_px"], entry["height_px"], entry["bits"]) == (256, 256, 8)
        assert entry["notes"] == []
        assert entry["second_pass_fired"] == (entry["spots"] > entry["spot_limit"])
        assert (
            entry["threshold"] > entry["first_threshold"] if entry["second_pass_fired"] else entry["threshold"] == entry["first_threshold"]
        )
