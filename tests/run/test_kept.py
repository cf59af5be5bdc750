"""What attempts of a run share is taken again only where nothing is asked otherwise."""

import numpy as np
import pytest

from estimation.test_estimate import scene
from run.test_turning_radars import RADARS, sky
from trackweave.config import load_configuration
from trackweave.run import refining
from trackweave.run.kept import Kept
from trackweave.run.observing import settle
from trackweave.run.tracking import report_table


def test_nothing_is_known_at_first_nor_of_other_reports_or_questions():
    kept, time = Kept(), np.arange(3.0)
    assert kept.known((), ()) is None
    kept.keep(("told",), (time,), (1, 2, 3))
    assert kept.known(("told",), (time.copy(),)) == (1, 2, 3)
    assert kept.known(("other",), (time,)) is None
    assert kept.known(("told",), (time + 1.0,)) is None


@pytest.mark.parametrize(
    ("told", "is_again"),
    [
        ({"motion": {"process_noise": 0.3}}, False),
        ({"sensors": {"A": {"detection_probability": 0.7}}}, False),
        ({"sensors": {"A": {"sigma": 12.0}}}, True),
    ],
)
def test_what_reports_tell_alone_is_found_out_once(monkeypatch, told, is_again):
    found, calls, kept = refining.estimate, [], Kept()
    monkeypatch.setattr(refining, "estimate", lambda *a: calls.append(1) or found(*a))
    reports, nothing = scene(n_scans=12), load_configuration(None)
    configuration = load_configuration(told)
    refining.estimates_for(reports, nothing, kept=kept)
    shared = refining.estimates_for(reports, configuration, kept=kept)
    assert len(calls) == 1 + is_again
    assert shared == refining.estimates_for(reports, configuration)


@pytest.mark.slow
@pytest.mark.parametrize(("key", "is_again"), [("sigma", False), ("detection_probability", True)])
def test_noise_that_is_told_otherwise_is_no_reason_to_follow_all_again(monkeypatch, key, is_again):
    follow, calls, kept = refining._follow, [], Kept()
    monkeypatch.setattr(refining, "_follow", lambda *a: calls.append(1) or follow(*a))
    reports = sky(minutes=2.0)

    def settled(told, kept):
        keys = {n: {"position": list(at), "scan_period": s} for n, (at, s) in RADARS.items()}
        sensors = {name: own | told for name, own in keys.items()}
        configuration = load_configuration({"sensors": sensors})
        return settle(report_table(reports, configuration)[0], configuration, kept=kept)[1]

    settled({"sigma": {"range_m": 50.0, "azimuth_deg": 0.06}}, kept)
    before = len(calls)
    other = {"sigma": {"range_m": 100.0, "azimuth_deg": 0.12}, "detection_probability": 0.7}
    told = {"sigma": other["sigma"]} | {key: other[key]}
    shared = settled(told, kept)
    assert (len(calls) > before) == is_again
    assert shared.sensors == settled(told, Kept()).sensors
