"""How many objects on the bottom a survey found, what else it reported, and where it put them."""

from typing import Any

import numpy as np

from ssjs_cli import _core
from ssjs_cli.formats.mission import SurveyedLandmarks
from ssjs_cli.formats.number_table import FloatArray

# A contact farther from every object is a false one, an object without a contact so near is missed.
CONTACT_GATE_M = 5.0


def contact_score(contacts_m: FloatArray, truth: SurveyedLandmarks) -> dict[str, Any]:
    """contacts_m (c, 2) in the frame of the objects. Contacts and objects are paired one to one with the least total distance, so that
    a second contact on one object is false; `contacts_duplicate` says how many of the false ones are such. Fractions: of the objects,
    and of the contacts."""
    objects, contacts = len(truth.ids), len(contacts_m)
    score: dict[str, Any] = {"objects": objects, "contacts": contacts}
    score.update(contacts_found=0, contacts_false=contacts, contacts_duplicate=0)
    if not objects or not contacts:
        return score
    measured = _core.map_error(contacts_m, [None] * contacts, truth.position_m, truth.ids, CONTACT_GATE_M, False)
    if measured is not None:
        alone = np.array([partner is None for partner in measured["truth_of"]])
        distance_m = np.linalg.norm(contacts_m[alone, None, :] - truth.position_m[None, :, :], axis=2)
        score["contacts_found"], score["contacts_false"] = int(measured["matched"]), int(alone.sum())
        score["contacts_duplicate"] = int((distance_m.min(axis=1) <= CONTACT_GATE_M).sum())
        score["contact_position_rms_m"] = float(measured["rmse_m"])
    score["contacts_found_fraction"] = score["contacts_found"] / objects
    score["contacts_false_fraction"] = score["contacts_false"] / contacts
    return score
