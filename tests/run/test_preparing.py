"""Getting ready for deadlines."""

import gc

import numpy as np
import polars as pl

from trackweave.config import load_configuration
from trackweave.domain.scans import Scan
from trackweave.formats.reading import read_reports
from trackweave.run.course import course_of
from trackweave.run.preparing import REPORTS, few_of, prepare, without_pauses
from trackweave.run.tracking import settings_for
from trackweave.solvers import Auto


def test_few_reports_of_a_scan_are_its_first_with_all_their_columns():
    count = REPORTS + 5
    whole = Scan(
        3.0, "radar", np.arange(2.0 * count).reshape(-1, 2), moments=np.linspace(2.0, 3.0, count),
        platform=np.arange(6.0), identity=np.arange(count), strength=np.ones(count),
        height=np.arange(1.0 * count),
    )  # fmt: skip
    few = few_of(whole)
    assert len(few) == REPORTS
    for name in ("measurement", "moments", "identity", "strength", "height", "report", "sigma"):
        np.testing.assert_array_equal(getattr(few, name), getattr(whole, name)[:REPORTS])
    np.testing.assert_array_equal(few.platform, whole.platform)
    assert few_of(few) is few


def test_preparing_leaves_the_run_and_its_randomness_as_they_are():
    rows = {"time": np.repeat(np.arange(8.0), 3), "x": np.tile([0.0, 500.0, 900.0], 8)}
    reports = read_reports(pl.DataFrame({**rows, "y": rows["x"] + rows["time"]}))
    settings = settings_for(reports, load_configuration({"sensors": {"default": {"sigma": 5.0}}}))
    course, rng = course_of(reports, settings, {}, None), np.random.default_rng(4)
    prepare(course, Auto(evaluations=200, branches=0), rng)
    assert rng.random() == np.random.default_rng(4).random()
    assert len(course.tracker.pending()) == 0


def test_what_lives_already_is_set_aside_for_a_while():
    before = gc.get_freeze_count()
    with without_pauses():
        held = gc.get_freeze_count()
        with without_pauses():
            assert gc.get_freeze_count() == held
        assert gc.get_freeze_count() == held
    assert held > before
    assert gc.get_freeze_count() == before
