import json
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from ssjs_cli.config import field_descriptions, flatten


def test_dump_is_complete_and_is_accepted_by_check(cli: Callable[..., Any], tmp_path: Path) -> None:
    answer = cli("config", "dump", "--set", "sensor.range_sigma_m=0.25", "--seed", 5)
    assert answer.code == 0
    document = tomllib.loads(answer.out)
    assert document.pop("seed") == 5
    assert [key for key, _ in flatten(document)] == list(field_descriptions())
    assert document["sensor"]["range_sigma_m"] == 0.25
    (tmp_path / "config.toml").write_text(answer.out)
    assert cli("config", "check", tmp_path / "config.toml").code == 0


def test_dump_as_json_holds_the_same(cli: Callable[..., Any]) -> None:
    assert json.loads(cli("config", "dump", "--json").out) == tomllib.loads(cli("config", "dump").out)


def test_dump_into_a_file_does_not_overwrite(cli: Callable[..., Any], tmp_path: Path) -> None:
    path = tmp_path / "config.toml"
    assert cli("config", "dump", "--out", path).code == 0
    assert path.read_text() == cli("config", "dump").out
    assert cli("config", "dump", "--out", path).code == 2
    assert cli("config", "dump", "--out", path, "--force").code == 0


def test_schema_is_a_json_schema(cli: Callable[..., Any]) -> None:
    schema = json.loads(cli("config", "schema", "--json").out)
    assert schema["type"] == "object"
    assert schema["additionalProperties"] is False


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[sensor]\nrange_sigm_m = 1.0\n", "unknown key 'sensor.range_sigm_m' (did you mean 'sensor.range_sigma_m'?)"),
        ("[sensor]\nrange_sigma_m = 0.0\n", "sensor.range_sigma_m = 0: must be positive"),
        ("[sensor\n", "is not valid TOML"),
    ],
)
def test_check_refuses_faulty_files(cli: Callable[..., Any], tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "config.toml").write_text(text)
    answer = cli("config", "check", tmp_path / "config.toml")
    assert answer.code == 2
    assert message in answer.err


def test_check_takes_missions(cli: Callable[..., Any], circle_mission: Path) -> None:
    answer = cli("config", "check", circle_mission, "--json")
    assert answer.code == 0
    assert json.loads(answer.out)["settings"]["vehicle.kind"] == "unicycle"


def test_check_of_a_missing_file(cli: Callable[..., Any], tmp_path: Path) -> None:
    answer = cli("config", "check", tmp_path / "none.toml")
    assert answer.code == 2
    assert "none.toml: is missing; check the path" in answer.err


def test_settings_of_segmentation_are_dumped_described_and_checked(cli: Callable[..., Any], tmp_path: Path) -> None:
    answer = cli("config", "dump", "--of", "segmentation", "--set", "segmentation.dilations=3")
    assert answer.code == 0, answer.err
    document = tomllib.loads(answer.out)
    assert document["segmentation"]["dilations"] == 3
    assert set(document) == {"seed", "segmentation", "shadows", "image", "objects"}
    (tmp_path / "a.toml").write_text(answer.out)
    assert cli("config", "check", tmp_path / "a.toml", "--of", "segmentation").code == 0
    assert cli("config", "check", tmp_path / "a.toml").code == 2
    assert "segmentation" in json.loads(cli("config", "schema", "--of", "segmentation").out)["properties"]


def test_settings_of_pictures_are_dumped(cli: Callable[..., Any]) -> None:
    answer = cli("config", "dump", "--of", "pictures", "--set", "segmentation.method=max-entropy")
    assert answer.code == 0, answer.err
    document = tomllib.loads(answer.out)
    assert document["segmentation"]["method"] == "max-entropy"
    # The paper's settings for its low-resolution picture
    assert document["segmentation"]["improved_otsu"] == {"spot_px": 15, "spot_limit": 100, "canny_high": 0.1255}
