"""Cascades of two stages, one stump and one tree, in the project's JSON and in OpenCV's XML."""

import json
from typing import Any


def model(**others: Any) -> bytes:
    """As save_cascade writes it, with `others` in place of its members."""
    whole = {
        "format": "ssjs-haar-cascade",
        "version": 1,
        "window": [12, 8],
        "provenance": {
            "trained_with": "ssjs 0.1.0",
            "settings": {"seed": "7"},
            "layers": [
                {
                    "features": 1,
                    "detection_rate": 0.99,
                    "false_positive_rate": 0.4,
                    "target_detection_rate": 0.99,
                    "target_false_positive_rate": 0.5,
                    "negatives": 100,
                    "negatives_looked_at": 1000,
                }
            ],
            "stopped_because": "the plan is done",
        },
        "stages": [
            {"threshold": 0.5, "weak": [{"nodes": [[0, 0.1, 0, -1]], "leaves": [-1, 1]}]},
            {"threshold": -0.25, "weak": [{"nodes": [[1, 0.1, 1, -2], [0, 2.5, 0, -1]], "leaves": [-1, 1, 0.5]}]},
        ],
        "features": [
            {"tilted": False, "rects": [[0, 0, 9, 4, -1], [8, 0, 1, 4, 9]]},
            {"tilted": True, "rects": [[4, 0, 2, 2, -1], [4, 0, 1, 2, 2]]},
        ],
    }
    return json.dumps({**whole, **others}, indent=1).encode()


def json_models() -> list[bytes]:
    contour = {"mean": [0.5] * 16, "deviation": [0.1] * 16, "distances": [0.1, 0.2, 0.4]}
    return [
        model(),
        model(contour=contour),
        model(version=2),
        model(stages=[]),
        model(window=[1e9, -3]),
        b"{}",
        b"[[[[[[[[[[1e400]]]]]]]]]]",
    ]


XML = """<?xml version="1.0"?>
<opencv_storage>
<cascade type_id="opencv-cascade-classifier"><stageType>BOOST</stageType>
  <featureType>HAAR</featureType>
  <height>8</height>
  <width>12</width>
  <stageParams><maxDepth>2</maxDepth><maxWeakCount>1</maxWeakCount></stageParams>
  <featureParams><maxCatCount>0</maxCatCount><featSize>1</featSize><mode>ALL</mode></featureParams>
  <stageNum>2</stageNum>
  <stages>
    <_><maxWeakCount>1</maxWeakCount><stageThreshold>5.0e-01</stageThreshold>
      <weakClassifiers><_><internalNodes>0 -1 0 1.00000001e-01</internalNodes><leafValues>-1. 1.</leafValues></_></weakClassifiers></_>
    <_><maxWeakCount>1</maxWeakCount><stageThreshold>-0.25</stageThreshold>
      <weakClassifiers><_><internalNodes>1 -2 1 0.1 0 -1 0 2.5</internalNodes><leafValues>-1. 1. 0.5</leafValues></_></weakClassifiers></_>
  </stages>
  <features>
    <_><rects><_>0 0 9 4 -1.</_><_>8 0 1 4 9.</_></rects><tilted>0</tilted></_>
    <_><rects><_>4 0 2 2 -1.</_><_>4 0 1 2 2.</_></rects><tilted>1</tilted></_>
  </features>
</cascade>
</opencv_storage>
"""


def xml_models() -> list[bytes]:
    return [
        XML.encode(),
        XML.replace("<tilted>1</tilted>", "").encode(),
        XML.replace("HAAR", "LBP").encode(),
        XML.replace("0.25", "+1e39").encode(),
        XML.replace("<stageType>BOOST</stageType>", "<size>12 8</size>").encode(),
        b'<?xml version="1.0" encoding="UTF-16"?><!DOCTYPE a [<!ENTITY b "c">]><opencv_storage>&b;</opencv_storage>',
    ]
