"""A key is declared once: check, schema and comment follow from a field."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import pytest

from trackweave.config.tables import Section, Table, checked
from trackweave.errors import InvalidInputError
from trackweave.keys import COUNT, SECONDS, Key


@dataclass(frozen=True)
class Kettle:
    """Boils.

    Parameters
    ----------
    time
        How long it boils [s],
        at least.

        Not a word of this is the key's.
    inner
        No key of a file.
    """

    time: Annotated[float | None, SECONDS] = None
    cups: Annotated[int, COUNT] = 2
    inner: float = 3.0


class LidSection(Section, needed=("size", "hue")):
    """What lies on it."""

    size: Annotated[float, Key("a number", 0, 9)]
    hue: Literal["red", "blue"]


class KettleSection(Section, of=(Kettle,), entries=LidSection):
    """A kettle, and lids by name."""

    power: Annotated[float | Literal["most"], Key('a number ≥ 0, or "most"', 0, 3e3), "In watts."]
    sides: Annotated[tuple[Annotated[float, Key("", 1, 5)], ...], Key("two sides", size=(2, 2))]

    @staticmethod
    def rule(values: Mapping[str, Any]) -> str | None:
        return "time or power" if {"time", "power"} <= set(values) else None


def table() -> Table:
    return KettleSection.as_kind(Key())


def said(values: dict[str, Any]) -> str:
    with pytest.raises(InvalidInputError) as caught:
        checked(values, table(), "k.toml", "kettle")
    return str(caught.value)


def test_a_tables_keys_are_its_own_and_those_marked_in_the_classes_that_it_is_of() -> None:
    assert set(table().entries) == {"time", "cups", "power", "sides"}
    assert table().entries["time"].meaning == "How long it boils [s], at least."
    assert table().entries["power"].meaning == "In watts."


def test_values_come_as_they_are_used() -> None:
    values = {"time": 3, "sides": [1, 2], "top": {"size": 1, "hue": "red"}, "cups": None}
    taken = checked(values, table(), "k.toml")
    assert taken == {"time": 3.0, "sides": [1.0, 2.0], "top": {"size": 1.0, "hue": "red"}}
    assert isinstance(taken["time"], float)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"top": {"siz": 1}}, "kettle.top.siz: unknown key; did you mean size?"),
        ({"top": {"siz": None}}, "kettle.top.siz: unknown key; did you mean size?"),
        ({"time": 0}, "kettle.time: 0; expected a number > 0 in seconds, at least 1e-06"),
        ({"time": True}, "kettle.time: true; expected a number > 0 in seconds"),
        ({"cups": 1.0}, "kettle.cups: 1.0; expected a whole number from 1 to 1000"),
        ({"power": 1e4}, 'kettle.power: 10000.0; expected a number ≥ 0, or "most", at most 3000'),
        ({"power": "all"}, 'kettle.power: "all"; expected a number ≥ 0, or "most"'),
        ({"sides": [1, 6]}, "kettle.sides: [1, 6]; expected two sides, at most 5"),
        ({"sides": [1]}, "kettle.sides: [1]; expected two sides"),
        ({"time": 1, "power": 1}, "kettle: {time = 1, power = 1}; expected time or power"),
        ({"top": {"size": 1}}, "kettle.top: {size = 1}; expected at least size, hue"),
        (
            {"top": {"size": 1, "hue": "green"}, "cups": 0},
            "kettle.cups: 0; expected a whole number from 1 to 1000 (and 1 more)",
        ),
    ],
)
def test_the_first_wrong_key_is_named(values: dict[str, Any], message: str) -> None:
    assert said(values) == f"k.toml, {message}"


def test_the_schema_has_ranges_words_and_meanings() -> None:
    shared: dict[str, Any] = {}
    told = table().content(shared)
    assert told["properties"]["time"] == {
        "type": "number", "minimum": 1e-6, "maximum": 1e9,
        "description": "How long it boils [s], at least.",
    }  # fmt: skip
    assert told["properties"]["power"]["anyOf"][1] == {"type": "string", "enum": ["most"]}
    assert told["properties"]["sides"]["maxItems"] == 2
    assert told["additionalProperties"] == {"$ref": "#/$defs/LidSection"}
    assert shared["LidSection"]["required"] == ["size", "hue"]
    assert shared["LidSection"]["additionalProperties"] is False
