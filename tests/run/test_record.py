"""How sure a run's answers are, in all."""

import pytest

from trackweave.association.problem import Certificate, Status
from trackweave.run.record import certainty_of


def entry(cost: float, bound: float, status: Status) -> dict[str, object]:
    gap = Certificate(cost, bound, status).gap
    return {"cost": cost, "lower_bound": bound, "gap": gap, "status": status}


def test_the_status_tells_what_is_proven_and_costs_are_the_weights_of_the_mean() -> None:
    entries = [
        entry(-1000.0, -1000.0, Status.OPTIMAL),
        # Within rounding of a cost that is near zero by chance.
        entry(1e-6, 1e-6 - 1e-12, Status.OPTIMAL),
        entry(-0.5, -10.5, Status.FEASIBLE),
        entry(0.0, -3.0, Status.FEASIBLE),
    ]
    found = certainty_of(entries, "scans")
    assert found["proven_scans"] == 2
    assert found["mean_gap"] == pytest.approx(13.0 / 1000.5)
    assert found["worst_gap"] == pytest.approx(20.0)
    assert found["worst_distance"] == pytest.approx(10.0)


def test_what_nothing_is_known_of_has_no_gap() -> None:
    nothing = entry(3.0, float("-inf"), Status.FEASIBLE)
    for entries in ([], [nothing], [nothing | {"gap": None}]):
        assert certainty_of(entries, "updates") == {
            "proven_updates": 0,
            "mean_gap": None,
            "worst_gap": None,
            "worst_distance": None,
        }


def test_what_is_best_of_what_was_kept_does_not_count_as_proven() -> None:
    among = entry(-10.0, -10.0, Status.OPTIMAL_AMONG_KEPT)
    assert certainty_of([among, entry(-10.0, -10.0, Status.OPTIMAL)], "scans")["proven_scans"] == 1
