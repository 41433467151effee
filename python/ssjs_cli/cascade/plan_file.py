"""The plan of a training as TOML: one [[layer]] after the other. Rates are those of the whole cascade up to and with that layer."""

from pathlib import Path
from typing import Any

import tomli_w

from ssjs_cli import _core
from ssjs_cli.errors import UserError, nearest_hint
from ssjs_cli.formats.toml_file import load_toml

Plan = list[tuple[float, float, int, float]]
KEYS = ("detection_rate", "false_positive_rate", "max_features")
#: Of what reaches a layer no more than this part passes it; 1: the cumulative rate says it all.
FALSE_ALARM_KEY = "false_alarm_rate"
ALL_KEYS = (*KEYS, FALSE_ALARM_KEY)


def read_plan(path: Path) -> Plan:
    document = load_toml(path)
    for key in document:
        if key != "layer":
            raise UserError(f"{path}: unknown key '{key}'{nearest_hint(key, ['layer'])}; a plan holds [[layer]] tables")
    layers = document.get("layer")
    if not isinstance(layers, list) or not layers:
        raise UserError(f"{path}: holds no layer; write [[layer]] with {', '.join(KEYS)}")
    plan = [_layer(layer, f"{path}: layer {position}") for position, layer in enumerate(layers, 1)]
    try:
        _core.check_plan(plan)
    except ValueError as error:
        raise UserError(f"{path}: {error}") from error
    return plan


def plan_text(plan: Plan) -> str:
    return tomli_w.dumps({"layer": [dict(zip(ALL_KEYS, layer, strict=True)) for layer in plan]})


def _layer(layer: Any, where: str) -> tuple[float, float, int, float]:
    if not isinstance(layer, dict):
        raise UserError(f"{where}: must be a table, written [[layer]]")
    for key in layer:
        if key not in ALL_KEYS:
            raise UserError(f"{where}: unknown key '{key}'{nearest_hint(key, ALL_KEYS)}")
    layer = {FALSE_ALARM_KEY: 1.0, **layer}
    for key in ALL_KEYS:
        if key not in layer:
            raise UserError(f"{where}: key '{key}' is missing")
        if isinstance(layer[key], bool) or not isinstance(layer[key], int | float):
            raise UserError(f"{where}: {key} = {layer[key]!r}: must be a number")
    if not isinstance(layer["max_features"], int) or not 1 <= layer["max_features"] <= 100_000:
        raise UserError(f"{where}: max_features = {layer['max_features']!r}: must be a whole number from 1 to 100000")
    return float(layer["detection_rate"]), float(layer["false_positive_rate"]), layer["max_features"], float(layer[FALSE_ALARM_KEY])
