"""What all regions cost and how good that is: each cluster is counted once, or told to be cut."""

from dataclasses import replace

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.association.certificate import Certificate, Status
from trackweave.engine import Outcome
from trackweave.run.regions import cutting, running
from trackweave.run.regions.bounding import Owned, owned, together
from trackweave.run.regions.cutting import Region
from trackweave.trackers.clusters import Clusters

SIDE, SCANS = 20_000.0, 10
CONFIG = {
    "motion": {"process_noise": 1.0, "max_speed": 300.0},
    "sensors": {"default": {"sigma": 40.0, "detection_probability": 0.9, "scan_period": 1.0,
                            "clutter_density": 2e-8}},
    "lifecycle": {"new_target_density": 1e-9},
}  # fmt: skip
LEFT = Region(np.array([-np.inf, -np.inf]), np.array([0.0, np.inf]))


def crossing(n: int, half_width: float, seed: int) -> pl.DataFrame:
    """Objects that fly in all directions over a plane, and false reports."""
    rng = np.random.default_rng(seed)
    reach = np.array([SIDE, half_width])
    start = rng.uniform(-reach, reach, (n, 2))
    speed = rng.uniform(-200.0, 200.0, (n, 2))
    rows = []
    for scan in range(SCANS):
        seen = rng.random(n) < 0.9
        place = (start + scan * speed)[seen] + rng.normal(0.0, 40.0, (int(seen.sum()), 2))
        false = rng.uniform(-reach, reach, (rng.poisson(2e-8 * 4 * SIDE * half_width), 2))
        rows += [(float(scan), x, y) for x, y in np.concatenate([place, false])]
    return pl.DataFrame(rows, schema=["time", "x", "y"], orient="row")


@pytest.fixture(autouse=True)
def _small(monkeypatch):
    """Regions of few reports."""
    monkeypatch.setattr(cutting, "LEAST", 100)
    monkeypatch.setattr(cutting, "CROWD", 0)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_costs_and_bounds_are_those_of_one_process_where_nothing_is_cut(seed):
    reports = crossing(60, SIDE / 4, seed)
    alone = tw.track(reports, CONFIG)
    apart = tw.track(reports, CONFIG, engine="local", workers=2)
    assert apart.run["regions"]["count"] > 1
    whole = 0
    for one, all_of_it in zip(alone.run["scans"], apart.run["scans"], strict=True):
        if all_of_it["cut_reports"]:
            assert all_of_it["status"] == Status.FEASIBLE
            continue
        whole += 1
        assert all_of_it["cost"] == pytest.approx(one["cost"], rel=1e-9, abs=1e-9)
        assert all_of_it["lower_bound"] <= all_of_it["cost"]
        assert all_of_it["lower_bound"] <= one["cost"] + 1e-9 * abs(one["cost"])
    assert whole >= SCANS / 2


@pytest.mark.slow
def test_what_is_cut_is_told_and_not_counted(monkeypatch):
    # So narrow a margin that a track's window reaches beyond it.
    monkeypatch.setattr(cutting, "WINDOWS", 0.1)
    reports = crossing(60, SIDE / 4, 3)
    alone, apart = tw.track(reports, CONFIG), tw.track(reports, CONFIG, engine="local", workers=2)
    pairs = zip(alone.run["scans"], apart.run["scans"], strict=True)
    cut = [(one, both) for one, both in pairs if both["cut_reports"]]
    assert cut
    assert {both["status"] for _, both in cut} == {Status.FEASIBLE}
    assert any(both["cost"] > one["cost"] + 1.0 for one, both in cut)


class Here:
    """An engine of no workers, where the first task fails."""

    workers = 1

    def __init__(self, *_: object) -> None:
        self.tasks = []
        self.n_failed = 0

    def submit(self, work, *given):
        self.tasks.append((work, given))

    def gather(self):
        tasks, self.tasks = self.tasks, []
        for number, (work, given) in enumerate(tasks):
            if self.n_failed:
                yield Outcome(number, work(*given))
            else:
                self.n_failed = 1
                yield Outcome(number, error="ArithmeticError: no")

    def close(self):
        pass


def test_of_the_whole_nothing_is_known_where_a_region_was_left_out(monkeypatch):
    monkeypatch.setattr(running, "engine_of", Here)
    run = tw.track(crossing(60, SIDE / 4, 1), CONFIG, engine="local").run
    assert run["regions"]["list"][0]["error"] == "ArithmeticError: no"
    for scan in run["scans"]:
        assert {scan[key] for key in ("cost", "lower_bound", "gap", "cut_reports")} == {None}
        assert scan["status"] == Status.FEASIBLE


def part_of(reports, place, *, cost=(-5.0,), owner=None, gap=0.0, is_own=(True, True, False)):
    """Return a region's part; its reports 0, 1, 2 have the numbers 10, 11, 12 in the run."""
    clusters = Clusters(
        np.array(cost), np.array(place, dtype=float), np.array(reports, dtype=np.int64),
        np.zeros(len(reports), dtype=np.int64) if owner is None else np.array(owner),
    )  # fmt: skip
    total = float(np.sum(cost))
    certificate = Certificate(total, total - gap, Status.FEASIBLE if gap else Status.OPTIMAL)
    return owned(clusters, certificate, LEFT, np.array([10, 11, 12]), np.array(is_own))


def test_a_cluster_is_the_regions_in_which_all_its_reports_lie():
    part = part_of([0, 1, 0, 2], [(-1.0, 0.0), (1.0, 0.0)], cost=(-5.0, -3.0),
                   owner=[0, 0, 0, 1], gap=0.5)  # fmt: skip
    assert (part.cost, part.slack, part.status) == (-5.0, 0.5, Status.FEASIBLE)
    assert part.shared.size == 0


@pytest.mark.parametrize(("x", "cost"), [(-1.0, -5.0), (0.0, 0.0), (np.nan, 0.0)])
def test_one_without_reports_is_where_it_was(x, cost):
    part = part_of([], [(x, 0.0)])
    assert (part.cost, part.slack, part.status) == (cost, 0.0, Status.OPTIMAL)
    assert part.shared.size == 0


def test_one_over_a_border_counts_once_where_both_regions_have_the_same():
    left = part_of([1, 2, 2], [(0.0, 0.0)], cost=(-5.0,), gap=0.5)
    right = part_of([1, 2], [(0.0, 0.0)], cost=(-5.5,), is_own=(False, False, True))
    assert left.shared[["count", "n_own", "is_first"]].tolist() == [(2, 1, True)]
    assert together([left, right]) == {
        "cost": -5.0, "lower_bound": -5.5, "gap": 0.1, "status": Status.FEASIBLE,
        "cut_reports": 0,
    }  # fmt: skip


def test_one_that_is_another_beyond_the_border_is_cut():
    left = part_of([0, 1, 2], [(0.0, 0.0)])
    right = part_of([1, 2], [(0.0, 0.0)], is_own=(False, False, True))
    assert together([left, right]) == {
        "cost": 0.0, "lower_bound": 0.0, "gap": 0.0, "status": Status.FEASIBLE, "cut_reports": 3,
    }  # fmt: skip
    both = part_of([0, 1], [(0.0, 0.0)])
    assert together([both, right])["cut_reports"] == 1


def test_a_whole_is_as_sure_as_the_least_sure_region():
    sure, kept = (
        Owned(-1.0, 0.0, status) for status in (Status.OPTIMAL, Status.OPTIMAL_AMONG_KEPT)
    )
    assert together([sure, sure])["status"] == Status.OPTIMAL
    assert together([sure, kept])["status"] == Status.OPTIMAL_AMONG_KEPT
    assert together([kept, replace(sure, status=Status.FEASIBLE)])["status"] == Status.FEASIBLE
