"""The arrival of the next scan ends the search of the last."""

import importlib.util
from itertools import pairwise
from pathlib import Path

import numpy as np

PATH = Path(__file__).resolve().parents[2] / "examples" / "live_next_scan.py"


def example():
    spec = importlib.util.spec_from_file_location("example_live_next_scan", PATH)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class Eager:
    """A receiver whose next scan is there as soon as somebody has asked so many times."""

    def __init__(self, scans, patience):
        self._scans, self._patience = scans, patience

    def has_arrived(self):
        self._asked += 1
        return self._asked > self._patience

    def scans(self):
        for scan in self._scans:
            self._asked = 0
            yield scan


def test_each_search_is_ended_by_the_next_scan_and_tells_its_gap():
    module, lines = example(), []
    scans = list(module.crowd(6, np.random.default_rng(5)))
    hypotheses = module.follow(Eager(scans, 20), lines.append)
    assert [each.time for each in hypotheses] == [each.time for each in scans]
    stopped = [each.stop_reason == "stopped" for each in hypotheses]
    assert any(one and other for one, other in pairwise(stopped))
    assert all(each.certificate.gap > 0.0 for each in hypotheses if each.stop_reason == "stopped")
    assert len(lines) == 6
    assert any("stopped by the next scan" in line and "gap 0." in line for line in lines)
    assert len(hypotheses[-1].tracks) > 15


def test_the_receiver_hands_over_every_scan_in_order():
    module = example()
    scans = list(module.crowd(4, np.random.default_rng(1)))
    receiver = module.Receiver(scans, 0.0)
    assert receiver.has_arrived()
    assert [each.time for each in receiver.scans()] == [0.0, 1.0, 2.0, 3.0]
    assert receiver.has_arrived()
