"""The merged map of a season, from simulated missions through `run` to contacts: right pairs, honest covariances, missions apart."""

import csv
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from season_scenario import Score, identities, scenario_text, score, true_objects

from ssjs_cli.formats.landmark_covariance import read_landmark_covariance
from ssjs_cli.formats.number_table import read_table
from ssjs_cli.studies.season_map import season_map

MISSIONS = 6
Cli = Callable[..., Any]


def season_of(cli: Cli, folder: Path, seeds: range, seabed: dict[str, float] | None = None) -> list[Path]:
    scenario = folder / "dive.toml"
    folder.mkdir(parents=True, exist_ok=True)
    scenario.write_text(scenario_text(seabed))
    missions = [folder / f"dive{seed}" for seed in seeds]
    for seed, mission in zip(seeds, missions, strict=True):
        assert cli("simulate", scenario, "--seed", seed, "--out", mission).code == 0
    return missions


def contacts_in(season: Path) -> list[dict[str, str]]:
    with (season / "season_contacts.csv").open() as file:
        return list(csv.DictReader(file))


def test_missions_over_one_seabed_become_one_map(cli: Cli, tmp_path: Path) -> None:
    missions = season_of(cli, tmp_path, range(1, MISSIONS + 1))
    season = tmp_path / "season"
    assert cli("batch", *missions, "--out", season, "--no-report").code == 0
    runs = sorted((season / "missions").iterdir())
    made = season_map(runs)
    found = score(made, true_objects(), identities(runs))
    assert found.right >= 30 and found.wrong <= 1, found
    assert found.missed <= 0.15 * found.right, found
    assert 0.2 < np.mean(found.nees) / 2.0 < 2.0  # contacts share the errors of six frames: no more than six samples
    placed = {mission.name: mission for region in made.regions for mission in region.missions}
    assert all(mission.sigma_m < 3.0 for mission in placed.values())  # each origin is sure to 3 m

    rows = contacts_in(season)
    assert sum(int(row["missions"]) > 1 for row in rows) >= 12
    features = json.loads((season / "season_contacts.geojson").read_text())["features"]
    kinds = [feature["properties"]["kind"] for feature in features]
    assert kinds.count("track") == MISSIONS and kinds.count("contact") == kinds.count("ellipse") == len(rows)
    page = (season / "report.html").read_text()
    assert "seen by several" in page and 'id="map"' in page


def test_the_order_of_the_command_line_does_not_matter(cli: Cli, tmp_path: Path) -> None:
    missions = season_of(cli, tmp_path, range(1, 4))
    for name, chosen in (("forth", missions), ("back", missions[::-1])):
        assert cli("batch", *chosen, "--out", tmp_path / name, "--no-report").code == 0
    for name in ("season_contacts.csv", "season_contacts.geojson"):
        assert (tmp_path / "forth" / name).read_bytes() == (tmp_path / "back" / name).read_bytes()


def test_missions_without_a_common_reference_stay_apart(cli: Cli, tmp_path: Path) -> None:
    missions = season_of(cli, tmp_path, range(1, 4))
    nowhere = missions[0] / "mission.toml"
    nowhere.write_text(
        "\n".join(line for line in nowhere.read_text().splitlines() if not line.startswith(("origin_", "[geodetic]", "heading_", "y_axis")))
    )
    season = tmp_path / "season"
    assert cli("batch", *missions, "--out", season, "--no-report").code == 0
    made = json.loads((season / "season_map.json").read_text())
    assert [len(region["missions"]) for region in made["regions"]] == [2]
    (apart,) = made["apart"]
    assert "no place on earth" in apart["reason"] and apart["mission"] in (season / "report.html").read_text()
    assert not any(apart["mission"] in row["seen_by"] for row in contacts_in(season))


def test_far_seas_are_regions_of_their_own(cli: Cli, tmp_path: Path) -> None:
    near = season_of(cli, tmp_path / "near", range(1, 3))
    far = season_of(cli, tmp_path / "far", range(1, 3), {"latitude_deg": 43.0})
    season = tmp_path / "season"
    assert cli("batch", *near, *far, "--out", season, "--no-report").code == 0
    made = json.loads((season / "season_map.json").read_text())
    assert [len(region["missions"]) for region in made["regions"]] == [2, 2]
    latitudes = [float(row["latitude_deg"]) for row in contacts_in(season)]
    assert any(latitude > 42.9 for latitude in latitudes) and any(latitude < 41.9 for latitude in latitudes)


def test_a_run_keeps_the_joint_covariance_of_its_landmarks(cli: Cli, tmp_path: Path) -> None:
    (mission,) = season_of(cli, tmp_path, range(3, 4))
    assert cli("run", mission, "--out", tmp_path / "run").code == 0
    names = ("var_xx", "cov_xy", "cov_xz", "var_yy", "cov_yz", "var_zz")
    table = read_table(tmp_path / "run" / "landmarks.csv", required=names, other_columns_allowed=True)
    joint = read_landmark_covariance(tmp_path / "run", table.rows)
    assert joint is not None and np.linalg.eigvalsh(joint)[0] > 0.0
    blocks = np.array([joint[3 * i : 3 * i + 3, 3 * i : 3 * i + 3][np.triu_indices(3)] for i in range(table.rows)])
    np.testing.assert_allclose(blocks, table.stacked(names), rtol=1e-6)
    correlation = joint[0, 3] / np.sqrt(joint[0, 0] * joint[3, 3])
    assert correlation > 0.1  # what a track drifts moves all that it saw


@pytest.mark.long
def test_twenty_seasons_are_merged_right(cli: Cli, tmp_path: Path) -> None:
    total = Score()
    season_nees = []
    for world in range(20):
        seabed = {"world_seed": world}
        missions = season_of(cli, tmp_path / "sea", range(100 * world, 100 * world + 5), seabed)
        season = tmp_path / "season"
        assert cli("batch", *missions, "--out", season, "--no-report").code == 0
        runs = sorted((season / "missions").iterdir())
        found = score(season_map(runs), true_objects(seabed), identities(runs))
        total.right, total.wrong, total.missed = total.right + found.right, total.wrong + found.wrong, total.missed + found.missed
        season_nees.append(float(np.mean(found.nees)))
        shutil.rmtree(tmp_path / "sea")
        shutil.rmtree(season)
    print(f"right {total.right}, wrong {total.wrong}, missed {total.missed}, NEES {np.mean(season_nees):.2f} of 2")
    assert total.wrong <= 0.01 * total.right and total.missed <= 0.10 * total.right
    assert 1.3 < np.mean(season_nees) < 2.7
