"""Fields of dataclasses, brought to the kinds that their annotations say."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

import numpy as np
import pytest

from trackweave.errors import InvalidInputError
from trackweave.fields import (
    Limit,
    checked_choice,
    checked_count,
    checked_dimension,
    checked_flag,
    checked_members,
    checked_number,
    settle,
)
from trackweave.keys import PROBABILITY, Key


@dataclass(frozen=True)
class Inner:
    size: int = 1


@dataclass(frozen=True)
class Thing:
    share: float = 0.5
    reach: Limit = np.inf
    count: int = 3
    deep: bool = True
    word: Literal["a", "b"] = "a"
    name: str = "n"
    place: tuple[float, float] = (0.0, 0.0)
    names: Sequence[str] = ()
    sizes: Mapping[str, float] = field(default_factory=dict)
    spread: float | tuple[float, ...] | None = None
    chance: Annotated[float | None, PROBABILITY] = None
    reaches: Annotated[Limit, Key("a number > 0", 1e-9, 9, is_open=True)] = 1.0
    keys: Annotated[bool | tuple[Annotated[str, Key(words=("a",))], ...], Key("which")] = False
    inner: Inner | None = None
    inners: tuple[Inner, ...] = ()
    call: Callable[[], bool] | None = None
    anything: Any = None

    def __post_init__(self) -> None:
        settle(self)


@pytest.mark.parametrize(
    ("name", "given", "kept"),
    [
        ("share", 1, 1.0),
        ("share", np.float32(0.25), 0.25),
        ("share", np.array(2), 2.0),
        ("reach", -np.inf, -np.inf),
        ("reach", np.float32(np.inf), np.inf),
        ("count", np.uint8(7), 7),
        ("count", np.array(7), 7),
        ("deep", np.bool_(False), False),
        ("word", np.str_("b"), "b"),
        ("name", np.str_("x"), "x"),
        ("place", [1, np.int64(2)], (1.0, 2.0)),
        ("place", np.array([1.0, 2.0]), (1.0, 2.0)),
        ("names", ["a", "b"], ("a", "b")),
        ("names", (n for n in "ab"), ("a", "b")),
        ("sizes", {"a": np.int64(2)}, {"a": 2.0}),
        ("spread", 3, 3.0),
        ("spread", [1, 2, 3], (1.0, 2.0, 3.0)),
        ("spread", None, None),
        ("inners", [Inner()], (Inner(),)),
        ("chance", np.float32(0.5), 0.5),
        ("reaches", 10, 10.0),
        ("reaches", np.inf, np.inf),
        ("keys", ["a"], ("a",)),
        ("keys", True, True),
        ("call", 3, 3),
        ("anything", {1}, {1}),
    ],
)
def test_a_field_takes_what_stands_for_its_kind(name: str, given: Any, kept: Any) -> None:
    found = getattr(Thing(**{name: given}), name)
    assert found == kept
    assert type(found) is type(kept)


@pytest.mark.parametrize(
    ("name", "given", "message"),
    [
        ("share", True, "share: True; expected a finite number"),
        ("share", np.nan, "share: nan; expected a finite number"),
        ("share", np.inf, "share: inf; expected a finite number"),
        ("share", 10**400, "share: 1000.*; expected a finite number"),
        ("share", np.datetime64("2024-01-01", "ns"), "share: .*; expected a finite number"),
        ("reach", np.nan, "reach: nan; expected a number"),
        ("count", 3.0, "count: 3.0; expected a whole number"),
        ("count", 2**63, "count: 9223372036854775808; expected a whole number"),
        ("deep", 1, "deep: 1; expected True or False"),
        ("word", "c", "word: 'c'; expected one of a, b"),
        ("word", ["a"], "word: .*; expected one of a, b"),
        ("place", (1.0,), "place: .*; expected .a finite number, a finite number"),
        ("names", "ab", "names: 'ab'; expected a sequence, each entry a text"),
        ("names", {"a", "b"}, "names: .*; expected a sequence, each entry a text"),
        ("names", [1], "names: .*; expected a sequence, each entry a text"),
        ("sizes", [("a", 1.0)], "sizes: .*; expected a mapping from names, each to a finite"),
        ("spread", "3", "spread: '3'; expected a finite number or a sequence, .* or None"),
        ("chance", 1.0, "chance: 1.0; expected a number between 0 and 1 or None"),
        ("chance", "1", "chance: '1'; expected a number between 0 and 1 or None"),
        ("reaches", 0.0, "reaches: 0.0; expected a number > 0"),
        ("keys", ["b"], "keys: .*; expected which"),
        ("inner", Inner, "inner: .*; expected an Inner or None"),
        ("inners", [Inner(), None], "inners: .*; expected a sequence, each entry an Inner"),
    ],
)
def test_a_field_refuses_another_kind_and_says_which(name: str, given: Any, message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        Thing(**{name: given})


def test_values_alone_are_checked_alike() -> None:
    assert checked_number(np.array(2), "x") == 2.0
    assert checked_count(np.int64(2), "x", 2) == 2
    assert checked_choice("a", "x", ["a", "b"]) == "a"
    assert checked_flag(np.bool_(True), "x") is True
    assert checked_dimension(np.array(3)) == 3
    assert checked_members((Inner(),), Inner, "x") == [Inner()]


@pytest.mark.parametrize(
    ("check", "message"),
    [
        (lambda: checked_number("2", "x", "a number ≥ 0"), "x: '2'; expected a number ≥ 0"),
        (lambda: checked_count(1, "x", 2), "x: 1; expected a whole number ≥ 2"),
        (lambda: checked_count(2.5, "x"), "x: 2.5; expected a whole number ≥ 0"),
        (lambda: checked_choice(None, "x", ["a", "b"]), "x: None; expected one of a, b"),
        (lambda: checked_flag(0, "x"), "x: 0; expected True or False"),
        (lambda: checked_dimension(4), "dim: 4; expected 2 or 3"),
        (lambda: checked_members(3, Inner, "x"), "x: 3; expected a sequence of Inner"),
        (lambda: checked_members([3], Inner, "x"), r"x\[0\]: 3; expected an instance of Inner"),
    ],
)
def test_values_alone_are_refused_alike(check: Callable[[], object], message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        check()
