"""The page of `cascade show`, and the pictures of features that the training's page shares."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssjs_cli import _core
from ssjs_cli.cascade.model_drawing import describe_feature, drawn_out, feature_picture
from ssjs_cli.cascade.model_file import Model
from ssjs_cli.cascade.windows import features_of, stages_of
from ssjs_cli.report.cascade_page import CardGroup, CascadePage, card, render_cascade
from ssjs_cli.report.sheet import Sheet, sheet

#: More features stay in the model's file.
MAX_CARDS = 240
LAYER_SHEET = (
    ("layer", "layer", 0, 1.0),
    ("features", "features", 0, 1.0),
    ("threshold", "threshold", 4, 1.0),
    ("detection_rate", "detection rate [%]", 3, 100.0),
    ("target_detection_rate", "wanted [%]", 1, 100.0),
    ("false_positive_rate", "false positives [%]", 4, 100.0),
    ("target_false_positive_rate", "wanted [%]", 2, 100.0),
    ("negatives", "negatives", 0, 1.0),
    ("negatives_looked_at", "windows looked at", 0, 1.0),
)


def layer_sheet(layers: Sequence[dict[str, Any]]) -> Sheet:
    note = "Rates are those of the whole cascade up to and with the layer." if any("detection_rate" in layer for layer in layers) else ""
    return sheet("layers", "Layers", LAYER_SHEET, layers, note=note)


def feature_groups(cascade: _core.HaarCascade, mean: NDArray[np.uint8] | None) -> list[CardGroup]:
    groups = []
    left = MAX_CARDS
    size = cascade.window
    features = features_of(cascade)
    for layer, stage in enumerate(stages_of(cascade), 1):
        cards = []
        for weak in stage.weak[:left]:
            for number, threshold, _, _ in weak.nodes:
                votes = (
                    f"below {weak.leaves[0]:+.2f}, else {weak.leaves[1]:+.2f}"
                    if len(weak.nodes) == 1
                    else f"tree of {len(weak.nodes)} nodes"
                )
                picture = feature_picture(features[number], mean, size)
                cards.append(card(picture, describe_feature(features[number]), f"threshold {threshold:.4g}", votes))
        left -= len(cards)
        shown = f", {len(cards)} of {len(stage.weak)} shown" if len(cards) < len(stage.weak) else ""
        note = f"{len(stage.weak)} feature{'' if len(stage.weak) == 1 else 's'}{shown}; passes from {stage.threshold:.4f}"
        groups.append(CardGroup(f"layer-{layer}", f"Layer {layer}", cards, note))
        if left <= 0:
            break
    return groups


def model_page(model: Model, layers: Sequence[dict[str, Any]], mean: NDArray[np.uint8] | None) -> str:
    cascade = model.cascade
    provenance = cascade.provenance()
    facts = [
        ("window", f"{cascade.window[0]} x {cascade.window[1]} px"),
        ("layers", str(len(layers))),
        ("features", str(sum(layer["features"] for layer in layers))),
        ("by", provenance["trained_with"] or "another program"),
    ]
    if cascade.contours_known:
        facts.append(("contours known", str(cascade.contours_known)))
    if provenance["stopped_because"]:
        facts.append(("training ended", provenance["stopped_because"]))
    settings = [{"setting": key, "value": value} for key, value in provenance["settings"].items()]
    sheets = [
        layer_sheet(layers),
        sheet("settings", "Trained with", (("setting", "setting", None, 1.0), ("value", "value", None, 1.0)), settings),
    ]
    groups = feature_groups(cascade, mean)
    if mean is not None:
        picture = np.repeat(np.repeat(drawn_out(mean), 8, axis=0), 8, axis=1)
        groups.insert(
            0, CardGroup("mean", "Mean object", [card(np.repeat(picture[:, :, np.newaxis], 3, axis=2), "mean of the windows trained on")])
        )
    legend = "Where a feature adds levels is yellow, where it subtracts them is blue."
    return render_cascade(CascadePage("model", model.path.name, facts, sheets, [], groups, subtitle=legend))
