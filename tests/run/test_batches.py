"""What is heard of objects that name themselves makes batches, not a scan of each report."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.run.batches import batches
from trackweave.run.scans import complete_scans, scan_ends


@pytest.mark.parametrize(
    ("time", "identity", "number"),
    [
        ([0.0, 0.2, 0.5], [1, 2, 3], [0, 0, 0]),
        ([0.0, 0.2, 0.51], [1, 2, 3], [0, 0, 1]),  # it lasts half a second
        ([0.0, 0.2, 0.3], [1, 1, 2], [0, 1, 1]),  # who reports again begins another
        ([0.0, 0.1, 0.2], [1, -1, 2], [0, 1, 2]),  # who does not say stays alone
        ([0.0, 0.1, 0.1, 0.2], [1, 2, 2, 3], [0, 1, 1, 2]),  # one name twice at once
        ([0.2, 0.0, 0.1], [3, 1, 2], [0, 0, 0]),  # in whatever order they stand
        ([], [], []),
    ],
)
def test_batches(time, identity, number):
    found = batches(np.array(time, dtype=float), np.array(identity, dtype=np.int64))
    assert found.tolist() == number


@pytest.mark.parametrize("seed", range(5))
def test_no_object_is_in_a_batch_twice_and_none_is_long(seed):
    rng = np.random.default_rng(seed)
    time = np.round(rng.uniform(0.0, 20.0, 300), 1)
    identity = rng.integers(-1, 15, 300)
    number = batches(time, identity)
    for batch in range(number.max() + 1):
        own = number == batch
        assert np.ptp(time[own]) <= 0.5
        names = identity[own]
        is_apart = np.unique(time[own]).size == 1
        assert is_apart or (np.unique(names).size == names.size and names.min() >= 0)
    assert np.all(np.diff(number[np.argsort(time, kind="stable")]) >= 0)


def sky(seed, named=True):
    """Six aircraft that tell where they are and two gliders, all of them before a radar."""
    rng, rows = np.random.default_rng(seed), []
    start = rng.uniform(-4e4, 4e4, (8, 2))
    angle, speed = rng.uniform(0, 2 * np.pi, 8), np.r_[rng.uniform(120, 200, 6), 30.0, 35.0]
    velocity = speed[:, None] * np.c_[np.sin(angle), np.cos(angle)]
    for look in range(36):
        for who in np.flatnonzero(rng.random(8) < 0.85):
            place = start[who] + velocity[who] * 5.0 * look + rng.normal(0.0, 60.0, 2)
            rows.append((5.0 * look, "radar", *place, None, int(who)))
        for _ in range(5):
            rows.append((5.0 * look, "radar", *rng.uniform(-6e4, 6e4, 2), None, -1))
    for who in range(6):
        time = rng.uniform(0.0, 1.0)
        while time < 180.0:
            place = start[who] + velocity[who] * time + rng.normal(0.0, 15.0, 2)
            name = f"A{who}" if named else None
            rows.append((round(time, 3), "adsb", *place, name, who))
            time += rng.uniform(0.8, 1.2)
    names = ["time", "sensor", "x", "y", "identity", "target"]
    table = pl.DataFrame(rows, schema=names, orient="row", infer_schema_length=None)
    return table.sort("time", maintain_order=True)


CONFIGURATION = {
    "motion": {"process_noise": 1.0, "max_speed": 250.0, "trust": True},
    "lifecycle": {"new_target_density": 1e-12},
    "sensors": {
        "radar": {"sigma": 60.0, "detection_probability": 0.85, "clutter_density": 3.5e-10,
                  "scan_period": 5.0, "trust": True},
        "adsb": {"sigma": 15.0, "detection_probability": 0.9, "clutter_density": 1e-13,
                 "scans": False, "trust": True},
    },
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("named", [True, False])
def test_what_a_radar_alone_sees_is_tracked_beside_many_lone_reports(named):
    # The window held fifteen of six reports a second: not one turn of the radar.
    table = sky(3, named)
    found = tw.track(table.drop("target"), CONFIGURATION, rng=0).reports
    found = found.with_columns(table["target"]).filter(pl.col("target") >= 6)
    assert found["track"].null_count() <= 4
    assert found.drop_nulls("track").group_by("target").agg(pl.col("track").n_unique())[
        "track"
    ].to_list() == [1, 1]


def test_reports_keep_their_own_times_in_few_scans():
    table = tw.read_reports(sky(4).drop("target"))
    periods = {"radar": 5.0, "adsb": None}
    scans = complete_scans(table, periods, hearing=["adsb"])
    own = [scan for scan in scans if scan.sensor == "adsb"]
    n_heard = sum(map(len, own))
    assert n_heard == int(np.sum(table.sensor == table.sensors.index("adsb")))
    assert len(own) < n_heard / 2
    ends = scan_ends(table, hearing=["adsb"])
    for scan in own:
        moments = np.full(len(scan), scan.time) if scan.moments is None else scan.moments
        assert moments.tolist() == table.time[scan.report].tolist()
        assert np.all(ends[scan.report] == scan.time)
