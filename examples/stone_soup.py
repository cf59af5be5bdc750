"""Stone Soup: its simulated detections, our tracker, its metric.

pip install 'trackweave[stonesoup]'
python examples/stone_soup.py
"""

from datetime import datetime, timedelta

import numpy as np
from stonesoup.metricgenerator.ospametric import GOSPAMetric
from stonesoup.models.measurement.linear import LinearGaussian
from stonesoup.types.detection import Detection, TrueDetection
from stonesoup.types.groundtruth import GroundTruthPath, GroundTruthState

from trackweave import track
from trackweave.adapters.stonesoup import reports_of, tracks_of

BEGIN, N_STEPS = datetime(2024, 5, 1, 12), 40
MODEL = LinearGaussian(4, (0, 2), np.diag([4.0, 4.0]))


def scene(rng: np.random.Generator) -> tuple[set[GroundTruthPath], list[Detection]]:
    """Return two objects that cross, and what is seen of them among false alarms."""
    paths = [GroundTruthPath() for _ in range(2)]
    seen = []
    for step in range(N_STEPS):
        time = BEGIN + timedelta(seconds=step)
        for path, sense in zip(paths, (1.0, -1.0), strict=True):
            state = [10.0 * step, 10.0, sense * (100.0 - 5.0 * step), -5.0 * sense]
            path.append(GroundTruthState(state, timestamp=time))
            if rng.random() < 0.95:
                place = MODEL.function(path[-1], noise=rng.normal(0.0, 2.0, (2, 1)))
                found = {"timestamp": time, "measurement_model": MODEL}
                seen.append(TrueDetection(place, groundtruth_path=path, **found))
        for place in rng.uniform((0.0, -150.0), (400.0, 150.0), (2, 2)):
            seen.append(Detection(place, timestamp=time, measurement_model=MODEL))
    return set(paths), seen


def main() -> None:
    truths, seen = scene(np.random.default_rng(1))
    tracks = tracks_of(track(reports_of(seen)), seen)
    metric = GOSPAMetric(p=2.0, c=20.0)
    ours, true = metric.extract_states(tracks, True), metric.extract_states(truths, True)
    found = metric.compute_over_time(*ours, *true)
    worst = max(each.value["distance"] for each in found.value)
    print(f"{len(tracks)} tracks; GOSPA at most {worst:.1f} m")


if __name__ == "__main__":
    main()
