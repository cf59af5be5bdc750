"""The record of a run as JSON."""

import json
from enum import Enum
from pathlib import Path

import numpy as np
import pytest

from trackweave.io.encoding import encode_json


class Colour(Enum):
    RED = "red"


def test_values_become_what_json_knows():
    document = {
        "nan": float("nan"),
        "inf": np.float64("-inf"),
        "number": np.int32(3),
        "array": np.array([[1.5, np.nan]]),
        "enum": Colour.RED,
        "path": Path("a") / "b",
        "tuple": (1, None, True),
        "set": {2, 1},
        "deep": {"a": [{"b": float("inf")}]},
        3: "key",
    }
    assert json.loads(encode_json(document)) == {
        "nan": None,
        "inf": None,
        "number": 3,
        "array": [[1.5, None]],
        "enum": "red",
        "path": str(Path("a") / "b"),
        "tuple": [1, None, True],
        "set": [1, 2],
        "deep": {"a": [{"b": None}]},
        "3": "key",
    }


def test_keeps_the_order_of_keys_and_gives_a_scan_one_line():
    text = encode_json({"b": 1, "a": {"z": 1, "y": 2}, "scans": [{"k": 0}, {"k": 1}]}).decode()
    assert text == (
        '{\n  "b": 1,\n  "a": {\n    "z": 1,\n    "y": 2\n  },\n'
        '  "scans": [\n    {"k": 0},\n    {"k": 1}\n  ]\n}\n'
    )


@pytest.mark.parametrize("document", [{}, {"a": {}}, {"a": []}])
def test_takes_what_is_empty(document):
    assert json.loads(encode_json(document)) == document


def test_writes_text_in_utf8_and_names_that_are_none_as_escapes():
    data = encode_json({"unit": "m²", "file": "\udc80"})
    assert "m²".encode() in data
    assert json.loads(data) == {"unit": "m²", "file": "\udc80"}


def test_refuses_what_json_does_not_know():
    with pytest.raises(TypeError, match="object"):
        encode_json({"a": object()})
