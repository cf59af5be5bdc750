"""Grouping tracks is an assignment problem whose answer is the cheapest partition."""

from collections.abc import Iterator
from typing import Literal

import numpy as np
import pytest
from scipy.stats import chi2

from oracles.local_tracks import NOISE, sensor_tracks
from oracles.track_scenes import Objects, contrasts
from trackweave.association.problem import Status
from trackweave.fusion.associator import TrackAssociator
from trackweave.fusion.grouping import Grouping, Scene
from trackweave.fusion.histories import Histories
from trackweave.fusion.statistic import Statistic
from trackweave.run.fusion_record import local_pictures
from trackweave.solvers import Exact


def scene(seed: int, n_sensors: int, n_objects: int, n_times: int) -> Scene:
    """Return tracks of crowded objects after some times."""
    world = Objects(np.random.default_rng(seed), n_objects, spacing=1.0)
    world.velocity[:] = 0.0
    histories = Histories(Statistic(), 0.1, 3.0, [])
    for time in range(n_times):
        news = [world.seen(f"S{number}", float(time)) for number in range(n_sensors)]
        live = histories.take(float(time), {each.sensor: each for each in news})
    assert histories.rings is not None
    return Scene(histories.rings, histories.slots, live)


def partitions(sensor: list[int], groups: list[list[int]], next_track: int) -> Iterator[list]:  # type: ignore[type-arg]
    """Yield every way to put tracks into groups of one track of a sensor at most."""
    if next_track == len(sensor):
        yield [list(group) for group in groups]
        return
    for group in groups:
        if sensor[next_track] not in [sensor[track] for track in group]:
            group.append(next_track)
            yield from partitions(sensor, groups, next_track + 1)
            group.pop()
    groups.append([next_track])
    yield from partitions(sensor, groups, next_track + 1)
    groups.pop()


def cost_of(now: Scene, group: list[int], n_sensors: int) -> float:
    """Return what a group costs by the closed form, infinite where its test rejects it."""
    if len(group) == 1:
        return 0.0
    rows, size = now.live.row[group], len(now.slots) * 4
    value = sum(
        contrasts(now.rings.mean[rows, slot], now.rings.spread[rows, slot]) for slot in now.slots
    )
    if value > chi2.isf(0.01, size * (len(group) - 1)):
        return np.inf
    return (value - (len(group) - 1) * chi2.isf(0.01 / n_sensors**2, size)) / 2.0


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("n_sensors", "n_objects", "n_times"), [(2, 4, 2), (3, 2, 1), (4, 2, 3)])
def test_no_partition_costs_less(seed: int, n_sensors: int, n_objects: int, n_times: int) -> None:
    now = scene(seed, n_sensors, n_objects, n_times)
    costs: dict[tuple[int, ...], float] = {}
    best = np.inf
    for groups in partitions(now.live.sensor.tolist(), [], 0):
        for group in groups:
            if tuple(group) not in costs:
                costs[tuple(group)] = cost_of(now, group, n_sensors)
        best = min(best, sum(costs[tuple(group)] for group in groups))
    for search in (None, Exact()):
        found = Grouping(Statistic())(now, search, np.random.default_rng(0))
        assert found.certificate.cost == pytest.approx(best, abs=1e-3)
        assert found.certificate.status is Status.OPTIMAL


@pytest.mark.slow
def test_each_group_has_one_track_of_a_sensor_at_most_and_passes_its_test() -> None:
    now = scene(9, 6, 12, 3)
    found = Grouping(Statistic())(now, None, np.random.default_rng(0))
    for group in range(found.label.max() + 1):
        sensors = now.live.sensor[found.label == group].tolist()
        assert len(sensors) == len(set(sensors)) > 0
    assert np.all(found.value <= found.threshold)


def test_little_room_is_told_and_still_gives_an_answer() -> None:
    now = scene(10, 6, 6, 1)
    roomy = Grouping(Statistic(), breadth=10_000)(now, None, np.random.default_rng(0))
    narrow = Grouping(Statistic(), breadth=1, room=1)(now, None, np.random.default_rng(0))
    assert roomy.n_pruned == 0
    assert narrow.n_pruned > 0
    assert narrow.n_tuples < roomy.n_tuples
    assert narrow.certificate.cost >= roomy.certificate.cost - 1e-9
    assert roomy.certificate.cost <= -1.0


@pytest.mark.parametrize("correlation", ["none", "effective"])
@pytest.mark.parametrize("seed", range(3))
def test_what_is_held_and_passes_its_test_is_never_taken_apart(
    seed: int, correlation: Literal["none", "effective"]
) -> None:
    # Forty objects half a kilometre apart, four sensors: no track has anything else to go to.
    objects = {k: (800.0 * (k % 8), 800.0 * (k // 8)) for k in range(40)}
    pictures = []
    for number in range(4):
        tracks = sensor_tracks(np.random.default_rng([seed, number]), objects, range(20))
        pictures.append(local_pictures(f"S{number}", tracks, NOISE))
    associator = TrackAssociator(statistic=Statistic(correlation=correlation), process_noise=NOISE)
    for now in zip(*pictures, strict=True):
        found = associator.step(
            now[0].time, {each.sensor: each for each in now}, rng=np.random.default_rng(0)
        )
        splits = [change for change in found.changes if change.kind == "split"]
        assert all(change.statistic > change.threshold for change in splits)
