"""One fusion before and after, drawn into docs/pictures/one_fusion.png.

    .venv/bin/python docs/pictures/one_fusion.py [--seed 3]

Simulates the grid survey, finds the loop closure whose two maps were least sure of each other, and estimates the mission twice more: up to
the start of the submap that closes the loop, and up to its end. Needs what `make test` installs (chromium for the picture).
"""

import argparse
import json
import math
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray
from playwright.sync_api import sync_playwright
from plotly.subplots import make_subplots

from ssjs_cli.report.planar_shapes import ellipse_outlines

MARGIN_M = 6.0
SUBMAP_COLOURS = ("#1f77b4", "#d62728")


def ssjs(*arguments: str) -> None:
    subprocess.run([sys.executable, "-m", "ssjs_cli", *arguments, "--force"], check=True, stdout=subprocess.DEVNULL)


def cut_mission(mission: Path, end_s: float, out: Path) -> Path:
    """The mission up to end_s."""
    shutil.copytree(mission, out)
    for name in ("odometry.csv", "observations.csv", "truth_trajectory.tum"):
        lines = (out / name).read_text().splitlines(keepends=True)
        header = 1 if name.endswith(".csv") else 0
        kept = [line for line in lines[header:] if float(line.replace(",", " ").split()[0]) <= end_s]
        (out / name).write_text("".join(lines[:header] + kept))
    return out


def run(mission: Path, out: Path) -> Path:
    ssjs("run", str(mission), "--association", "known", "--out", str(out))
    return out


def landmarks(run_dir: Path) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
    """Positions (n, 2) m, covariances (n, 3) xx xy yy, live maps (n,), identities (n,), which are those of the truth here."""
    table = np.genfromtxt(run_dir / "landmarks.csv", delimiter=",", names=True)
    return (
        np.column_stack((table["x_m"], table["y_m"])),
        np.column_stack((table["var_xx"], table["cov_xy"], table["var_yy"])),
        table["submap"].astype(np.int64),
        table["id"].astype(np.int64),
    )


def draw(figure: go.Figure, column: int, run_dir: Path, truth: NDArray[np.float64], shown: dict[int, str]) -> None:
    """One panel: truth, track, every landmark with its 95 % ellipse; the maps in `shown` (live map: colour) stand out."""
    position, covariance, live_map, _ = landmarks(run_dir)
    track = np.loadtxt(run_dir / "trajectory.tum")[::40, 1:3]
    first = column == 1
    figure.add_scatter(x=truth[:, 0], y=truth[:, 1], mode="markers", name="true landmarks", showlegend=first, row=1, col=column,
                       marker={"symbol": "cross-thin", "size": 9, "line": {"width": 1.5, "color": "black"}})  # fmt: skip
    figure.add_scatter(x=track[:, 0], y=track[:, 1], mode="lines", name="track", showlegend=first, row=1, col=column,
                       line={"color": "#b0b0b0", "width": 1})  # fmt: skip
    for colour in ("#999999", *dict.fromkeys(shown.values())):
        chosen = np.array([shown.get(int(m), "#999999") == colour for m in live_map])
        outline = ellipse_outlines(position[chosen], covariance[chosen], 36)
        joined = np.concatenate((outline, np.full((len(outline), 1, 2), np.nan)), axis=1).reshape(-1, 2)
        figure.add_scatter(
            x=joined[:, 0], y=joined[:, 1], mode="lines", line={"color": colour, "width": 1.5}, showlegend=False, row=1, col=column
        )
        figure.add_scatter(x=position[chosen, 0], y=position[chosen, 1], mode="markers", marker={"color": colour, "size": 5},
                           showlegend=False, row=1, col=column)  # fmt: skip


def live_map_of(run_dir: Path, submap: int) -> int:
    return int(json.loads((run_dir / "submaps.json").read_text())["submaps"][submap]["live_map"])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--seed", type=int, default=3)
    seed = parser.parse_args().seed
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        ssjs("simulate", "grid-survey", "--seed", str(seed), "--out", str(work / "mission"))
        books = json.loads((run(work / "mission", work / "whole") / "submaps.json").read_text())
        loop = max((loop for loop in books["loops"] if loop["accepted"]), key=lambda loop: loop["sigma_m"])
        old, new = loop["to"], loop["from"]
        start_s, end_s = (books["submaps"][new][key] for key in ("start_time_s", "end_time_s"))
        before = run(cut_mission(work / "mission", end_s=start_s, out=work / "to_start"), work / "before")
        after = run(cut_mission(work / "mission", end_s=end_s, out=work / "to_end"), work / "after")
        truth = np.genfromtxt(work / "mission" / "truth_landmarks.csv", delimiter=",", names=True)
        truth_m = np.column_stack((truth["x_m"], truth["y_m"]))

        last = len(json.loads((before / "submaps.json").read_text())["submaps"]) - 1
        one, other = live_map_of(before, old), live_map_of(before, last)
        titles = (f"before submap {new} closes ({start_s:.1f} s)", f"after it was fused with that of submap {old} ({end_s:.1f} s)")
        figure = make_subplots(rows=1, cols=2, shared_xaxes=True, shared_yaxes=True, horizontal_spacing=0.03, subplot_titles=titles)
        draw(figure, 1, before, truth_m, {one: SUBMAP_COLOURS[0], other: SUBMAP_COLOURS[1]})
        draw(figure, 2, after, truth_m, {live_map_of(after, new): "#7b3fa0"})
        position, _, live_map, _ = landmarks(after)
        centre = position[live_map == live_map_of(after, new)]
        low, high = centre.min(axis=0) - MARGIN_M, centre.max(axis=0) + MARGIN_M
        figure.update_xaxes(range=[low[0], high[0]], title_text="x (m)")
        figure.update_yaxes(range=[low[1], high[1]], scaleanchor="x")
        figure.update_yaxes(title_text="y (m)", row=1, col=1)
        width = 1300
        height = int(width / 2 * (high[1] - low[1]) / (high[0] - low[0])) + 140
        figure.update_layout(
            template="plotly_white", width=width, height=height, legend={"orientation": "h"}, margin={"l": 50, "r": 20, "t": 40, "b": 40}
        )
        page = work / "page.html"
        figure.write_html(page)
        with sync_playwright() as browsers:
            browser = browsers.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
            tab = browser.new_page(viewport={"width": width + 20, "height": height + 20})
            tab.goto(page.as_uri())
            tab.locator(".js-plotly-plot").screenshot(path=str(Path(__file__).parent / "one_fusion.png"))
            browser.close()

        for name, run_dir in (("before", before), ("after", after)):
            position, covariance, _, identity = landmarks(run_dir)
            near = np.all((position > low) & (position < high), axis=1)
            error = position[near] - truth_m[identity[near]]
            sigma = np.sqrt((covariance[near, 0] + covariance[near, 2]) / 2.0)
            rms = math.sqrt(np.mean(np.sum(error**2, axis=1)))
            print(f"{name}: {near.sum()} landmarks in the picture, RMS error {rms:.2f} m, mean sigma {sigma.mean():.2f} m")
        print(f"ambiguity before: {loop['sigma_m']:.2f} m; {loop['pairs']} pairs")
        print(f"chi-squared {loop['chi2']:.1f} with {loop['dof']} degrees of freedom")


if __name__ == "__main__":
    main()
