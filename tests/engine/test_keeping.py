"""An engine that stays open for those who ask again."""

from collections.abc import Iterator

import pytest

from oracles import errands
from trackweave.engine import is_worker, keeping, kept_engine
from trackweave.errors import InvalidInputError


@pytest.fixture(autouse=True)
def _ended() -> Iterator[None]:
    yield
    keeping._end()


def process_of(workers: int) -> int:
    with kept_engine("local", workers) as engine:
        engine.submit(errands.process)
        (outcome,) = engine.gather()
    return outcome.value


def test_it_stays_for_the_same_name_and_number_of_workers() -> None:
    first = process_of(1)
    assert process_of(1) == first


def test_one_thread_at_a_time_has_it() -> None:
    with kept_engine("local", 1):
        assert keeping._IN_USE.locked()
    assert not keeping._IN_USE.locked()


def test_another_ends_it() -> None:
    first = process_of(1)
    assert process_of(2) != first
    assert list(keeping._KEPT) == [("local", 2)]


def test_what_is_broken_off_ends_it() -> None:
    first = process_of(1)
    with pytest.raises(InvalidInputError), kept_engine("local", 1) as engine:
        engine.submit("no function")
    assert not keeping._KEPT
    assert process_of(1) != first


def test_a_worker_knows_that_it_is_one() -> None:
    with kept_engine("local", 1) as engine:
        engine.submit(is_worker)
        assert next(engine.gather()).value is True
    assert not is_worker()
