"""The JSON schemas of the messages. A viewer knows what to draw by the names `foxglove.*`, whose fields are those of
https://docs.foxglove.dev/docs/sdk/schemas; what has no such name is plain numbers for its plots, under `ssjs.*`."""

import json
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from ssjs_cli.formats.contact_table import COLUMNS

Schema = dict[str, Any]

NUMBER: Schema = {"type": "number"}
WHOLE_NUMBER: Schema = {"type": "integer"}
TEXT: Schema = {"type": "string"}
FLAG: Schema = {"type": "boolean"}
BYTES: Schema = {"type": "string", "contentEncoding": "base64"}

LOG_LEVELS = MappingProxyType({"INFO": 2, "WARNING": 3})
LINE_STRIP, LINE_LIST = 0, 2
COVARIANCE_KNOWN = 3
CONTACT_WHOLE_NUMBERS = ("id", "epsg", "ping", "sightings")


def message(title: str, fields: Mapping[str, Schema], *, optional: tuple[str, ...] = ()) -> Schema:
    required = [name for name in fields if name not in optional]
    return {"title": title, "type": "object", "properties": dict(fields), "required": required}


def list_of(items: Schema) -> Schema:
    return {"type": "array", "items": items}


def choice(title: str, **values: int) -> Schema:
    return {"title": title, "oneOf": [{"title": name, "const": value} for name, value in values.items()]}


_NANOSECONDS: Schema = {"type": "integer", "minimum": 0, "maximum": 999_999_999}
TIME: Schema = {"type": "object", "title": "time", "properties": {"sec": {"type": "integer", "minimum": 0}, "nsec": _NANOSECONDS}}
DURATION: Schema = {"type": "object", "title": "duration", "properties": {"sec": WHOLE_NUMBER, "nsec": _NANOSECONDS}}
VECTOR = message("foxglove.Vector3", dict.fromkeys("xyz", NUMBER))
POINT = message("foxglove.Point3", dict.fromkeys("xyz", NUMBER))
QUATERNION = message("foxglove.Quaternion", dict.fromkeys("xyzw", NUMBER))
COLOUR = message("foxglove.Color", dict.fromkeys("rgba", NUMBER))
POSE = message("foxglove.Pose", {"position": VECTOR, "orientation": QUATERNION})
KEY_VALUE = message("foxglove.KeyValuePair", {"key": TEXT, "value": TEXT})

POSE_IN_FRAME = message("foxglove.PoseInFrame", {"timestamp": TIME, "frame_id": TEXT, "pose": POSE})
FRAME_TRANSFORM = message(
    "foxglove.FrameTransform",
    {"timestamp": TIME, "parent_frame_id": TEXT, "child_frame_id": TEXT, "translation": VECTOR, "rotation": QUATERNION},
)
FRAME_TRANSFORMS = message("foxglove.FrameTransforms", {"transforms": list_of(FRAME_TRANSFORM)})
LOCATION_FIX = message(
    "foxglove.LocationFix",
    {
        "timestamp": TIME,
        "frame_id": TEXT,
        "latitude": NUMBER,
        "longitude": NUMBER,
        "altitude": NUMBER,
        "position_covariance": {**list_of(NUMBER), "minItems": 9, "maxItems": 9},
        "position_covariance_type": choice("foxglove.PositionCovarianceType", UNKNOWN=0, APPROXIMATED=1, DIAGONAL_KNOWN=2, KNOWN=3),
    },
)
LOG = message(
    "foxglove.Log",
    {
        "timestamp": TIME,
        "level": choice("foxglove.LogLevel", UNKNOWN=0, DEBUG=1, INFO=2, WARNING=3, ERROR=4, FATAL=5),
        "message": TEXT,
        "name": TEXT,
        "file": TEXT,
        "line": {"type": "integer", "minimum": 0},
    },
)
COMPRESSED_IMAGE = message("foxglove.CompressedImage", {"timestamp": TIME, "frame_id": TEXT, "data": BYTES, "format": TEXT})

_LINE = message(
    "foxglove.LinePrimitive",
    {
        "type": choice("foxglove.LineType", LINE_STRIP=LINE_STRIP, LINE_LOOP=1, LINE_LIST=LINE_LIST),
        "pose": POSE,
        "thickness": NUMBER,
        "scale_invariant": FLAG,
        "points": list_of(POINT),
        "color": COLOUR,
        "colors": list_of(COLOUR),
        "indices": list_of({"type": "integer", "minimum": 0}),
    },
)
_SPHERE = message("foxglove.SpherePrimitive", {"pose": POSE, "size": VECTOR, "color": COLOUR})
_TEXT_LABEL = message(
    "foxglove.TextPrimitive",
    {"pose": POSE, "billboard": FLAG, "font_size": NUMBER, "scale_invariant": FLAG, "color": COLOUR, "text": TEXT},
)
# Primitives that are never used here are lists of anything, and empty.
UNUSED_PRIMITIVES = ("arrows", "cubes", "cylinders", "triangles", "models")
SCENE_UPDATE = message(
    "foxglove.SceneUpdate",
    {
        "deletions": list_of({"title": "foxglove.SceneEntityDeletion", "type": "object"}),
        "entities": list_of(
            message(
                "foxglove.SceneEntity",
                {
                    "timestamp": TIME,
                    "frame_id": TEXT,
                    "id": TEXT,
                    "lifetime": DURATION,
                    "frame_locked": FLAG,
                    "metadata": list_of(KEY_VALUE),
                    "spheres": list_of(_SPHERE),
                    "lines": list_of(_LINE),
                    "texts": list_of(_TEXT_LABEL),
                    **{name: list_of({"type": "object"}) for name in UNUSED_PRIMITIVES},
                },
            )
        ),
    },
)

UNCERTAINTY = message(
    "ssjs.Uncertainty",
    {
        "timestamp": TIME,
        **dict.fromkeys(("sigma_x_m", "sigma_y_m", "sigma_z_m", "sigma_major_m", "sigma_minor_m", "sigma_heading_rad"), NUMBER),
    },
)
DEPTH = message("ssjs.Depth", {"timestamp": TIME, "depth_m": NUMBER})
ALTITUDE = message("ssjs.Altitude", {"timestamp": TIME, "altitude_m": NUMBER})
CONSISTENCY = message("ssjs.Consistency", {"timestamp": TIME, "nis": NUMBER, "dof": WHOLE_NUMBER, "nis_per_dof": NUMBER})


def _contact_column(name: str) -> Schema:
    if name in CONTACT_WHOLE_NUMBERS:
        return WHOLE_NUMBER
    return TEXT if COLUMNS[name] is None else NUMBER


CONTACT = message("ssjs.Contact", {"timestamp": TIME, **{name: _contact_column(name) for name in COLUMNS}}, optional=tuple(COLUMNS))


def schema_bytes(schema: Schema) -> bytes:
    return json.dumps(schema, separators=(",", ":")).encode("utf-8")
