"""Which track takes which report, against every possibility."""

from itertools import product

import numpy as np
import pytest

from trackweave.association.problem import Status
from trackweave.trackers.pairing import Offers, nearest, one_to_one


def drawn(seed, n_tracks=4, n_reports=4):
    """Return offers for about half of all pairs, cheaper or dearer than to take none."""
    rng = np.random.default_rng(seed)
    track, report = np.nonzero(rng.random((n_tracks, n_reports)) < 0.6)
    cost = rng.normal(size=track.shape[0]) * 3.0
    return Offers(track, report, cost, rng.normal(size=n_tracks), n_reports)


def every_pairing(offers):
    """Yield the rows that the tracks take, -1 for none, in every allowed way."""
    own = [[-1, *np.flatnonzero(offers.track == t)] for t in range(offers.alone.shape[0])]
    for rows in product(*own):
        reports = [offers.report[row] for row in rows if row >= 0]
        if len(set(reports)) == len(reports):
            yield rows


def cost_of(offers, rows):
    return sum(
        offers.alone[track] if row < 0 else offers.cost[row] for track, row in enumerate(rows)
    )


@pytest.mark.parametrize("seed", range(30))
def test_one_to_one_costs_least_of_all_pairings(seed):
    offers = drawn(seed)
    pairing = one_to_one(offers)
    best = min(cost_of(offers, rows) for rows in every_pairing(offers))
    assert pairing.certificate.cost == pytest.approx(best, abs=1e-12)
    assert cost_of(offers, pairing.taken) == pytest.approx(best, abs=1e-12)
    assert pairing.certificate.status is Status.OPTIMAL
    held = {int(offers.report[r]): t for t, r in enumerate(pairing.taken.tolist()) if r >= 0}
    assert {r: t for r, t in enumerate(pairing.holder.tolist()) if t >= 0} == held


@pytest.mark.parametrize("seed", range(30))
def test_nearest_gives_every_track_its_cheapest_and_the_cheapest_track_holds(seed):
    offers = drawn(seed)
    dear = Offers(offers.track, offers.report, offers.cost, np.full(4, 99.0), offers.n_reports)
    pairing = nearest(dear)
    for track in range(4):
        own = np.flatnonzero(offers.track == track)
        expected = own[np.argmin(offers.cost[own])] if own.size else -1
        assert pairing.taken[track] == expected
    for report in range(4):
        takers = [t for t, r in enumerate(pairing.taken) if r >= 0 and offers.report[r] == report]
        expected = min(takers, key=lambda t: offers.cost[pairing.taken[t]], default=-1)
        assert pairing.holder[report] == expected
    certificate = pairing.certificate
    best = min(cost_of(dear, rows) for rows in every_pairing(dear))
    assert certificate.lower_bound <= best + 1e-12
    assert best <= certificate.cost + 1e-12
    is_shared = np.count_nonzero(pairing.holder >= 0) < np.count_nonzero(pairing.taken >= 0)
    assert (certificate.status is Status.FEASIBLE) == is_shared


@pytest.mark.parametrize("pair", [one_to_one, nearest])
@pytest.mark.parametrize(("n_tracks", "n_reports"), [(0, 0), (0, 3), (3, 0), (2, 2)])
def test_without_pairs_nobody_takes_anything(pair, n_tracks, n_reports):
    nobody = np.empty(0, dtype=np.int64)
    pairing = pair(Offers(nobody, nobody, np.empty(0), np.ones(n_tracks), n_reports))
    assert pairing.taken.tolist() == [-1] * n_tracks
    assert pairing.holder.tolist() == [-1] * n_reports
    assert pairing.certificate.cost == n_tracks
