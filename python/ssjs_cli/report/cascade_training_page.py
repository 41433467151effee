"""The page of a training: its layers against the plan, its features, and what single features say about the windows."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ssjs_cli.cascade.model_drawing import describe_feature, drawn_out
from ssjs_cli.cascade.windows import Feature, features_of, stages_of
from ssjs_cli.report import figure_style as style
from ssjs_cli.report.cascade_model_page import feature_groups, layer_sheet
from ssjs_cli.report.cascade_page import CardGroup, CascadePage, card, render_cascade
from ssjs_cli.report.figure_style import Figure, Trace
from ssjs_cli.report.number_text import count_text
from ssjs_cli.report.page_parts import Plot
from ssjs_cli.report.study_page import Section

if TYPE_CHECKING:
    from ssjs_cli.cascade.train import Trained

POSITIVE, NEGATIVE = "#d1495b", "#2a6fbb"
#: Of each kind in a plot of responses.
MAX_POINTS = 400
SAMPLE_CARDS = 36
SINGLE_FEATURES = 4
PROPORTIONS = (1, 2, 4, 8)


def training_page(trained: "Trained", document: Mapping[str, Any]) -> str:
    totals = document["totals"]
    facts = [
        ("objects", count_text(totals["objects_trained_on"])),
        ("windows of them", count_text(totals["positives"])),
        ("held back", f"{count_text(totals['objects_held_back'])} objects, {count_text(totals['windows_held_back'])} windows without"),
        ("pictures without objects", count_text(totals["negative_pictures"])),
        ("window", f"{trained.cascade.window[0]} x {trained.cascade.window[1]} px"),
        ("layers", str(totals["layers"])),
        ("features", str(totals["features"])),
        ("seed", str(trained.seed)),
        ("version", str(document["version"])),
    ]
    page = CascadePage(
        "training",
        trained.title,
        facts,
        sheets=[layer_sheet(document["layers"])],
        sections=[Section("rates-section", "Layers", [_rates(document), _features(document)])],
        groups=[*feature_groups(trained.cascade, trained.mean_positive), _sample_group(trained)],
        subtitle=f"Training ended: {document['stopped_because']}.",
        failures=list(trained.failures),
    )
    responses = response_plots(trained)
    if responses:
        page.sections.append(Section("responses", "What single features say", responses))
    return render_cascade(page)


def _rates(document: Mapping[str, Any]) -> Plot:
    layers = document["layers"]
    x = [layer["layer"] for layer in layers]
    traces: list[Trace] = []
    for key, name, colour, dash in (
        ("detection_rate", "detection rate", style.REFERENCE, "solid"),
        ("target_detection_rate", "wanted", style.REFERENCE, "4px,4px"),
        ("false_positive_rate", "false positive rate", style.OUTSIDE, "solid"),
        ("target_false_positive_rate", "wanted", style.OUTSIDE, "4px,4px"),
    ):
        y = [layer[key] if layer[key] > 0 else None for layer in layers]
        hover = f"layer %{{x}}, {name}: %{{y:.4%}}<extra></extra>"
        traces.append({**style.line(x, y, name, colour, 2.0, line={"dash": dash}, hovertemplate=hover), "mode": "lines+markers"})
    figure: Figure = {
        "data": traces,
        "layout": style.layout(
            340, xaxis=style.axis("layer", dtick=1), yaxis=style.axis("rate of windows [-]", type="log", tickformat=".3~%")
        ),
    }
    held_back = document["totals"]["objects_held_back"]
    notes = [
        "Of the whole cascade up to and with the layer,",
        "on recordings held back." if held_back else "on the windows trained on: nothing was held back.",
    ]
    return Plot("rates", "Rates against the plan", figure, notes)


def _features(document: Mapping[str, Any]) -> Plot:
    layers = document["layers"]
    bar: Trace = {
        "type": "bar", "x": [layer["layer"] for layer in layers], "y": [layer["features"] for layer in layers], "name": "features",
        "marker": {"color": style.BAND}, "hovertemplate": "layer %{x}: %{y} features<extra></extra>",
    }  # fmt: skip
    layout = style.layout(240, xaxis=style.axis("layer", dtick=1), yaxis=style.axis("features [count]"), showlegend=False)
    return Plot("features", "Features a layer", {"data": [bar], "layout": layout})


def _sample_group(trained: "Trained") -> CardGroup:
    positives = trained.samples.positives
    chosen = np.linspace(0, len(positives) - 1, min(SAMPLE_CARDS, len(positives))).astype(int)
    cards = []
    for index in dict.fromkeys(chosen.tolist()):
        picture = np.repeat(np.repeat(drawn_out(positives[index]), 4, axis=0), 4, axis=1)
        cards.append(card(np.repeat(picture[:, :, np.newaxis], 3, axis=2), f"window {index + 1}"))
    return CardGroup("samples", "Windows trained on", cards, f"{len(cards)} of {len(positives):,}, evenly chosen, copies among them.", 90)


def response_plots(trained: "Trained") -> list[Plot]:
    """The model's first features, and two regions side by side in several proportions, on objects and on windows without."""
    positives, negatives = trained.samples.positives, trained.samples.validation_negatives
    if len(negatives) == 0:
        return []
    features = features_of(trained.cascade)
    chosen = [weak.nodes[0] for stage in stages_of(trained.cascade) for weak in stage.weak][:SINGLE_FEATURES]
    plots = []
    for place, (number, threshold, _, _) in enumerate(chosen, 1):
        feature = features[number]
        heading = f"Feature {place} of the model: {describe_feature(feature)}"
        plots.append(response_plot(f"response-{place}", heading, feature, positives, negatives, threshold))
    for dark in PROPORTIONS:
        proportion = side_by_side(dark, *trained.cascade.window)
        if proportion is not None:
            plots.append(
                response_plot(f"proportion-{dark}", f"{dark} dark to 1 bright, over the whole window", proportion, positives, negatives)
            )
    return plots


def side_by_side(dark: int, width_px: int, height_px: int) -> Feature | None:
    """Bright on the left, the shadow to the right of it, as wide as the window allows."""
    bright = width_px // (dark + 1)
    if bright < 1:
        return None
    left, top, height = (width_px - bright * (dark + 1)) // 2, height_px // 4, max(1, height_px // 2)
    return Feature(False, [(left, top, bright * (dark + 1), height, -1.0), (left, top, bright, height, dark + 1.0)])


def response_plot(
    div_id: str,
    heading: str,
    feature: Feature,
    positives: NDArray[np.uint8],
    negatives: NDArray[np.uint8],
    threshold: float | None = None,
) -> Plot:
    traces: list[Trace] = []
    for windows, name, colour in ((negatives, "without object", NEGATIVE), (positives, "object", POSITIVE)):
        chosen = windows[np.linspace(0, len(windows) - 1, min(MAX_POINTS, len(windows))).astype(int)]
        values = feature.values(chosen)
        trace: Trace = {
            "type": "scatter", "mode": "markers", "name": name, "x": list(range(len(values))), "y": style.listed(values, 5),
            "marker": {"color": colour, "size": 4, "opacity": 0.65}, "hovertemplate": f"{name} %{{x}}: %{{y:.4f}}<extra></extra>",
        }  # fmt: skip
        traces.append(trace)
    separation = _separation(feature, positives, negatives)
    notes = [f"A threshold alone tells them apart in {separation:.1%} of cases, objects and windows without counting equally."]
    if threshold is not None:
        ends: list[float | None] = [0.0, float(MAX_POINTS)]
        traces.append(style.line(ends, [threshold, threshold], "threshold of the model", style.INK, 1.5, line={"dash": "4px,4px"}))
    layout = style.layout(280, xaxis=style.axis("window"), yaxis=style.axis("value of the feature [-]"))
    return Plot(div_id, heading, {"data": traces, "layout": layout}, notes)


def _separation(feature: Feature, positives: NDArray[np.uint8], negatives: NDArray[np.uint8]) -> float:
    """The best mean of both kinds' rates over all thresholds and both directions."""
    of_objects = np.sort(feature.values(positives))
    of_others = np.sort(feature.values(negatives))
    cuts = np.concatenate([of_objects, of_others])
    below = np.searchsorted(of_objects, cuts, side="right") / len(of_objects) - np.searchsorted(of_others, cuts, side="right") / len(
        of_others
    )
    return 0.5 + 0.5 * float(np.abs(below).max())
