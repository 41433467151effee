import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from ssjs_cli.config import (
    Layer,
    Settings,
    defaults,
    field_descriptions,
    flatten,
    json_schema,
    layer_from_assignments,
    layer_from_file,
    layer_from_flag,
    layer_from_tables,
    nest,
    resolve,
)
from ssjs_cli.errors import UserError

RANGE_SIGMA = "sensor.range_sigma_m"


def refused(function: Callable[..., Any], *arguments: Any) -> str:
    with pytest.raises(UserError) as caught:
        function(*arguments)
    return str(caught.value)


def test_the_defaults_are_valid_and_are_those_of_the_estimator() -> None:
    settings = resolve([])
    assert dict(settings.values) == {key: described.default for key, described in field_descriptions().items()}


def test_nest_and_flatten_are_inverse() -> None:
    flat = {"a": 1, "b.c": 2.5, "b.d.e": "x"}
    assert nest(flat) == {"a": 1, "b": {"c": 2.5, "d": {"e": "x"}}}
    assert dict(flatten(nest(flat))) == flat


@pytest.mark.parametrize(
    ("nested", "key", "nearest"),
    [
        ({"mehtod": "ssjs"}, "mehtod", "method"),
        ({"sensor": {"range_sigma": 0.1}}, "sensor.range_sigma", "sensor.range_sigma_m"),
        ({"vehicle": {"ackerman": {"wheelbas_m": 2.0}}}, "vehicle.ackerman.wheelbas_m", "vehicle.ackerman.wheelbase_m"),
        ({"vehicel": {"kind": "ackerman"}}, "vehicel", "vehicle"),
        ({"sensor": {"wheelbase_m": 2.0}}, "sensor.wheelbase_m", "vehicle.ackerman.wheelbase_m"),
    ],
)
def test_an_unknown_key_fails_at_any_depth_with_the_nearest_one(nested: dict[str, Any], key: str, nearest: str) -> None:
    assert refused(layer_from_tables, nested, "file.toml") == f"file.toml: unknown key '{key}' (did you mean '{nearest}'?)"


@pytest.mark.parametrize(
    ("nested", "message"),
    [
        ({"sensor": {"range_sigma_m": "wide"}}, 'file.toml: sensor.range_sigma_m = "wide": must be a number'),
        ({"sensor": {"range_sigma_m": True}}, "file.toml: sensor.range_sigma_m = true: must be a number"),
        ({"association": {"node_budget": 1.5}}, "file.toml: association.node_budget = 1.5: must be a whole number"),
        ({"submap": {"max_landmarks": "many"}}, 'file.toml: submap.max_landmarks = "many": must be a whole number or "none"'),
        ({"submap": {"split_boundary_scan": 1}}, "file.toml: submap.split_boundary_scan = 1: must be true or false"),
        ({"sensor": 3}, "file.toml: sensor = 3: must be a table, written [sensor]"),
    ],
)
def test_a_wrong_type_names_the_key_and_what_it_must_be(nested: dict[str, Any], message: str) -> None:
    assert refused(layer_from_tables, nested, "file.toml") == message


def test_a_wrong_choice_lists_the_choices_and_the_nearest() -> None:
    message = refused(layer_from_tables, {"association": {"method": "jcb"}}, "file.toml")
    assert message.startswith('file.toml: association.method = "jcb": must be one of ')
    assert "known" in message
    assert message.endswith("(did you mean 'jcbb'?)")


def test_every_fault_of_a_file_is_reported_at_once() -> None:
    message = refused(layer_from_tables, {"mehtod": "ssjs", "sensor": {"range_sigma_m": "wide"}}, "file.toml")
    assert len(message.splitlines()) == 2


def test_a_whole_number_serves_where_a_number_is_wanted() -> None:
    layer = layer_from_tables({"sensor": {"max_range_m": 40}}, "file.toml")
    assert repr(layer.values["sensor.max_range_m"]) == "40.0"


def test_an_optional_setting_is_turned_off_by_none() -> None:
    assert layer_from_tables({"submap": {"max_landmarks": "none"}}, "f").values == {"submap.max_landmarks": None}
    assert layer_from_assignments(["submap.max_landmarks=none"]).values == {"submap.max_landmarks": None}


@pytest.mark.parametrize("value", [0.0, -0.1])
def test_zero_or_negative_noise_breaks_a_rule_and_names_its_source(value: float) -> None:
    message = refused(resolve, [Layer("mission.toml [settings]", {RANGE_SIGMA: value})])
    assert message.startswith(f"mission.toml [settings]: {RANGE_SIGMA} = ")
    assert "must be positive" in message


def test_nan_breaks_a_rule() -> None:
    assert RANGE_SIGMA in refused(resolve, [Layer("--set", {RANGE_SIGMA: float("nan")})])


def test_all_violated_rules_are_reported() -> None:
    message = refused(resolve, [Layer("--set", {RANGE_SIGMA: 0.0, "association.gate_probability": 1.2})])
    assert RANGE_SIGMA in message
    assert "association.gate_probability" in message


def test_later_layers_win() -> None:
    layers = [Layer("mission", {RANGE_SIGMA: 0.2, "sensor.max_range_m": 20.0}), Layer("--set", {RANGE_SIGMA: 0.3})]
    settings = resolve(layers)
    assert settings.values[RANGE_SIGMA] == 0.3
    assert settings.values["sensor.max_range_m"] == 20.0
    assert settings.origin[RANGE_SIGMA] == "--set"


@pytest.mark.parametrize(
    ("assignment", "message"),
    [
        ("sensor.range_sigma_m", "--set sensor.range_sigma_m: must be key=value, for example --set submap.max_landmarks=20"),
        ("sensor.range_sigm_m=1", "--set: unknown key 'sensor.range_sigm_m' (did you mean 'sensor.range_sigma_m'?)"),
        ("sensor.range_sigma_m=wide", "--set: sensor.range_sigma_m = 'wide': must be a number"),
        ("association.node_budget=1.5", "--set: association.node_budget = '1.5': must be a whole number"),
        ("submap.split_boundary_scan=yes", "--set: submap.split_boundary_scan = 'yes': must be true or false"),
    ],
)
def test_a_wrong_assignment_says_what_it_must_be(assignment: str, message: str) -> None:
    assert refused(layer_from_assignments, [assignment]) == message


def test_assignments_are_read_as_the_type_of_their_key() -> None:
    texts = ["sensor.range_sigma_m=2", "association.node_budget=70", "submap.split_boundary_scan=false", "method=ekf"]
    assert list(layer_from_assignments(texts).values.values()) == [2.0, 70, False, "ekf"]


def test_a_flag_is_short_for_a_setting() -> None:
    assert layer_from_flag("--method", "method", "ekf").values == {"method": "ekf"}
    assert layer_from_flag("--method", "method", None).values == {}
    assert refused(layer_from_flag, "--method", "method", "efk").startswith("--method: method = 'efk': must be one of ")


def test_the_written_configuration_reads_back_the_same(tmp_path: Path) -> None:
    settings = resolve([Layer("--set", {RANGE_SIGMA: 0.1 + 0.2, "submap.max_landmarks": None, "method": "ekf"})])
    path = tmp_path / "config.toml"
    path.write_text(settings.to_toml(seed=7))
    layer, seed = layer_from_file(path)
    assert seed == 7
    again = resolve([layer])
    assert dict(again.values) == dict(settings.values)
    assert again.to_toml(7) == settings.to_toml(7)


def test_the_written_configuration_is_complete() -> None:
    document = tomllib.loads(Settings(defaults()).to_toml(seed=1))
    assert document.pop("seed") == 1
    assert [key for key, _ in flatten(document)] == list(field_descriptions())


@pytest.mark.parametrize("seed", ["-1", "1.5", '"x"', "true"])
def test_a_wrong_seed_in_a_file_is_refused(seed: str, tmp_path: Path) -> None:
    path = tmp_path / "config.toml"
    path.write_text(f"seed = {seed}\n")
    assert "seed = " in refused(layer_from_file, path)


def test_broken_toml_names_the_line(tmp_path: Path) -> None:
    path = tmp_path / "config.toml"
    path.write_text("[sensor]\nrange_sigma_m = \n")
    message = refused(layer_from_file, path)
    assert str(path) in message
    assert "line 2" in message


def test_the_schema_forbids_unknown_keys_and_describes_every_setting() -> None:
    schema = json_schema()
    assert schema["additionalProperties"] is False
    described = [name for table in [schema, *schema["$defs"].values()] for name in table["properties"]]
    for key in field_descriptions():
        assert key.rsplit(".", 1)[-1] in described
