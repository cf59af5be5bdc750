"""Tracks that divide: names and parents in every table of a run."""

import json

import numpy as np
import polars as pl
import pytest

import trackweave as tw

TOLD = {
    "sensors": {"default": {"sigma": 1.0, "detection_probability": 0.95, "scan_period": 1.0}},
    "motion": {"process_noise": 0.5, "max_speed": 10.0},
    "lifecycle": {"divide": True, "new_target_density": 1e-8},
}


def reports() -> pl.DataFrame:
    """Two cells; one divides at 20 s, and one of its daughters at 35 s."""
    rng = np.random.default_rng(5)
    cells = [
        (1, 0, 20, 100.0, 0.0), (2, 20, 35, 104.0, 1.0), (3, 20, 50, 96.0, -1.0),
        (4, 35, 50, 124.0, 0.5), (5, 35, 50, 114.0, -0.5), (6, 0, 50, 400.0, 0.0),
    ]  # fmt: skip
    rows = [
        (float(t), x + v * (t - first) + rng.normal(), 50.0 + rng.normal(), number)
        for number, first, end, x, v in cells
        for t in range(first, end)
    ]
    return pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row").sort("time")


@pytest.fixture(scope="module")
def result() -> tw.TrackingResult:
    return tw.track(reports(), TOLD)


def mothers_of(table: pl.DataFrame) -> dict[int, int | None]:
    return dict(table.select("track", "parent").unique().iter_rows())


def test_every_table_tells_mothers_and_daughters(result):
    names = dict(
        result.reports.drop_nulls("track").group_by("target").agg(pl.col("track").mode().first())
        .iter_rows()
    )  # fmt: skip
    assert len(set(names.values())) == 6
    lineage = {2: 1, 3: 1, 4: 2, 5: 2}
    expected = {names[child]: names[mother] for child, mother in lineage.items()}
    expected |= {names[1]: None, names[6]: None}
    history = result.history.filter(pl.col("status") != "tentative")
    assert mothers_of(history) == expected
    shown = mothers_of(result.tracks)
    assert {child: shown[child] for child in expected} == expected


def test_a_mother_ends_before_her_daughters_begin(result):
    spans = {
        track: (first, last)
        for track, first, last in result.history.group_by("track")
        .agg(pl.col("time").min(), pl.col("time").max().alias("end"))
        .iter_rows()
    }
    for child, mother in mothers_of(result.history).items():
        if mother is not None:
            assert spans[mother][1] < spans[child][0]


def test_the_record_has_the_divisions_and_their_bound(result):
    told = result.run["divisions"]
    assert [each["time"] for each in told["list"]] == pytest.approx([20.0, 35.0], abs=1.0)
    first, second = told["list"]
    assert second["mother"] in first["daughters"]
    assert all(len(each["daughters"]) == 2 for each in told["list"])
    assert told["cost"] == pytest.approx(told["lower_bound"])
    json.dumps(told)


def test_files_and_napari_have_the_lineage(result, tmp_path):
    result.save(tmp_path / "out")
    for name in ("tracks.csv", "history.csv"):
        assert "parent" in pl.read_csv(tmp_path / "out" / name).columns
    _, _, graph = result.to_napari()
    of = {child: [mother] for child, mother in mothers_of(result.history).items() if mother}
    assert graph == of
    assert result.plot() is not None


def test_daughters_are_believed_where_rows_are_rare():
    found = tw.track(reports(), {**TOLD, "output": {"period": 9.0}})
    daughters = {
        child for child, mother in mothers_of(found.history).items() if mother is not None
    }
    shown = found.history.filter(pl.col("status") != "tentative")["track"].to_list()
    assert len(found.run["divisions"]["list"]) > 0
    assert daughters <= set(shown)


def test_nothing_is_looked_for_where_nobody_asks():
    plain = {**TOLD, "lifecycle": {"new_target_density": 1e-8}}
    found = tw.track(reports(), plain)
    assert "parent" not in found.tracks.columns
    assert found.run["divisions"] is None
    assert found.run["configuration"]["lifecycle"]["divide"] is False


def test_divisions_are_looked_for_by_any_tracker():
    nearest = {**TOLD, "tracker": {"kind": "nearest-neighbour"}}
    assert len(tw.track(reports(), nearest).run["divisions"]["list"]) >= 1


def meeting_and_dividing(seed: int) -> pl.DataFrame:
    """Two cells that meet, are one spot from 20 to 32 s and part, and two others that divide."""
    rng = np.random.default_rng(seed)
    rows = []
    for t in range(60):
        apart = max(0.0, abs(t - 26.0) - 5.0)
        pair = [np.array([50.0 + 2.5 * sign * apart, 50.0 + 0.2 * t + sign]) for sign in (-1, 1)]
        is_one = np.hypot(*(pair[0] - pair[1])) < 8.0
        cells = (
            [("spot", (pair[0] + pair[1]) / 2)] if is_one else list(zip("ab", pair, strict=True))
        )
        cells.append(("alone", np.array([400.0 + 0.5 * t, 400.0])))
        for name, y, when in (("c", 200.0, 25), ("d", 350.0, 35)):
            since = t - when
            if since < 0:
                cells.append((name, np.array([250.0 + 0.5 * t, y])))
                continue
            for sign in (-1.0, 1.0):
                place = np.array([250.0 + 0.5 * t, y + sign * (5.0 + since)])
                cells.append((f"{name}{sign:+.0f}", place))
        rows += [(float(t), *(place + rng.normal(0, 0.5, 2)), name) for name, place in cells]
    return pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row")


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_what_parts_after_a_merge_is_no_daughter_where_cells_divide(seed):
    told = TOLD | {"lifecycle": TOLD["lifecycle"] | {"merge": 8.0, "delete_after_misses": 4}}
    result = tw.track(meeting_and_dividing(seed), told)
    divided = result.run["divisions"]["list"]
    assert [division["time"] for division in divided] == pytest.approx([25.0, 35.0], abs=2.0)
    history = result.history.filter(pl.col("status") != "tentative")
    assert history["track"].n_unique() == 9
    found = result.assignments
    spots = found.filter(pl.col("target") == "spot")
    both = set(found.filter(pl.col("target").is_in(["a", "b"]))["track"])
    assert len(both) == 2
    assert spots["shared_with"].is_not_null().mean() > 0.9
    for track, other in spots.drop_nulls("shared_with").select("track", "shared_with").iter_rows():
        assert {track, other} == both
    assert found["shared_with"].is_not_null().sum() <= len(spots) + 2
    assert not both & set(history.drop_nulls("parent")["track"])
