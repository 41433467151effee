"""The command `cascade show`: one page about a model, and its table on the terminal."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssjs_cli.cascade.model_file import MEAN_FILE, Model, load_model
from ssjs_cli.cascade.windows import stages_of
from ssjs_cli.errors import UserError
from ssjs_cli.exit_codes import DONE
from ssjs_cli.formats.atomic import write_file
from ssjs_cli.formats.image_file import read_image
from ssjs_cli.session import Session
from ssjs_cli.studies.tables import terminal_table

COLUMNS = (
    ("layer", "layer", "d"),
    ("features", "features", "d"),
    ("threshold", "threshold", ".4f"),
    ("detection_rate", "detection rate", ".3%"),
    ("false_positive_rate", "false positives", ".4%"),
    ("negatives", "negatives", "d"),
)


def show_model(path: Path, out: Path | None, session: Session, *, force: bool) -> int:
    from ssjs_cli.report.cascade_model_page import model_page

    model = load_model(path)
    target = out or Path("runs") / f"{model.path.stem if model.path.parent == Path('.') else model.path.parent.name}-shown.html"
    if target.exists() and not force:
        raise UserError(f"{target}: exists already; choose another --out, or replace it with --force")
    layers = layer_rows(model)
    cascade = model.cascade
    provenance = cascade.provenance()
    target.parent.mkdir(parents=True, exist_ok=True)
    write_file(target, model_page(model, layers, mean_positive(model)))
    document = {
        "model": model.path.name,
        "model_sha256": model.digest,
        "window_px": list(cascade.window),
        "trained_with": provenance["trained_with"] or None,
        "stopped_because": provenance["stopped_because"] or None,
        "settings": provenance["settings"],
        "features": len(cascade.features()),
        "contours": cascade.contours_known,
        "layers": layers,
        "page": str(target),
    }
    origin = provenance["trained_with"] or "another program"
    size = f"{cascade.window[0]} x {cascade.window[1]} px"
    text = f"{model.path.name}: {size}, {len(layers)} layers, {len(cascade.features())} features, by {origin}"
    session.answer(document, f"{text}\n{terminal_table('Layers', COLUMNS, layers)}\npage     {target}")
    return DONE


def layer_rows(model: Model) -> list[dict[str, Any]]:
    """What the model says about its layers; rates only where its training has left them."""
    records = model.cascade.provenance()["layers"]
    rows = []
    for position, stage in enumerate(stages_of(model.cascade)):
        record = records[position] if position < len(records) else {}
        rows.append({"layer": position + 1, "features": len(stage.weak), "threshold": stage.threshold, **record})
        rows[-1]["features"] = len(stage.weak)
    return rows


def mean_positive(model: Model) -> NDArray[np.uint8] | None:
    """The picture that the training has left beside the model; None where there is none of this model."""
    path = model.path.parent / MEAN_FILE
    if not path.is_file():
        return None
    try:
        levels = read_image(path).levels
    except UserError:
        return None
    return levels.astype(np.uint8) if levels.shape == model.cascade.window[::-1] and levels.dtype == np.uint8 else None
