"""The built-in survey of an underwater vehicle, as a mission with truth."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ssjs_cli import _core
from ssjs_cli.config import UNDERWATER, layer_from_tables
from ssjs_cli.formats.mission import BodyPoints, Mission, Reference, ReferenceDescription, SurveyedLandmarks
from ssjs_cli.formats.navigation import Attitude, BottomVelocity, Scalars, UnderwaterNavigation
from ssjs_cli.formats.tum import PoseSeries

AUV_SURVEY = "auv-survey"


def simulate_auv_survey(name: str, description: str, settings: Mapping[str, Any], seed: int) -> Mission:
    """Five lines, three cross lines, sixty objects, with the sensors that the filter's defaults describe."""
    layer_from_tables(settings, f"scenario {name}", UNDERWATER)
    survey = _core.simulate_auv_survey(seed)
    attitude, velocity, points, truth = (survey[key] for key in ("attitude", "velocity", "sightings", "truth"))
    return Mission(
        name=name,
        description=description or f"simulated: {AUV_SURVEY}, seed {seed}",
        notes="North-east-down; the first line heads north from the origin.",
        navigation=UnderwaterNavigation(
            Attitude(attitude[:, 0], attitude[:, 1:4], survey["gyro"][:, 1:4]),
            BottomVelocity(velocity[:, 0], velocity[:, 1:4], velocity[:, 4] == 1.0),
            Scalars(*np.ascontiguousarray(survey["depth"].T)),
            Scalars(*np.ascontiguousarray(survey["altitude"].T)),
        ),
        points=BodyPoints(points[:, 0], points[:, 1:4], np.asarray(survey["sighting_ids"])) if len(points) else None,
        settings=dict(settings),
        # The estimate starts at the true pose, which defines the frame: nothing to align.
        reference=Reference(
            ReferenceDescription(alignment="none"),
            truth=PoseSeries(truth[:, 0], truth[:, [1, 2, 6]], truth[:, [3, 4, 5]]),
            landmarks=SurveyedLandmarks(np.asarray(survey["landmark_ids"]), survey["landmarks"][:, :2]),
        ),
    )
