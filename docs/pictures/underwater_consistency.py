"""The picture of docs/underwater_methods.md: error with its three standard deviations over time, with small submaps and with one map for
the whole mission, and the share of the mission inside them against the length of a submap.

PYTHONPATH=python python docs/pictures/underwater_consistency.py WEAK/sweep.json SURVEY/sweep.json

The sweeps are those of `ssjs-cli sweep` that the page names, of auv-survey-weak-heading and of auv-survey.
"""

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from playwright.sync_api import sync_playwright
from plotly.subplots import make_subplots

SEED = 2
RUNS = ((25, "submaps of 25 m"), (1500, "one map for the whole mission"))
WIDTH, HEIGHT = 1150, 480
INK, BAND, WEAK, SURVEY = "#1f2937", "#cbd5e1", "#c2410c", "#1d4ed8"


def ssjs(*arguments: str) -> None:
    subprocess.run([sys.executable, "-m", "ssjs_cli", *arguments], check=True, stdout=subprocess.DEVNULL)


def errors(mission: Path, length_m: int) -> NDArray[Any]:
    out = mission.parent / f"run-{length_m}"
    limits = [
        f"split.max_distance_m={length_m}",
        f"split.longest_m={2 * length_m}",
        "split.max_landmarks=none",
        "split.max_sigma_xy_m=none",
    ]
    flags = [argument for limit in limits for argument in ("--set", limit)]
    ssjs("run", str(mission), "--out", str(out), "--association", "known", "--no-report", *flags)
    return np.genfromtxt(out / "errors.csv", delimiter=",", names=True)


def draw_errors(figure: Any, run: NDArray[Any], column: int) -> None:
    for row, axis in ((1, "x"), (2, "y")):
        time_s, sigma_m = run["time_s"], 3.0 * run[f"sigma_{axis}_m"]
        shown = {"row": row, "col": column}
        outline = {"x": np.concatenate([time_s, time_s[::-1]]), "y": np.concatenate([sigma_m, -sigma_m[::-1]])}
        figure.add_scatter(**outline, fill="toself", fillcolor=BAND, line_width=0, showlegend=False, **shown)
        figure.add_scatter(x=time_s, y=run[f"error_{axis}_m"], line={"color": INK, "width": 1.3}, showlegend=False, **shown)
        figure.update_yaxes(title_text=f"error in {axis} [m]" if column == 1 else None, range=[-40, 40], **shown)
        figure.update_xaxes(title_text="time [s]" if row == 2 else None, **shown)


def draw_shares(figure: Any, sweep: dict[str, Any], name: str, colour: str) -> None:
    cells = [cell for cell in sweep["cells"] if cell["method"] == "ssjs"]
    shares = [100.0 * cell["inside_3_sigma_fraction"] for cell in cells]
    line = {"name": name, "mode": "lines+markers", "line": {"color": colour, "width": 2}, "row": 1, "col": 3}
    figure.add_scatter(x=[cell["submap_size"] for cell in cells], y=shares, **line)


def main() -> None:
    weak, survey = (json.loads(Path(name).read_text()) for name in sys.argv[1:3])
    titles = (*(title for _, title in RUNS), "mission within 3 standard deviations [%]")
    figure = make_subplots(
        rows=2, cols=3, specs=[[{}, {}, {"rowspan": 2}], [{}, {}, None]], subplot_titles=(*titles, "", ""),
        column_widths=[0.34, 0.34, 0.32],
        horizontal_spacing=0.06, vertical_spacing=0.08,
    )  # fmt: skip
    with tempfile.TemporaryDirectory() as scratch:
        mission = Path(scratch) / "mission"
        ssjs("simulate", weak["scenario"], "--seed", str(SEED), "--out", str(mission))
        for column, (length_m, _) in enumerate(RUNS, start=1):
            draw_errors(figure, errors(mission, length_m), column)
        draw_shares(figure, survey, survey["scenario"], SURVEY)
        draw_shares(figure, weak, weak["scenario"], WEAK)
        figure.update_xaxes(type="log", title_text="length of a submap [m]", tickvals=[15, 25, 50, 100, 200, 400, 1500], row=1, col=3)
        figure.update_yaxes(range=[0, 103], row=1, col=3)
        figure.add_hline(95, line={"color": INK, "width": 1, "dash": "dot"}, row=1, col=3)
        figure.update_annotations(font_size=13)
        figure.update_layout(
            template="plotly_white", width=WIDTH, height=HEIGHT, margin={"l": 60, "r": 20, "t": 40, "b": 50}, legend={"x": 0.74, "y": 0.12}
        )
        page = Path(scratch) / "page.html"
        figure.write_html(page)
        with sync_playwright() as browsers:
            browser = browsers.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
            tab = browser.new_page(viewport={"width": WIDTH + 20, "height": HEIGHT + 20})
            tab.goto(page.as_uri(), timeout=180_000)
            tab.locator(".js-plotly-plot").screenshot(path=str(Path(__file__).parent / "underwater_consistency.png"))
            browser.close()


if __name__ == "__main__":
    main()
