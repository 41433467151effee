"""The built-in sonar loop whose scans are found in simulated pictures: its settings, and its simulation. docs/paper_chain.md"""

from collections.abc import Mapping
from typing import Any

from ssjs_cli import _core
from ssjs_cli.config import Scalar, SettingsKind, described_by_core, layer_from_assignments, layer_from_tables, resolve
from ssjs_cli.errors import UserError

SONAR_LOOP = "aekf-loop-images"
#: The scenario of points that the pictures are made of.
_POINTS = "aekf-loop"

PICTURES = SettingsKind(
    "Pictures",
    "segmentation.method=max-entropy",
    lambda: described_by_core(_core.sonar_loop_fields()),
    lambda values: _core.validate_sonar_loop(values),
)


def picture_settings(scenario: str, tables: Mapping[str, Any], source: str, assignments: tuple[str, ...] = ()) -> dict[str, Scalar]:
    """What is said about the pictures, checked: first the table of a scenario file, then --set."""
    if not tables and not assignments:
        return {}
    if scenario != SONAR_LOOP:
        said = "--set" if assignments else f"{source} [pictures]"
        raise UserError(f"{said}: scenario '{scenario}' has no pictures to set; {SONAR_LOOP} has")
    layers = [layer_from_tables(tables, f"{source} [pictures]", PICTURES), layer_from_assignments(assignments, PICTURES)]
    resolve(layers, PICTURES)
    return {key: value for layer in layers for key, value in layer.values.items()}


def simulate_sonar_loop(pictures: Mapping[str, Scalar], seed: int) -> dict[str, Any]:
    """Columns as of `_core.simulate`, and `notes`: what the pictures came to."""
    simulated = _core.simulate_sonar_loop(_POINTS, pictures, seed)
    counts = simulated["counts"]
    simulated["notes"] = (
        f"{counts['pictures']} pictures, {counts['regions']} regions: {counts['of_landmarks']} of landmarks, {counts['of_spots']} of other "
        f"spots, {counts['of_nothing']} of nothing; {counts['merged']} hold more than one of them. Mean threshold "
        f"{counts['mean_threshold']:.1f}; {counts['second_passes']} second passes."
    )
    return simulated
