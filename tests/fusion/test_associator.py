"""Association of many sensors' tracks, one time after the other."""

import numpy as np
import pytest

from oracles.track_scenes import Objects, partition, picture
from trackweave.errors import InvalidInputError
from trackweave.fusion.associator import Association, TrackAssociator
from trackweave.fusion.pictures import LocalPicture
from trackweave.fusion.statistic import Statistic
from trackweave.solvers import Exact, ListGenetic

NEAR, FAR = (0.0, 0.0), (500.0, 0.0)


def generator() -> np.random.Generator:
    return np.random.default_rng(0)


def step(associator: TrackAssociator, time: float, *pictures: LocalPicture) -> Association:
    return associator.step(time, {each.sensor: each for each in pictures}, rng=generator())


def test_tracks_of_one_object_share_its_number_and_others_do_not() -> None:
    found = step(
        TrackAssociator(), 0.0,
        picture("A", 0.0, {1: NEAR, 2: FAR}), picture("B", 0.0, {7: (503.0, 4.0), 8: (3.0, 4.0)}),
    )  # fmt: skip
    assert found.of("A")[1] == found.of("B")[8]
    assert found.of("A")[2] == found.of("B")[7]
    assert found.of("A")[1] != found.of("A")[2]
    assert found.of("Z") == {}
    assert found.tuples() == {(1, 8), (2, 7)}
    assert found.certificate.gap == 0.0


def test_what_is_beyond_the_threshold_is_two_objects() -> None:
    # (√2 · 10 m apart along x) C⁻¹: λ = d² / 200.
    limit = np.sqrt(200.0 * 13.2767)
    near = step(
        TrackAssociator(),
        0.0,
        picture("A", 0.0, {1: NEAR}),
        picture("B", 0.0, {1: (limit - 1, 0)}),
    )
    assert len(set(near.object.tolist())) == 1
    assert near.statistic[0] < near.threshold[0] == pytest.approx(13.2767, rel=1e-4)
    far = step(
        TrackAssociator(),
        0.0,
        picture("A", 0.0, {1: NEAR}),
        picture("B", 0.0, {1: (limit + 1, 0)}),
    )
    assert len(set(far.object.tolist())) == 2


@pytest.mark.parametrize("n_sensors", [2, 3, 5])
@pytest.mark.parametrize("kind", ["fused-mean", "chain", "all-pairs"])
def test_objects_keep_their_numbers_over_time(kind: str, n_sensors: int) -> None:
    rng = np.random.default_rng(1)
    world, associator = (
        Objects(rng, 12),
        TrackAssociator(
            statistic=Statistic(kind, false_rejection=1e-4)  # type: ignore[arg-type]
        ),
    )
    names = [f"S{number}" for number in range(n_sensors)]
    first = step(associator, 0.0, *(world.seen(name, 0.0) for name in names))
    for time in range(1, 8):
        found = step(associator, float(time), *(world.seen(name, float(time)) for name in names))
    assert partition(found) == {frozenset((name, k) for name in names) for k in range(12)}
    assert found.of("S0") == first.of("S0")
    assert found.changes == ()


def test_lists_differ_and_objects_are_seen_by_some() -> None:
    rng = np.random.default_rng(2)
    world, associator = Objects(rng, 20), TrackAssociator()
    which = {"A": np.arange(0, 15), "B": np.arange(5, 20), "C": np.array([0, 7, 19]), "D": None}
    for time in range(6):
        pictures = [
            world.seen(name, float(time), np.empty(0, dtype=np.int64) if mine is None else mine)
            for name, mine in which.items()
        ]
        found = step(associator, float(time), *pictures)
    expected = {
        frozenset((name, k) for name, mine in which.items() if mine is not None and k in mine)
        for k in range(20)
    }
    assert partition(found) == {group for group in expected if len(group) > 1}
    assert found.of("D") == {}


def test_a_sensor_whose_tracks_are_all_false_joins_nothing_and_harms_nobody() -> None:
    rng = np.random.default_rng(3)
    world, associator = Objects(rng, 10), TrackAssociator()
    for time in range(4):
        false = picture("F", float(time), {k: (9e4 + 1e3 * k, -5e4) for k in range(10)})
        found = step(
            associator, float(time),
            world.seen("A", float(time)), world.seen("B", float(time)), false,
        )  # fmt: skip
    assert partition(found) == {frozenset({("A", k), ("B", k)}) for k in range(10)}
    assert len(set(found.of("F").values())) == 10


def test_one_sensor_alone_and_none_at_all() -> None:
    associator = TrackAssociator()
    found = step(associator, 0.0, picture("A", 0.0, {4: NEAR, 5: NEAR}))
    assert len(set(found.object.tolist())) == 2
    found = step(associator, 1.0, picture("A", 1.0, {}))
    assert len(found) == 0
    assert [change.kind for change in found.changes] == ["ended", "ended"]
    with pytest.raises(InvalidInputError, match="pictures: none so far"):
        step(TrackAssociator(), 0.0)


def test_what_changes_is_said_with_numbers() -> None:
    associator = TrackAssociator(statistic=Statistic(length=1))
    found = step(associator, 0.0, picture("A", 0.0, {1: NEAR}), picture("B", 0.0, {1: FAR}))
    assert [change.kind for change in found.changes] == ["begun", "begun"]
    found = step(associator, 1.0, picture("A", 1.0, {1: NEAR}), picture("B", 1.0, {1: NEAR}))
    (merged,) = found.changes
    assert (merged.kind, merged.object, merged.others) == ("merged", 1, (2,))
    assert merged.statistic == pytest.approx(0.0)
    assert "is within" in merged.reason
    found = step(associator, 2.0, picture("A", 2.0, {1: NEAR}), picture("B", 2.0, {1: FAR}))
    (split,) = found.changes
    assert (split.kind, split.object) == ("split", 1)
    assert split.statistic == pytest.approx(500.0**2 / 200.0)
    assert f"exceeds {split.threshold:.1f}" in split.reason


def test_what_is_held_takes_more_evidence_to_break() -> None:
    # λ = 16: beyond 13.3 at 1 %, within 18.5 at 0.1 %.
    between = (np.sqrt(200.0 * 16.0), 0.0)
    outcomes = []
    for hysteresis in (0.1, 1.0):
        associator = TrackAssociator(statistic=Statistic(length=1), hysteresis=hysteresis)
        apart = picture("B", 0.0, {1: between})
        assert len(set(step(associator, 0.0, picture("A", 0.0, {1: NEAR}), apart).object)) == 2
        step(associator, 1.0, picture("A", 1.0, {1: NEAR}), picture("B", 1.0, {1: NEAR}))
        apart = picture("B", 2.0, {1: between})
        outcomes.append(
            len(set(step(associator, 2.0, picture("A", 2.0, {1: NEAR}), apart).object))
        )
    assert outcomes == [1, 2]


def test_a_pairing_is_declared_only_after_it_came_out_often_enough() -> None:
    associator = TrackAssociator(confirm="2/3")
    sizes = []
    for time in range(4):
        found = step(
            associator, float(time),
            picture("A", float(time), {1: NEAR}), picture("B", float(time), {1: NEAR}),
        )  # fmt: skip
        sizes.append(len(set(found.object.tolist())))
    assert sizes == [2, 1, 1, 1]
    assert TrackAssociator(confirm=(3, 4)).confirm == (3, 4)


def test_a_row_that_another_track_gets_counts_from_anew() -> None:
    associator = TrackAssociator(confirm="2/3")
    for time, track in enumerate([1, 2, 3]):
        found = step(
            associator, float(time),
            picture("A", float(time), {track: NEAR}), picture("B", float(time), {track: NEAR}),
        )  # fmt: skip
        assert len(set(found.object.tolist())) == 2


def test_the_document_is_solved_to_the_letter() -> None:
    rng = np.random.default_rng(4)
    world = Objects(rng, 6)
    document = Statistic("chain", "full", false_rejection=0.001)
    answers = []
    for search in (ListGenetic(), Exact()):
        associator = TrackAssociator(
            sensors=["A", "B", "C"], statistic=document, search=search, complete=True
        )
        world.rng = np.random.default_rng(5)
        for time in range(3):
            found = step(
                associator, float(time), *(world.seen(name, float(time)) for name in "ABC")
            )
        answers.append(found)
    assert partition(answers[0]) == {frozenset((name, k) for name in "ABC") for k in range(6)}
    # J is the sum of the tuples' b.
    assert answers[0].certificate.cost == pytest.approx(answers[0].statistic.sum() / 3.0)
    assert answers[0].certificate.cost == pytest.approx(answers[1].certificate.cost)


def test_refuses_lists_that_differ_where_tuples_are_complete() -> None:
    associator = TrackAssociator(statistic=Statistic("chain"), complete=True)
    with pytest.raises(
        InvalidInputError, match="pictures: tracks A 1, B 2; expected equally many"
    ):
        step(associator, 0.0, picture("A", 0.0, {1: NEAR}), picture("B", 0.0, {1: NEAR, 2: FAR}))


def test_the_same_seed_gives_the_same_answer() -> None:
    answers = []
    for _ in range(2):
        world = Objects(np.random.default_rng(6), 30, spacing=2.0)
        associator = TrackAssociator()
        found = step(associator, 0.0, *(world.seen(name, 0.0) for name in "ABCD"))
        answers.append((found.object.tolist(), found.certificate))
    assert answers[0] == answers[1]


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"sensors": ["A"]}, r"sensors: \['A'\]; expected at least two, each once"),
        ({"sensors": "AB"}, "sensors: 'AB'; expected a sequence"),
        ({"sensors": ["A", "A"]}, "expected at least two, each once"),
        ({"process_noise": -1.0}, r"process_noise: -1\.0; expected a number ≥ 0"),
        ({"hysteresis": 0.0}, r"hysteresis: 0\.0; expected a number above 0"),
        ({"patience": 0.5}, r"patience: 0\.5; expected a number ≥ 1"),
        ({"breadth": 0}, "breadth: 0; expected a whole number ≥ 1"),
        ({"statistic": "chain"}, "statistic: 'chain'; expected a Statistic"),
        ({"search": 3}, "search: 3; expected a solver"),
        ({"complete": True}, "kind 'fused-mean'; expected 'chain' for complete tuples"),
        ({"confirm": "1/2"}, "expected more than half"),
    ],
)
def test_refuses_what_makes_no_associator(parts: dict[str, object], message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        TrackAssociator(**parts)  # type: ignore[arg-type]
