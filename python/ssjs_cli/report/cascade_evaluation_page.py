"""The page of an evaluation: layers, FROC, precision and recall, and the best and worst detections as pictures."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ssjs_cli.cascade.box_pictures import FALSE, FOUND, TRUTH, DrawnBox, cut_out
from ssjs_cli.formats.image_file import read_image
from ssjs_cli.report import figure_style as style
from ssjs_cli.report.cascade_page import Card, CardGroup, CascadePage, card, render_cascade
from ssjs_cli.report.figure_style import Figure, Trace
from ssjs_cli.report.number_text import count_text
from ssjs_cli.report.page_parts import Plot
from ssjs_cli.report.sheet import sheet
from ssjs_cli.report.study_page import Section

if TYPE_CHECKING:
    from ssjs_cli.cascade.evaluate import Evaluated

CARDS = 24
MAX_POINTS = 1000
LAYER_SHEET = (
    ("layer", "layer", 0, 1.0),
    ("features", "features", 0, 1.0),
    ("detection_rate", "detection rate [%]", 2, 100.0),
    ("detection_rate_low", "95 % from", 2, 100.0),
    ("detection_rate_high", "to", 2, 100.0),
    ("false_positive_rate", "false positives [%]", 4, 100.0),
    ("false_positive_rate_low", "95 % from", 4, 100.0),
    ("false_positive_rate_high", "to", 4, 100.0),
)


def evaluation_page(evaluated: "Evaluated", document: Mapping[str, Any]) -> str:
    totals, rates = document["totals"], document["rates"]
    low, high = rates["detection_rate_band"]
    facts = [
        ("model", str(document["model"])),
        ("images", count_text(totals["images"])),
        ("objects", count_text(totals["objects"])),
        ("found", f"{count_text(totals['found'])} ({rates['detection_rate']:.1%}; 95 %: {low:.1%} to {high:.1%})"),
        ("false boxes", f"{count_text(totals['false_boxes'])} ({rates['false_boxes_per_image']:.2f} an image)"),
        ("at one false box an image", f"{rates['detection_rate_at_one_false_box']:.1%}"),
        ("average precision", f"{rates['average_precision']:.3f}"),
    ]
    windows = document["layers"][0]["windows"] if document["layers"] else 0
    note = (
        "Of the whole cascade up to and with the layer: on the windows of the labelled boxes, and on "
        f"{count_text(windows)} windows at random places that touch no object. Intervals after Wilson."
    )
    return render_cascade(
        CascadePage(
            "evaluation",
            evaluated.title,
            facts,
            sheets=[sheet("layers", "Layers", LAYER_SHEET, evaluated.layers, note=note)],
            sections=[Section("curves", "Curves", [_froc(evaluated), _precision_recall(evaluated)])],
            groups=_pictures(evaluated),
            failures=list(evaluated.failures),
        )
    )


def _thinned(count: int) -> list[int]:
    return list(dict.fromkeys(np.linspace(0, count - 1, min(count, MAX_POINTS)).astype(int).tolist())) if count else []


def _froc(evaluated: "Evaluated") -> Plot:
    made = evaluated.curve
    plot = Plot("froc", "FROC: objects found against false boxes")
    chosen = _thinned(len(made.thresholds))
    if not chosen:
        plot.missing = "Nothing was detected, so there is no curve."
        return plot
    traces: list[Trace] = []
    if evaluated.band is not None:
        grid, low, high = evaluated.band
        traces.append(style.band(style.listed(grid, 6), style.listed(low, 6), style.listed(high, 6), "95 % band"))
        plot.notes.append("Band: recordings drawn again and again.")
    else:
        plot.notes.append("No band: all images count as one recording.")
    x, y = [0.0, *style.listed(made.false_per_image[chosen], 6)], [0.0, *style.listed(made.detection_rate[chosen], 6)]
    scores = [None, *style.listed(made.thresholds[chosen], 4)]  # above every score nothing is found
    hover = "score %{customdata:.3f}: %{y:.1%} at %{x:.3f} false boxes an image<extra></extra>"
    traces.append(
        {
            **style.line(x, y, "detections", style.FINAL, 2.0, customdata=scores, hovertemplate=hover),
            "mode": "lines+markers",
            "marker": {"size": 4},
        }
    )
    plot.figure = {
        "data": traces,
        "layout": style.layout(
            360,
            xaxis=style.axis("false boxes an image [count]", rangemode="tozero"),
            yaxis=style.axis("objects found [-]", range=[0, 1.02], tickformat=".0%"),
        ),
    }
    return plot


def _precision_recall(evaluated: "Evaluated") -> Plot:
    made = evaluated.curve
    plot = Plot("precision-recall", "Precision and recall")
    chosen = _thinned(len(made.thresholds))
    if not chosen:
        plot.missing = "Nothing was detected, so there is no curve."
        return plot
    x, y = style.listed(made.detection_rate[chosen], 6), style.listed(made.precision[chosen], 6)
    hover = "recall %{x:.1%}, precision %{y:.1%}<extra></extra>"
    figure: Figure = {
        "data": [{**style.line(x, y, "precision", style.BAND, 2.0, hovertemplate=hover), "mode": "lines+markers", "marker": {"size": 4}}],
        "layout": style.layout(
            320,
            xaxis=style.axis("recall [-]", range=[0, 1.02], tickformat=".0%"),
            yaxis=style.axis("precision [-]", range=[0, 1.02], tickformat=".0%"),
            showlegend=False,
        ),
    }
    plot.figure = figure
    return plot


def _pictures(evaluated: "Evaluated") -> list[CardGroup]:
    """Found with the best scores, false with the best scores, and objects missed."""
    found: list[tuple[float, int, int]] = []
    false: list[tuple[float, int, int]] = []
    missed: list[tuple[int, int]] = []
    for image, matched in enumerate(evaluated.matches):
        for position, detection in enumerate(matched.detections):
            (false if matched.found[position] is None else found).append((detection.score, image, position))
        missed += [(image, index) for index in matched.missed()]
    best = sorted(found, key=lambda entry: (-entry[0], entry[1:]))
    worst = sorted(false, key=lambda entry: (-entry[0], entry[1:]))
    legend = "Green: labelled; blue: detected and right; red: detected and false."
    return [
        CardGroup("best", "Best detections", [_card(evaluated, image, position) for _, image, position in best[:CARDS]], legend, 200),
        CardGroup(
            "worst",
            "False boxes with the best scores",
            [_card(evaluated, image, position) for _, image, position in worst[:CARDS]],
            legend,
            200,
        ),
        CardGroup(
            "missed",
            "Objects missed",
            [_missed_card(evaluated, image, index) for image, index in missed[:CARDS]],
            f"{min(len(missed), CARDS)} of {len(missed)}. {legend}",
            200,
        ),
    ]


def _drawn(evaluated: "Evaluated", image: int) -> list[DrawnBox]:
    matched = evaluated.matches[image]
    boxes = [DrawnBox(box, TRUTH) for box in matched.objects]
    for detection, index in zip(matched.detections, matched.found, strict=True):
        boxes.append(DrawnBox(detection.box, FALSE if index is None else FOUND))
    return boxes


def _card(evaluated: "Evaluated", image: int, position: int) -> Card:
    detection = evaluated.matches[image].detections[position]
    listed = evaluated.labelled.images[image].listed
    pixels = cut_out(read_image(listed.path), detection.box, _drawn(evaluated, image))
    return card(pixels, listed.name, f"score {detection.score:.3f}")


def _missed_card(evaluated: "Evaluated", image: int, index: int) -> Card:
    box = evaluated.matches[image].objects[index]
    listed = evaluated.labelled.images[image].listed
    return card(cut_out(read_image(listed.path), box, _drawn(evaluated, image)), listed.name, f"{box[2]} x {box[3]} px")
