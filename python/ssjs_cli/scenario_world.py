"""From the tables of a scenario file to what the simulator takes: landmarks, waypoints, its configuration."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ssjs_cli import _core
from ssjs_cli.errors import UserError
from ssjs_cli.formats.number_table import FloatArray
from ssjs_cli.formats.scenario_file import SCAN_PERIOD, STEPS_PER_SCAN, simulator_defaults, toml_keys

#: A scan falls on a step: its period may miss a whole number of steps by rounding alone.
PERIOD_TOLERANCE = 1e-6
#: Beyond this many steps a mission would not fit into memory.
MAX_STEPS = 20_000_000
LANDMARK_ERRORS = {"grid": "grid_field", "random": "random_field"}


def landmarks_of(table: Mapping[str, Any], seed: int, source: str) -> FloatArray:
    """(n, 2) m"""
    if "positions_m" in table:
        return np.array(table["positions_m"], dtype=np.float64)
    kind = "grid" if "grid" in table else "random"
    field = table[kind]
    try:
        if kind == "grid":
            points = _core.grid_field(field["columns"], field["rows"], field["spacing_m"], field["jitter_m"], seed)
        else:
            points = _core.random_field(field["count"], field["width_m"], field["height_m"], field["min_distance_m"], seed)
    except ValueError as error:
        raise UserError(f"{source} [landmarks.{kind}]: {str(error).replace(LANDMARK_ERRORS[kind] + ' ', '')}") from error
    return points + np.array(field["origin_m"], dtype=np.float64)


def waypoints_of(table: Mapping[str, Any]) -> FloatArray:
    """(m, 2) m. With laps the waypoints are a closed circuit, driven so many times and ending at its first point."""
    points = np.array(table["waypoints_m"], dtype=np.float64) if "waypoints_m" in table else _lawn_mower(table["lawn_mower"])
    if "laps" in table:
        return np.vstack([np.tile(points, (table["laps"], 1)), points[:1]])
    return points


def _lawn_mower(spec: Mapping[str, Any]) -> FloatArray:
    """Lines in turn there and back; with return_between the way back runs half a spacing beside the lines, from the last to the first."""
    lines, spacing_m, first_m = spec["lines"], spec["line_spacing_m"], spec["first_line_m"]
    across = [first_m + spacing_m * line for line in range(lines)]
    directions = [line % 2 == 0 for line in range(lines)]
    if spec["return_between"]:
        beyond_m = first_m + spacing_m * (lines - 1) + 0.5 * spacing_m
        across += [beyond_m - spacing_m * line for line in range(lines)]
        directions += [line % 2 == 0 for line in range(lines)]
    points = []
    for place, forward in zip(across, directions, strict=True):
        for along in (spec["start_m"], spec["end_m"]) if forward else (spec["end_m"], spec["start_m"]):
            points.append([along, place] if spec["along"] == "x" else [place, along])
    return np.array(points, dtype=np.float64)


def simulator_config(world: Mapping[str, Any], source: str) -> dict[str, Any]:
    """The flat configuration of the simulator, checked; what the file leaves out keeps its default."""
    places = toml_keys()
    given = {f"{table}.{key}": value for table in ("vehicle", "sensor") for key, value in world.get(table, {}).items()}
    values = {key: given[place] for key, place in places.items() if place in given and key != STEPS_PER_SCAN}
    step_s = float(values.get("step_s", simulator_defaults()["step_s"]))
    values.setdefault("vehicle.noise_step_s", step_s)
    period_s = given.get(f"sensor.{SCAN_PERIOD}")
    if period_s is not None and step_s > 0.0:
        steps = period_s / step_s
        if not (math.isfinite(steps) and round(steps) >= 1 and abs(steps - round(steps)) <= PERIOD_TOLERANCE * steps):
            raise UserError(
                f"{source}: sensor.{SCAN_PERIOD} = {period_s!r}: must be a whole number of steps of {step_s!r} s (vehicle.step_s)"
            )
        values[STEPS_PER_SCAN] = round(steps)
    violations = _core.validate_simulation(values)
    if violations:
        raise UserError("\n".join(f"{source}: {_in_terms_of_the_file(violation)}" for violation in violations))
    return values


def _in_terms_of_the_file(violation: str) -> str:
    """ "speed_m_s = -1: must be positive" names the key of the simulator; in the file it stands in a table."""
    key, rest = violation.split(" ", 1)
    return f"{toml_keys().get(key, key)} {rest}"


def simulate_world(world: Mapping[str, Any], seed: int, source: str) -> dict[str, Any]:
    config = simulator_config(world, source)
    landmarks, waypoints = landmarks_of(world["landmarks"], seed, source), waypoints_of(world["path"])
    for name, points in (("landmarks", landmarks), ("path", waypoints)):
        if not np.isfinite(points).all():
            raise UserError(f"{source} [{name}]: holds a number that is not finite; correct it")
    length_m = float(np.hypot(*np.diff(waypoints, axis=0).T).sum())
    driven_m = float(config.get("speed_m_s", simulator_defaults()["speed_m_s"])) * float(
        config.get("step_s", simulator_defaults()["step_s"])
    )
    if length_m > MAX_STEPS * driven_m:
        raise UserError(f"{source} [path]: {length_m:.0f} m in steps of {driven_m:g} m are too many; shorten the path or lengthen step_s")
    try:
        return _core.simulate_world(landmarks, list(range(len(landmarks))), waypoints, config, seed)
    except ValueError as error:
        text = str(error).replace("World.waypoints", "path.waypoints_m").replace("VehicleSimulationConfig.", "sensor.")
        raise UserError(f"{source}: {text}") from error
