"""The schemas are valid JSON schemas, hold for every message, and have the fields that viewers expect under their names."""

import importlib
import json
from typing import Any

import pytest
from exported_survey import Survey

from ssjs_cli.mcap_export import schemas

jsonschema = pytest.importorskip("jsonschema")

EVERY_SCHEMA = (
    schemas.POSE_IN_FRAME,
    schemas.FRAME_TRANSFORMS,
    schemas.LOCATION_FIX,
    schemas.LOG,
    schemas.COMPRESSED_IMAGE,
    schemas.SCENE_UPDATE,
    schemas.UNCERTAINTY,
    schemas.DEPTH,
    schemas.ALTITUDE,
    schemas.CONSISTENCY,
    schemas.CONTACT,
)


def test_every_schema_in_the_file_is_one_of_ours_and_valid(survey: Survey) -> None:
    ours = {schema["title"]: schema for schema in EVERY_SCHEMA}
    assert set(survey.recording.schemas) == set(ours)
    for title, schema in survey.recording.schemas.items():
        assert schema == json.loads(schemas.schema_bytes(ours[title]))
        jsonschema.Draft202012Validator.check_schema(schema)


def test_every_message_keeps_its_schema(survey: Survey) -> None:
    for topic, messages in survey.recording.messages.items():
        validator = jsonschema.Draft202012Validator(survey.recording.schemas[survey.recording.schema_of[topic]])
        step = max(1, len(messages) // 200)
        for _, content in messages[::step]:
            validator.validate(content)


def test_a_message_with_a_missing_field_is_refused_by_its_schema() -> None:
    validator = jsonschema.Draft202012Validator(schemas.DEPTH)
    with pytest.raises(jsonschema.ValidationError):
        validator.validate({"timestamp": {"sec": 0, "nsec": 0}})


# FieldDescriptor.cpp_type: integers, double and float, bool, enum, string and bytes, message
CPP_TYPES = {"integer": (1, 2, 3, 4), "number": (5, 6), "boolean": (7,), "choice": (8,), "string": (9,), "object": (10,)}
CPP_TYPES["array"] = tuple(range(1, 11))


def _fields_of(schema: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """The named messages inside a schema, by title."""
    found = {}
    if str(schema.get("title", "")).startswith("foxglove.") and schema.get("properties"):
        found[schema["title"]] = schema
    parts = [*schema.get("properties", {}).values(), *([schema["items"]] if "items" in schema else [])]
    for part in parts:
        found.update(_fields_of(part))
    return found


def _choices_of(schema: dict[str, Any]) -> dict[str, dict[str, Any]]:
    return {name: field for name, field in schema["properties"].items() if "oneOf" in field}


@pytest.mark.parametrize("schema", [schema for schema in EVERY_SCHEMA if schema["title"].startswith("foxglove.")], ids=lambda s: s["title"])
def test_fields_and_choices_are_those_of_the_published_messages(schema: dict[str, Any]) -> None:
    pytest.importorskip("foxglove_schemas_protobuf")
    for title, part in _fields_of(schema).items():
        name = title.removeprefix("foxglove.")
        module = importlib.import_module(f"foxglove_schemas_protobuf.{name}_pb2")
        published = getattr(module, name).DESCRIPTOR.fields_by_name
        for field, description in part["properties"].items():
            assert field in published, (title, field)
            assert (description.get("type") == "array") == bool(published[field].is_repeated), (title, field)
            assert published[field].cpp_type in CPP_TYPES[description.get("type", "choice")], (title, field)
        for field, description in _choices_of(part).items():
            values = {value.name: value.number for value in published[field].enum_type.values}
            ours = {entry["title"]: entry["const"] for entry in description["oneOf"]}
            assert {entry: values.get(entry) for entry in ours} == ours, (title, field)
