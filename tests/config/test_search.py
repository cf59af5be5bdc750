"""Solvers are named in the configuration, with their own options."""

from dataclasses import dataclass, field
from typing import Literal

import pytest

from trackweave.config import load_configuration, search
from trackweave.config.load import without_deadline
from trackweave.config.schema import json_schema
from trackweave.errors import InvalidInputError
from trackweave.solvers import Annealing, Genetic, Islands


@dataclass(frozen=True, slots=True)
class Climber:
    """A solver as a file sees it."""

    steps: int = 10
    ratio: float = 0.5
    start: Literal["low", "high"] = "low"
    limit: float | None = None
    parts: tuple[object, ...] = field(default=())

    def __post_init__(self) -> None:
        if self.steps < 1:
            raise InvalidInputError(f"steps: {self.steps}; expected at least 1")


@pytest.fixture
def climbers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "_solver_class", lambda method: Climber)
    search.options_of.cache_clear()
    yield
    search.options_of.cache_clear()


def made(section: dict[str, object]) -> object:
    given = load_configuration({"search": section}).table("search")
    return search.make_solver(without_deadline(given))


def test_no_method_leaves_the_choice_to_the_tracker() -> None:
    assert made({}) is None
    assert made({"deadline_ms": 5.0}) is None


@pytest.mark.usefixtures("climbers")
def test_options_reach_the_solver() -> None:
    assert made({"method": "greedy", "steps": 3, "limit": 2.0}) == Climber(steps=3, limit=2.0)


@pytest.mark.usefixtures("climbers")
@pytest.mark.parametrize(
    ("section", "said"),
    [
        ({"method": "gready"}, 'search.method: "gready" is not known; did you mean greedy?'),
        (
            {"method": "max-min-ant-system"},
            'search.method: "max-min-ant-system" is not known; it was removed; annealing answers',
        ),
        ({"method": "greedy", "stesp": 1}, "search.stesp: unknown key; did you mean steps?"),
        ({"method": "greedy", "parts": []}, "search.parts: unknown key"),
        ({"method": "greedy", "steps": 1.5}, "search.steps: 1.5; expected a whole number"),
        (
            {"method": "greedy", "start": "mid"},
            'search.start: "mid"; expected "low" or "high"',
        ),
        ({"method": "greedy", "steps": 0}, "search.steps: 0; expected at least 1"),
        ({"deadline_ms": 0}, "search.deadline_ms: 0; expected a number > 0 of milliseconds"),
    ],
)
def test_refuses_what_a_solver_does_not_take(section: dict[str, object], said: str) -> None:
    with pytest.raises(InvalidInputError) as caught:
        load_configuration({"search": section})
    assert str(caught.value).startswith("configuration, ")
    assert said in str(caught.value)


def test_islands_name_what_lives_on_them() -> None:
    methods = ["annealing", {"method": "genetic", "population": 20}]
    made_of = made({"method": "islands", "methods": methods, "threads": 2})
    assert made_of == Islands((Annealing(), Genetic(population=20)), threads=2)


def test_islands_of_a_search_are_one_key_beside_its_own() -> None:
    one = Genetic(population=20)
    several = made({"method": "genetic", "population": 20, "islands": 4})
    assert several == Islands((one,), 4, own_limits=True)
    assert made({"method": "genetic", "population": 20, "islands": 1}) == one


@pytest.mark.parametrize(
    ("section", "said"),
    [
        ({"method": "genetic", "islands": 0}, "search.islands: 0; expected at least one"),
        ({"method": "genetic", "islands": "four"}, 'search.islands: "four"; expected a whole'),
        ({"method": "exact", "islands": 2}, "search.islands: a key of"),
        (
            {"method": "genetic", "population": "by-sise"},
            'search.population: "by-sise"; expected a whole number or "by-size"',
        ),
    ],
)
def test_refuses_islands_and_sizes_that_cannot_be(section: dict[str, object], said: str) -> None:
    with pytest.raises(InvalidInputError) as caught:
        load_configuration({"search": section})
    assert said in str(caught.value)


def test_sizes_may_go_by_the_problem() -> None:
    assert made({"method": "genetic", "population": "by-size"}) == Genetic(population="by-size")


def test_the_schema_shows_the_names_of_islands_methods() -> None:
    known = json_schema()["$defs"]["SearchSection"]["properties"]["methods"]["anyOf"]
    assert [option["default"] for option in known] == [["annealing", "tabu"]]


@pytest.mark.parametrize(
    ("methods", "said"),
    [
        (["auto"], 'search.methods: "auto" is no search; expected one of genetic'),
        (["islands"], 'search.methods: "islands" is no search'),
        (["gentic"], 'search.methods: "gentic" is no search; did you mean genetic?'),
        ([{"population": 3}], 'search.methods: "" is no search'),
        ([{"method": "tabu", "smaple": 3}], "search.methods.smaple: unknown key; did you mean"),
        ([{"method": "tabu", "sample": 0}], "search.methods.sample: 0; expected a whole number"),
        ([{"method": "tabu", "sample": 1.5}], "search.methods.sample: 1.5; expected a whole"),
        ("annealing", 'search.methods: "annealing"; expected a list of searches'),
        ([3], "search.methods: [3]; expected a list of searches"),
        ([], "search.methods: (); expected searches"),
    ],
)
def test_refuses_what_cannot_live_on_islands(methods: object, said: str) -> None:
    with pytest.raises(InvalidInputError) as caught:
        load_configuration({"search": {"method": "islands", "methods": methods}})
    assert str(caught.value).startswith("configuration, ")
    assert said in str(caught.value)


@pytest.mark.parametrize("method", search.METHODS)
def test_every_named_method_exists_and_needs_no_options(method: str) -> None:
    assert made({"method": method}) is not None
