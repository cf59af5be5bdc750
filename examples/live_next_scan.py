"""Track live: the arrival of the next scan ends the search of the last.

    python examples/live_next_scan.py

A receiver that is played by the clock has a scan every 150 ms, sooner than the search would end
by itself. The tracker asks every few milliseconds whether one has arrived, and then answers with
the best hypothesis so far and how far from the best possible it may be. A deadline would be a
guess of when the next scan comes; this is no guess. Where a thread or a process receives, ask its
queue: ``stop=lambda: not arrivals.empty()``.
"""

import argparse
import time
from collections.abc import Callable, Iterator, Sequence

import numpy as np

import trackweave as tw

AREA, OBJECTS, FALSE_ALARMS = 1_000.0, 30, 60


class Receiver:
    """Has a scan every so many seconds; what nobody takes waits."""

    def __init__(self, scans: Sequence[tw.Scan], every: float) -> None:
        begun = time.perf_counter()
        self._due = [(begun + number * every, scan) for number, scan in enumerate(scans)]
        self._end = begun + len(self._due) * every

    def has_arrived(self) -> bool:
        """Tell whether a scan waits, or there are no more."""
        return time.perf_counter() >= (self._due[0][0] if self._due else self._end)

    def scans(self) -> Iterator[tw.Scan]:
        """Yield each scan once it is there."""
        while self._due:
            due, scan = self._due.pop(0)
            time.sleep(max(0.0, due - time.perf_counter()))
            yield scan


def crowd(n_scans: int, rng: np.random.Generator) -> Iterator[tw.Scan]:
    """Yield scans of objects that cross, among false alarms."""
    place = rng.uniform(0.0, AREA, (OBJECTS, 2))
    velocity = rng.uniform(-15.0, 15.0, (OBJECTS, 2))
    for number in range(n_scans):
        seen = (place + number * velocity)[rng.random(OBJECTS) < 0.9]
        false = rng.uniform(0.0, AREA, (rng.poisson(FALSE_ALARMS), 2))
        reports = np.concatenate([seen + rng.normal(0.0, 10.0, seen.shape), false])
        yield tw.Scan(time=float(number), sensor="radar", measurement=reports)


def a_tracker() -> tw.MultiHypothesisTracker:
    """Return a tracker whose search would go on for minutes."""
    return tw.MultiHypothesisTracker(
        motion=tw.ConstantVelocity(process_noise=0.05, max_speed=30.0),
        sensors=[
            tw.Sensor(
                "radar",
                sigma=10.0,
                detection_probability=0.9,
                clutter_density=FALSE_ALARMS / AREA**2,
                scan_period=1.0,
            )
        ],
        lifecycle=tw.Lifecycle(new_target_density=1e-6, initial_target_density=3e-5),
        search=tw.Annealing(evaluations=10**9, patience=10**9, seeded=False),
    )


def follow(receiver: Receiver, tell: Callable[[str], None]) -> list[tw.Hypothesis]:
    """Track what arrives until there is no more; each search ends when the next scan is there."""
    tracker, rng = a_tracker(), np.random.default_rng(1)
    hypotheses = []
    for scan in receiver.scans():
        begun = time.perf_counter()
        found = tracker.step(scan, rng=rng, stop=receiver.has_arrived)
        hypotheses.append(found)
        tell(
            f"scan at {scan.time:2.0f} s: {len(found.tracks):2d} tracks, {said(found)} after "
            f"{time.perf_counter() - begun:.2f} s, gap {found.certificate.gap:.3f}"
        )
    return hypotheses


def said(hypothesis: tw.Hypothesis) -> str:
    """Return what ended a search."""
    if hypothesis.stop_reason == "stopped":
        return "stopped by the next scan"
    return f"ended by itself ({hypothesis.stop_reason})"


def warm_up(scans: list[tw.Scan]) -> None:
    """Compile or load all kernels, which no scan should wait for."""
    tracker, rng = a_tracker(), np.random.default_rng(1)
    for scan in scans:
        tracker.step(scan, rng=rng, deadline=0.05)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--scans", type=int, default=12, help="how many (12)")
    parser.add_argument("--every", type=float, default=0.15, help="seconds between them (0.15)")
    arguments = parser.parse_args()
    scans = list(crowd(arguments.scans, np.random.default_rng(5)))
    warm_up(scans)
    follow(Receiver(scans, arguments.every), print)


if __name__ == "__main__":
    main()
