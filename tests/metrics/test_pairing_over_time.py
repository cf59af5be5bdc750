"""Tests of CLEAR MOT, identity measures and HOTA, which pair identities over time."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from oracles import metrics as oracle
from trackweave.domain.truth import TruthTable
from trackweave.errors import InvalidInputError
from trackweave.metrics.clear_mot import clear_mot
from trackweave.metrics.hota import hota
from trackweave.metrics.identity import identity
from trackweave.metrics.moments import Moments, align

CUTOFF = 10.0


def table(rows: oracle.Rows) -> TruthTable:
    flat = [(time, name, place) for time, here in rows.items() for name, place in here.items()]
    return TruthTable.from_columns(
        [float(row[0]) for row in flat],
        [row[1] for row in flat],
        np.array([row[2] for row in flat]).reshape(-1, 2),
    )


def moments(truth: oracle.Rows, tracks: oracle.Rows) -> Moments:
    return align(table(truth), table(tracks), 0.0)


def on_line(*names: str) -> oracle.Rows:
    """Return one target or track at the origin whose name changes over time; '' = absent."""
    return {time: {name: (0.0, 0.0)} if name else {} for time, name in enumerate(names)}


def scene_of(seed: int) -> tuple[oracle.Rows, oracle.Rows]:
    """Return up to three targets and three tracks that jump between crowded places.

    Places are drawn evenly, so that no two pairings are equally good: which of two equals is
    taken is nobody's business.
    """
    rng = np.random.default_rng(seed)

    def crowd(names: str, least: int) -> dict[str, oracle.Place]:
        present = rng.choice(list(names), size=rng.integers(least, 4), replace=False)
        return {str(name): tuple(rng.uniform((0, 0), (25, 4))) for name in present}

    n_times = int(rng.integers(1, 6))
    return (
        {time: crowd("abc", 1) for time in range(n_times)},
        {time: crowd("xyz", 0) for time in range(n_times)},
    )


def scenes() -> st.SearchStrategy[tuple[oracle.Rows, oracle.Rows]]:
    return st.integers(0, 2**32 - 1).map(scene_of)


@given(scenes())
def test_clear_mot_agrees_with_the_procedure_step_by_step(
    scene: tuple[oracle.Rows, oracle.Rows],
) -> None:
    found = clear_mot(moments(*scene), CUTOFF, 2.0)
    expected = oracle.clear_mot(*scene, CUTOFF, 2.0)
    assert found.mota == pytest.approx(expected["mota"])
    assert (np.nan if found.motp is None else found.motp) == pytest.approx(
        expected["motp"], nan_ok=True
    )
    for key in ("switches", "fragmentations", "n_missed", "n_false"):
        assert getattr(found, key) == expected[key]


@given(scenes())
def test_identity_agrees_with_all_namings(scene: tuple[oracle.Rows, oracle.Rows]) -> None:
    assert identity(moments(*scene), CUTOFF).idf1 == pytest.approx(oracle.idf1(*scene, CUTOFF))


@given(scenes())
def test_hota_agrees_with_all_pairings(scene: tuple[oracle.Rows, oracle.Rows]) -> None:
    found = hota(moments(*scene), CUTOFF)
    assert found is not None
    assert found.hota == pytest.approx(oracle.hota(*scene, CUTOFF), abs=1e-9)


@given(scenes(), st.permutations("xyz"))
def test_relabelling_tracks_changes_nothing(
    scene: tuple[oracle.Rows, oracle.Rows], names: list[str]
) -> None:
    truth, tracks = scene
    other = dict(zip("xyz", names, strict=True))
    renamed = {
        time: {other[name]: place for name, place in there.items()}
        for time, there in tracks.items()
    }
    before, after = moments(truth, tracks), moments(truth, renamed)
    assert clear_mot(before, CUTOFF) == clear_mot(after, CUTOFF)
    assert identity(before, CUTOFF) == identity(after, CUTOFF)
    first, second = hota(before, CUTOFF), hota(after, CUTOFF)
    assert first is not None
    assert second is not None
    assert first.hota == pytest.approx(second.hota)


def test_perfect_tracks_are_perfect() -> None:
    rows = {time: {"a": (time, 0.0), "b": (time, 9.0)} for time in range(5)}
    same = moments(rows, rows)
    found, higher, naming = clear_mot(same, CUTOFF), hota(same, CUTOFF), identity(same, CUTOFF)
    assert (found.mota, found.motp, found.rmse, found.covered) == (1.0, 0.0, 0.0, 1.0)
    assert (naming.idf1, naming.idp, naming.idr) == (1.0, 1.0, 1.0)
    assert higher is not None
    assert (higher.hota, higher.deta, higher.assa) == pytest.approx((1.0, 1.0, 1.0))


def test_counts_a_switch_when_another_track_takes_over() -> None:
    found = clear_mot(moments(on_line(*"aaaa"), on_line(*"xxyy")), CUTOFF)
    assert (found.switches, found.fragmentations) == (1, 0)
    assert found.mota == pytest.approx(1 - 1 / 4)


def test_counts_a_switch_over_a_gap_too() -> None:
    found = clear_mot(moments(on_line(*"aaaa"), on_line("x", "", "", "y")), CUTOFF)
    assert (found.switches, found.fragmentations, found.n_missed) == (1, 1, 2)


def test_the_same_track_after_a_gap_is_a_fragmentation_but_no_switch() -> None:
    found = clear_mot(moments(on_line(*"aaaa"), on_line("x", "", "x", "x")), CUTOFF)
    assert (found.switches, found.fragmentations) == (0, 1)


def test_a_targets_own_absence_is_no_fragmentation() -> None:
    truth = {0: {"a": (0.0, 0.0), "b": (90.0, 0.0)}, 1: {"b": (90.0, 0.0)}}
    truth[2] = truth[0]
    found = clear_mot(moments(truth, truth), CUTOFF)
    assert (found.switches, found.fragmentations) == (0, 0)


def test_keeps_a_pair_although_another_track_has_come_closer() -> None:
    truth = {time: {"a": (0.0, 0.0)} for time in range(2)}
    tracks = {0: {"x": (1.0, 0.0)}, 1: {"x": (8.0, 0.0), "y": (0.0, 0.0)}}
    found = clear_mot(moments(truth, tracks), CUTOFF)
    assert (found.switches, found.n_false) == (0, 1)
    assert found.rmse == pytest.approx(np.sqrt((1 + 64) / 2))


def test_identity_punishes_a_switch_by_how_long_it_lasts() -> None:
    naming = identity(moments(on_line(*"aaaaaaaa"), on_line(*"xxxxxxyy")), CUTOFF)
    assert naming.idf1 == pytest.approx(6 / 8)


def test_hota_of_one_switch_in_the_middle() -> None:
    # Detection is perfect; each pair's identities agree for half of the target's life.
    higher = hota(moments(on_line(*"aaaa"), on_line(*"xxyy")), CUTOFF)
    assert higher is not None
    assert higher.assa == pytest.approx(1 / 2)
    assert higher.hota == pytest.approx(np.sqrt(1 / 2))


def test_a_target_is_found_when_half_of_its_life_is_covered() -> None:
    half = clear_mot(moments(on_line(*"aaaa"), on_line("x", "x", "", "")), CUTOFF)
    less = clear_mot(moments(on_line(*"aaaa"), on_line("x", "", "", "")), CUTOFF)
    assert (half.n_found, less.n_found) == (1, 0)


def test_nothing_to_measure_is_none() -> None:
    empty = align(table({}), table({}), None)
    assert hota(empty, CUTOFF) is None
    assert identity(empty, CUTOFF).idf1 is None
    found = clear_mot(empty, CUTOFF)
    assert (found.mota, found.motp, found.rmse, found.covered) == (None, None, None, None)


@pytest.mark.parametrize("measure", [clear_mot, identity, hota])
def test_refuses_a_cutoff_of_zero(measure: object) -> None:
    assert callable(measure)
    with pytest.raises(InvalidInputError, match="cutoff: 0"):
        measure(moments(on_line("a"), on_line("x")), 0.0)
