"""The metrics beside two independent programs, where these are installed.

``python3 -m pip install -e '.[test,test-peers]'`` installs them. Last compared: Stone Soup 1.9.1
and TrackEval 1.3.0, with NumPy 2.4.
"""

import datetime
import warnings
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from trackweave.arrays import FloatArray
from trackweave.domain.truth import TruthTable
from trackweave.metrics import (
    align,
    clear_mot,
    gospa,
    hota,
    identity,
    ospa,
    pair_over_time,
    target_records,
)
from trackweave.metrics.moments import Moments

CUTOFF = 40.0
SEEDS = range(6)
BEGIN = datetime.datetime(2026, 1, 1, tzinfo=datetime.UTC)


def peer(name: str) -> ModuleType:
    """Return another program's module, or skip; its own warnings are its own business."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return pytest.importorskip(name, reason=f"{name} comes with the extra test-peers")


Paths = dict[str, tuple[FloatArray, FloatArray]]


def scene(seed: int, spacing: float = 25.0) -> tuple[Paths, Paths]:
    """Return targets that wander, and tracks that miss, swap, break and are false.

    Each path is its times and places. Targets are there without a break, and there is a track at
    each time: TrackEval counts interruptions otherwise where this is not so.
    """
    rng = np.random.default_rng(seed)
    n_targets, n_times = 9, 40
    truth: Paths = {}
    rows: dict[str, list[tuple[float, float, float]]] = {}
    alias = [str(number) for number in range(n_targets)]
    births = rng.integers(0, 10, n_targets)
    deaths = rng.integers(30, n_times + 1, n_targets)
    births[0], deaths[0] = 0, n_times  # only the truth's times count
    home = spacing * np.stack(np.divmod(np.arange(n_targets), 3), axis=1)
    walk = home + np.cumsum(rng.normal(0, 3, (n_times, n_targets, 2)), axis=0)
    for target in range(n_targets):
        times = np.arange(births[target], deaths[target], dtype=float)
        truth[f"target {target}"] = times, walk[times.astype(int), target]
    for time in range(n_times):
        if rng.random() < 0.2:
            first, second = rng.choice(n_targets, 2, replace=False)
            alias[first], alias[second] = alias[second], alias[first]
        if rng.random() < 0.1:
            alias[rng.integers(n_targets)] = f"new {time}"
        for target in range(n_targets):
            if births[target] <= time < deaths[target] and rng.random() < 0.85:
                x, y = walk[time, target] + rng.normal(0, 8, 2)
                rows.setdefault(alias[target], []).append((time, x, y))
        rows.setdefault("ghost", []).append((time, *rng.uniform(-20, 80, 2)))
    tracks = {name: (np.array(path)[:, 0], np.array(path)[:, 1:]) for name, path in rows.items()}
    return truth, tracks


def table(paths: Paths) -> TruthTable:
    names = [name for name, (times, _) in paths.items() for _ in times]
    return TruthTable.from_columns(
        np.concatenate([times for times, _ in paths.values()]),
        names,
        np.concatenate([places for _, places in paths.values()]),
    )


def moments_of(seed: int, spacing: float = 25.0) -> Moments:
    truth, tracks = scene(seed, spacing)
    return align(table(truth), table(tracks), 0.0)


def for_trackeval(moments: Moments) -> dict[str, Any]:
    """Return what TrackEval's metrics read, with our similarity of places."""
    found = list(moments)
    return {
        "num_gt_dets": len(moments.truth.identity),
        "num_tracker_dets": len(moments.tracks.identity),
        "num_gt_ids": moments.n_targets,
        "num_tracker_ids": moments.n_tracks,
        "num_timesteps": len(found),
        "gt_ids": [moment.targets for moment in found],
        "tracker_ids": [moment.tracks for moment in found],
        "similarity_scores": [np.maximum(1 - moment.distance / CUTOFF, 0) for moment in found],
    }


def trackeval(metric: str, moments: Moments) -> dict[str, Any]:
    """Return a metric of TrackEval; every distance below the cutoff may be a pair."""
    metrics = peer("trackeval").metrics
    config = {"THRESHOLD": 1e-9, "PRINT_CONFIG": False}
    made = getattr(metrics, metric)() if metric == "HOTA" else getattr(metrics, metric)(config)
    found: dict[str, Any] = made.eval_sequence(for_trackeval(moments))
    return found


@pytest.mark.parametrize("seed", SEEDS)
def test_hota_is_trackevals(seed: int) -> None:
    moments = moments_of(seed)
    theirs, ours = trackeval("HOTA", moments), hota(moments, CUTOFF)
    assert ours is not None
    for name in ("HOTA", "DetA", "AssA", "LocA", "DetRe", "DetPr", "AssRe", "AssPr"):
        assert getattr(ours, name.lower()) == pytest.approx(np.mean(theirs[name]), abs=1e-12)
    np.testing.assert_allclose(ours.by_level, theirs["HOTA"], atol=1e-12)
    assert 0.05 < ours.hota < 0.95


@pytest.mark.parametrize("seed", SEEDS)
def test_clear_mot_is_trackevals(seed: int) -> None:
    moments = moments_of(seed)
    # Order 1: TrackEval pairs by the sum of similarities.
    theirs, ours = trackeval("CLEAR", moments), clear_mot(moments, CUTOFF, 1.0)
    assert ours.mota == pytest.approx(theirs["MOTA"], abs=1e-12)
    assert ours.motp is not None
    assert 1 - ours.motp / CUTOFF == pytest.approx(theirs["MOTP"], abs=1e-12)
    assert ours.switches == theirs["IDSW"]
    assert ours.fragmentations == theirs["Frag"]
    assert (ours.n_pairs, ours.n_missed, ours.n_false) == (
        theirs["CLR_TP"],
        theirs["CLR_FN"],
        theirs["CLR_FP"],
    )
    assert ours.switches > 3
    assert ours.fragmentations > 3


@pytest.mark.parametrize("seed", SEEDS)
def test_completeness_is_trackevals(seed: int) -> None:
    moments = moments_of(seed)
    theirs = trackeval("CLEAR", moments)
    records = target_records(moments, pair_over_time(moments, CUTOFF, 1.0))
    # For "mostly tracked" TrackEval asks for more than 0.8, we for at least 0.8.
    on_edge = [record.covered for record in records].count(0.8)
    words = [record.completeness for record in records]
    assert words.count("mostly tracked") - on_edge == theirs["MT"]
    assert words.count("partly tracked") + on_edge == theirs["PT"]
    assert words.count("mostly lost") == theirs["ML"]


@pytest.mark.parametrize("seed", SEEDS)
def test_identity_is_trackevals(seed: int) -> None:
    moments = moments_of(seed)
    theirs, ours = trackeval("Identity", moments), identity(moments, CUTOFF)
    for name in ("IDF1", "IDP", "IDR"):
        assert getattr(ours, name.lower()) == pytest.approx(theirs[name], abs=1e-12)


def states(places: FloatArray) -> list[Any]:
    state = peer("stonesoup.types.state").State
    return [state(place.reshape(-1, 1), timestamp=BEGIN) for place in places]


def crowds(seed: int) -> tuple[FloatArray, FloatArray]:
    rng = np.random.default_rng(seed)
    return tuple(rng.uniform(0, 150, (rng.integers(1, 15), 2)) for _ in range(2))  # type: ignore[return-value]


@pytest.mark.parametrize("order", [1.0, 2.0])
@pytest.mark.parametrize("seed", SEEDS)
def test_gospa_is_stone_soups(seed: int, order: float) -> None:
    metric = peer("stonesoup.metricgenerator.ospametric").GOSPAMetric(c=CUTOFF, p=order)
    truth, tracks = crowds(seed)
    theirs = metric.compute_gospa_metric(states(tracks), states(truth))[0].value
    ours = gospa(truth, tracks, CUTOFF, order)
    assert ours.total == pytest.approx(theirs["distance"])
    for name in ("localisation", "missed", "false"):
        # Stone Soup gives the parts in the power of the order.
        assert getattr(ours, name) ** order == pytest.approx(theirs[name])


@pytest.mark.parametrize("seed", SEEDS)
def test_ospa_is_stone_soups(seed: int) -> None:
    generators = peer("stonesoup.metricgenerator.ospametric")
    truth, tracks = crowds(seed)
    theirs = generators.OSPAMetric(c=CUTOFF, p=1).compute_OSPA_distance(
        states(tracks), states(truth)
    )
    assert ospa(truth, tracks, CUTOFF, 1.0) == pytest.approx(theirs.value)
    # With a higher order Stone Soup still pairs by plain distances, not by their power, so that
    # its pairs need not be the best.
    theirs = generators.OSPAMetric(c=CUTOFF, p=2).compute_OSPA_distance(
        states(tracks), states(truth)
    )
    assert ospa(truth, tracks, CUTOFF, 2.0) <= theirs.value + 1e-9


def stone_soup_paths(paths: Paths, kind: str, name: str) -> set[Any]:
    path, state = getattr(peer(kind), name), peer("stonesoup.types.state").State
    return {
        path([
            state(place.reshape(-1, 1), timestamp=BEGIN + datetime.timedelta(seconds=time))
            for time, place in zip(times, places, strict=True)
        ])
        for times, places in paths.values()
    }  # fmt: skip


@pytest.mark.parametrize("seed", SEEDS)
def test_clear_mot_is_stone_soups_where_targets_lie_apart(seed: int) -> None:
    # Stone Soup pairs by distances without a cap, which is the same where only one is near. It
    # counts a switch only between neighbouring times, so that nothing may be missed in between.
    truth, tracks = scene(seed, spacing=400.0)
    whole = {"ghost": tracks["ghost"]} | {
        name: (times, places + np.random.default_rng(seed).normal(0, 5, places.shape))
        for name, (times, places) in truth.items()
    }
    for name in ("target 1", "target 4", "target 7"):
        times, places = whole.pop(name)
        half = times.size // 2
        whole |= {name: (times[:half], places[:half]), f"{name} b": (times[half:], places[half:])}
    true = stone_soup_paths(truth, "stonesoup.types.groundtruth", "GroundTruthPath")
    found = stone_soup_paths(whole, "stonesoup.types.track", "Track")
    measure = peer("stonesoup.measures").Euclidean([0, 1])
    manager = peer("stonesoup.metricgenerator.manager").MultiManager(
        [
            peer("stonesoup.metricgenerator.clearmotmetrics").ClearMotMetrics(
                distance_measure=measure
            )
        ],
        peer("stonesoup.dataassociator.clearmot").ClearMotAssociator(
            association_threshold=CUTOFF, measure=measure
        ),
    )
    manager.add_data({"groundtruth_paths": true, "tracks": found})
    theirs = manager.generate_metrics()["clearmot_generator"]
    ours = clear_mot(align(table(truth), table(whole), 0.0), CUTOFF, 1.0)
    assert ours.switches == 3
    assert ours.motp == pytest.approx(theirs["MOTP"].value)
    assert ours.mota == pytest.approx(theirs["MOTA"].value)
