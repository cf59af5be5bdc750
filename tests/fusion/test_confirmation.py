"""The N-of-M rule."""

import numpy as np
import pytest

from trackweave.errors import InvalidInputError
from trackweave.fusion.confirmation import Confirmation

A, B = (1, 1), (1, 2)


@pytest.mark.parametrize("text", ["2/3", "3/4", "4/5", "6/8"])
def test_a_pairing_is_declared_when_it_came_out_so_often_and_not_before(text: str) -> None:
    rule = Confirmation.parse(text)
    often = [[A]] * rule.needed + [[B]] * (rule.of - rule.needed)
    assert rule.declared(often) == {A}
    seldom = [[A]] * (rule.needed - 1) + [[B]] * (rule.of - rule.needed + 1)
    assert A not in rule.declared(seldom)


def test_only_the_last_associations_count() -> None:
    rule = Confirmation(2, 3)
    assert rule.declared([[A], [A], [B]]) == {A}
    assert rule.declared([[A], [A], [B], [B]]) == {B}
    assert rule.declared([[A], [A], [], []]) == frozenset()


def test_a_pairing_counts_once_in_an_association() -> None:
    assert Confirmation(2, 3).declared([[A, A], [B]]) == frozenset()


def test_declares_as_soon_as_enough_have_come_out() -> None:
    rule = Confirmation(2, 3)
    assert rule.declared([[A]]) == frozenset()
    assert rule.declared([[A], [A]]) == {A}


def test_groups_hang_together_by_pairs_that_came_out_often() -> None:
    # Tracks 0 and 1 came out together twice in three, 1 and 2 once, 3 is not always live.
    label = np.array([[0, 0, 1, -1], [0, 1, 1, 2], [0, 0, 1, 1]])
    group = Confirmation(2, 3).declared_groups(label, np.array([0, 1, 2, 3]))
    assert group[0] == group[1]
    assert len(set(group.tolist())) == 3


def test_a_group_has_one_track_of_a_sensor() -> None:
    # By chance 0–1 and 1–2 and 2–3 hang together, but 0 and 3 are of one sensor.
    label = np.array([[0, 0, 1, 1], [0, 0, 0, 1], [1, 0, 0, 0]])
    group = Confirmation(2, 3).declared_groups(label, np.array([0, 1, 2, 0]))
    assert group[0] != group[3]
    assert group[0] == group[1]


def test_tracks_that_are_never_together_are_alone() -> None:
    group = Confirmation(2, 3).declared_groups(np.array([[0, 1], [0, 1]]), np.array([0, 1]))
    assert group.tolist() == [0, 1]


@pytest.mark.parametrize(("needed", "of"), [(3, 2), (1, 2), (2, 4), (0, 1), (2.0, 3), (True, 1)])
def test_refuses_a_rule_that_could_declare_two_pairings_of_one_track(needed: int, of: int) -> None:
    with pytest.raises(InvalidInputError, match=r"needed.*; expected"):
        Confirmation(needed, of)


@pytest.mark.parametrize("text", ["3", "3/", "a/b", "3-4", "-3/4"])
def test_refuses_a_text_that_names_no_rule(text: str) -> None:
    with pytest.raises(InvalidInputError, match="expected N/M, such as 3/4"):
        Confirmation.parse(text)
