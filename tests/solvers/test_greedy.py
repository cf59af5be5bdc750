"""The cheapest first."""

import numpy as np

from trackweave.association.problem import AssignmentProblem, Status
from trackweave.solvers import Greedy


def test_takes_the_cheapest_and_strikes_what_it_excludes() -> None:
    problem = AssignmentProblem.from_tuples([[1, 1], [1, 2], [2, 1]], [-3.0, -2.0, -2.0])
    answer = Greedy()(problem, rng=np.random.default_rng(0))
    assert (answer.cost, answer.lower_bound) == (-3.0, -5.0)
    assert problem.row is not None
    assert problem.row[answer.nodes].tolist() == [0]
    assert (answer.status, answer.stop_reason) == (Status.FEASIBLE, "one pass")


def test_tracks_take_what_is_left() -> None:
    # Two tracks, items 1 and 2, want report 0; who comes second goes on without one.
    problem = AssignmentProblem(
        parent=[-1, -1, 0, 1], item=[1, 2, 0, 0], cost=[2.0, 2.0, -5.0, -4.0],
        total=[2.0, 2.0, -5.0, -4.0], must_cover=[0, 1, 1], instant=[0, -1, -1],
    )  # fmt: skip
    answer = Greedy()(problem, rng=np.random.default_rng(0))
    assert (answer.nodes.tolist(), answer.cost) == ([1, 2], -3.0)
