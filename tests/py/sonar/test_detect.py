"""The command `sonar detect`, and the pictures of simulated surveys."""

import csv
import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xtf_files as xtf

from ssjs_cli import _core


def test_a_bright_spot_with_a_shadow_is_a_contact(cli: Callable[..., Any], tmp_path: Path) -> None:
    """Even ground, drawn at 10 m of altitude; starboard echo from 18 to 19 m of slant range with a shadow to 22 m behind it."""
    rng = np.random.default_rng(1)
    samples, range_m = 1000, 30.0
    slant_m = np.arange(samples) * range_m / samples
    pings = []
    for number in range(120):
        sides = []
        for side in ("port", "starboard"):
            level = np.where(slant_m < 10.0, 5.0, 800.0) * rng.uniform(0.8, 1.2, samples)
            if side == "starboard" and 60 <= number < 72:
                level[(slant_m >= 18.0) & (slant_m < 19.0)] = 6000.0
                level[(slant_m >= 19.0) & (slant_m < 22.0)] = 10.0
            sides.append(level.astype(np.uint16))
        pings.append(xtf.ping(number, (sides[0][::-1].copy(), sides[1]), Second=number // 10))
    log = xtf.write(tmp_path / "line.xtf", xtf.file_header(), *pings)
    answer = cli("sonar", "detect", log, "--altitude", "bottom_tracking", "--out", tmp_path / "contacts.csv", "--json")
    document = json.loads(answer.out)
    assert answer.code == 0 and document["pings"] == 120
    (contact,) = document["contacts"]
    assert contact["channel"] == "starboard" and 60 <= contact["ping"] < 72
    assert contact["height_m"] == pytest.approx(10.0 * 3.0 / 22.0, abs=0.1)
    assert math.sqrt(18.5**2 - 10.0**2) < contact["ground_range_m"] < math.sqrt(18.5**2 - 9.0**2) + 0.3
    with (tmp_path / "contacts.csv").open(encoding="utf-8") as file:
        assert [row["ping"] for row in csv.DictReader(file)] == [str(contact["ping"])]
    again = cli("sonar", "detect", log, "--out", tmp_path / "contacts.csv")
    assert again.code == 2 and "--force" in again.err


def test_simulated_pictures_show_what_lies_there() -> None:
    survey = _core.simulated_side_scan_pictures(track={"lines": 1, "line_length_m": 60.0}, objects=12, clearance_m=8.0, seed=2)
    rows = survey["slant"].shape[0]
    assert survey["ground"].shape[0] == rows == len(survey["altitude_m"])
    near = [s for s in survey["sightings"] if abs(s["body_position_m"][1]) > 5.0]
    found = [s for s in near if any(abs(c["body_position_m"][1] - s["body_position_m"][1]) < 1.5 for c in survey["contacts"])]
    assert len(found) >= 0.75 * len(near) > 0
    with pytest.raises(ValueError, match="objects"):
        _core.simulated_side_scan_pictures(track={"lines": 1, "line_length_m": 2.0}, objects=500)
