"""The settings of a mission of frames alone: those of the estimator in the plane, of frames and their matches, of the motion between them
and of the mosaic."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import chain
from types import MappingProxyType
from typing import Any

from ssjs_cli import _core
from ssjs_cli.config import ESTIMATOR, FieldDescription, Scalar, SettingsKind, described_by_core, field_descriptions
from ssjs_cli.errors import UserError

#: What is usual where the only sensor is a camera; lengths are metres, or widths of a frame where the size of a pixel is not known.
DEFAULTS: Mapping[str, Scalar] = MappingProxyType(
    {
        "vehicle.kind": "increments",
        "association.method": "known",
        "submap.max_landmarks": 60,
        "submap.max_sigma_xy_m": None,
        "joining.fusion_threshold": 0.02,
        "joining.min_pairs": 4,
        "joining.max_fused_landmarks": 5000,
        "joining.max_pairing_sigma_m": None,
        "frames.places": "frame",
        "frames.keypoints.max_keypoints": 1000,
        "frames.keypoints.surf_threshold": 3.0,
        "frames.keypoints.surf_zoom": 1.5,
        "matching.tolerance_px": 6.0,
    }
)


def _fields() -> Iterator[FieldDescription]:
    parts = (_core.frame_fields(), _core.visual_odometry_fields(), _core.mosaic_fields())
    for described in chain(field_descriptions(ESTIMATOR).values(), *(described_by_core(part) for part in parts)):
        yield replace(described, default=DEFAULTS.get(described.key, described.default))


def _violations(values: Mapping[str, Scalar]) -> list[str]:
    estimator = {key: value for key, value in values.items() if key in field_descriptions(ESTIMATOR)}
    settings = FrameSettings(values)
    found = list(_core.validate_config(estimator))
    found += _core.validate_frames(settings.of_frames) + _core.validate_visual_odometry(settings.of_motion)
    return found + _core.validate_mosaic(settings.of_mosaic)


FRAMES_ALONE = SettingsKind("FrameSettings", "frames.metres_per_px=0.004", _fields, _violations)


@dataclass(frozen=True)
class FrameSettings:
    """The settings of a run, by who reads them."""

    values: Mapping[str, Scalar]

    def _known(self, fields: list[dict[str, Any]]) -> dict[str, Scalar]:
        return {entry["key"]: self.values[entry["key"]] for entry in fields if entry["key"] in self.values}

    @property
    def of_estimator(self) -> dict[str, Scalar]:
        return {key: value for key, value in self.values.items() if key in field_descriptions(ESTIMATOR)}

    @property
    def of_frames(self) -> dict[str, Scalar]:
        return self._known(_core.frame_fields())

    @property
    def of_motion(self) -> dict[str, Scalar]:
        return self._known(_core.visual_odometry_fields())

    @property
    def of_mosaic(self) -> dict[str, Scalar]:
        return self._known(_core.mosaic_fields())

    def own(self, name: str) -> Any:
        return self.values[f"frames.{name}"]

    @property
    def length_unit(self) -> str:
        return "m" if self.own("metres_per_px") is not None else "frame widths"

    def reader(self, calibration: Mapping[str, Any] | None) -> Any:
        try:
            return _core.FrameReader(self.of_frames, calibration)
        except ValueError as error:
            raise UserError(f"frames: {error}") from error
