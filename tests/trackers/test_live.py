"""Steps whole or not at all, copies that share nothing, numbers that serve once."""

import copy
import pickle

import numpy as np
import pytest

from oracles.scenes import MOTION, run, scan, scene, sensor
from trackweave.association import inactive
from trackweave.association.inactive import InactiveClusters
from trackweave.association.plots_rule import PlotsRule
from trackweave.association.tree import AssociationTree
from trackweave.errors import InvalidInputError
from trackweave.models.coverage import FieldOfView
from trackweave.solvers import Exact
from trackweave.trackers import multi_hypothesis
from trackweave.trackers.clock_guard import ClockGuard
from trackweave.trackers.fixed_history import FixedHistory
from trackweave.trackers.fused_plots import FusedPlotsTracker
from trackweave.trackers.live import UNDONE
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker
from trackweave.trackers.nearest_neighbour import NearestNeighbourTracker
from trackweave.trackers.pacing import Pace
from trackweave.trackers.plot_fusion import PlotFuser
from trackweave.trackers.report_index import ReportIndex
from trackweave.trackers.scan_preparation import ScanPreparation
from trackweave.trackers.single_hypothesis import SingleHypothesisManager
from trackweave.trackers.track_manager import TrackManager
from trackweave.trackers.undetected import Undetected
from trackweave.trackers.used_numbers import UsedNumbers
from trackweave.trackers.window import OpenScans

NAMES = ("a", "b")
HALVES = {"a": FieldOfView(azimuth_deg=(0.0, 45.0)), "b": FieldOfView(azimuth_deg=(45.0, 90.0))}


class Drawing:
    """A solver that uses randomness."""

    def __call__(self, problem, *, rng, **options):
        rng.random()
        return Exact()(problem, rng=rng, **options)


def halves(**changed):
    """Return a tracker of two sensors that see different places."""
    sensors = [sensor(name, field_of_view=HALVES[name]) for name in NAMES]
    options = {"motion": MOTION, "sensors": sensors, "window": 3, "search": Drawing()}
    return MultiHypothesisTracker(**(options | changed))


def nearest():
    sensors = [sensor(name, field_of_view=HALVES[name]) for name in NAMES]
    return NearestNeighbourTracker(motion=MOTION, sensors=sensors)


def fused(inside=MultiHypothesisTracker):
    rule = PlotsRule(object_density=1e-6, negative_only=True, lone_plots=True)
    fuser = PlotFuser([sensor(name) for name in NAMES], rule, Drawing(), motion=MOTION)
    return FusedPlotsTracker(fuser, inside(motion=MOTION, sensors=fuser.fused_sensors(1.0)))


def scans_of(seed=5):
    """Return scans of which one comes late, and one in two parts."""
    scans = scene(seed, objects=5, times=range(8), names=NAMES)
    whole = scans.pop(13)
    halves = [
        scan(whole.time, whole.measurement[part], whole.sensor, whole.report[part])
        for part in (slice(0, 2), slice(2, None))
    ]
    return [*scans[:9], *scans[10:12], scans[9], *scans[12:13], *halves, *scans[13:]]


def instants_of(seed=5):
    scans = scene(seed, objects=4, times=range(8), names=NAMES)
    return [scans[k : k + 2] for k in range(0, len(scans), 2)]


def told(hypothesis):
    """Return all that a hypothesis says, but for what depends on the clock."""
    tracks, final = hypothesis.tracks, hypothesis.final
    return (
        hypothesis.time, tracks.track.tolist(), tracks.status.tolist(), tracks.mean.tobytes(),
        tracks.covariance.tobytes(), tracks.score.tobytes(), tracks.hits.tolist(),
        hypothesis.amendments, final.report.tolist(), final.track.tolist(),
        final.probability.tobytes(), hypothesis.late, hypothesis.held, hypothesis.set_aside,
        hypothesis.certificate, hypothesis.n_sequences, hypothesis.n_pruned,
    )  # fmt: skip


@pytest.fixture
def makes_inactive(monkeypatch):
    monkeypatch.setattr(inactive, "LITTLE", 1)


STAGES = {
    "multi-hypothesis": [
        (UsedNumbers, "add"), (ClockGuard, "judge"), (FixedHistory, "close"), (OpenScans, "close"),
        (ReportIndex, "assignments"), (ScanPreparation, "open"), (OpenScans, "insert"),
        (OpenScans, "remove"),
        (InactiveClusters, "exchange"), (InactiveClusters, "_deactivate"),
        (InactiveClusters, "_take"), (InactiveClusters, "_tidy"),
        (InactiveClusters, "bring_back"), (TrackManager, "fix"), (AssociationTree, "fix"),
        (AssociationTree, "_begin_at"), (AssociationTree, "_forget_empty_families"),
        (Undetected, "look"), (ReportIndex, "add"), (ReportIndex, "relay"),
        (FixedHistory, "initial_tracks"), (AssociationTree, "grow"), (AssociationTree, "_propose"),
        (AssociationTree, "_append_roots"), (AssociationTree, "_compact"),
        (AssociationTree, "take_in"), (AssociationTree, "problem"), (Drawing, "__call__"),
        (multi_hypothesis, "believe"), (TrackManager, "update"), (TrackManager, "_confirm"),
        (multi_hypothesis, "live_rows"), (Pace, "done"),
    ],
    "nearest-neighbour": [
        (UsedNumbers, "add"), (ClockGuard, "judge"), (ScanPreparation, "open"),
        (Undetected, "look"),
        (AssociationTree, "grow"), (AssociationTree, "_propose"), (AssociationTree, "fix"),
        (SingleHypothesisManager, "enter"), (SingleHypothesisManager, "hit"),
        (SingleHypothesisManager, "keep"), (SingleHypothesisManager, "rows"),
    ],
    "fused": [
        (UsedNumbers, "add"), (Drawing, "__call__"), (PlotFuser, "__call__"),
        (TrackManager, "fix"),
        (AssociationTree, "grow"), (MultiHypothesisTracker, "take"),
        (FusedPlotsTracker, "_told"), (FusedPlotsTracker, "_with_hits"),
    ],
}  # fmt: skip
MAKERS = {"multi-hypothesis": halves, "nearest-neighbour": nearest, "fused": fused}
CASES = [(kind, *stage) for kind, stages in STAGES.items() for stage in stages]


def breaking(monkeypatch, owner, name):
    """Let a stage break once whenever it is told to, before its work and after by turns."""
    real, state = getattr(owner, name), {"armed": False, "broken": 0}

    def stage(*given, **options):
        comes_first = state["broken"] % 2 == 0
        if state["armed"] and comes_first:
            state.update(armed=False, broken=state["broken"] + 1)
            raise KeyboardInterrupt
        found = real(*given, **options)
        if state["armed"]:
            state.update(armed=False, broken=state["broken"] + 1)
            raise RuntimeError("broken")
        return found

    monkeypatch.setattr(owner, name, stage)
    return state


@pytest.mark.parametrize(
    ("kind", "owner", "name"), CASES, ids=[f"{k}-{o.__name__}.{n}" for k, o, n in CASES]
)
def test_a_step_that_breaks_anywhere_never_was(monkeypatch, makes_inactive, kind, owner, name):
    given = instants_of() if kind == "fused" else scans_of()
    expected = [told(each) for each in run(MAKERS[kind](), given)]
    state = breaking(monkeypatch, owner, name)
    target, rng = MAKERS[kind](), np.random.default_rng(1)
    for each, right in zip(given, expected, strict=True):
        state["armed"] = True
        try:
            found = target.step(each, rng=rng)
        except (KeyboardInterrupt, RuntimeError, InvalidInputError) as err:  # a solver's is named
            assert UNDONE in err.__notes__
            state["armed"] = False
            found = target.step(each, rng=rng)
        assert told(found) == right
    assert state["broken"] > 0


def test_a_stop_that_raises_leaves_no_trace():
    def stop():
        raise ZeroDivisionError

    target, other = halves(search=None), halves(search=None)
    rng, same = np.random.default_rng(1), np.random.default_rng(1)
    n_broken = 0
    for each in scene(2, objects=12, clutter=30, times=range(6), names=NAMES):
        try:
            first = target.step(each, rng=rng, stop=stop)
        except ZeroDivisionError:
            n_broken += 1
            first = target.step(each, rng=rng)
        assert told(first) == told(other.step(each, rng=same))
    assert n_broken > 0


COPIES = {
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    "pickle": lambda target: pickle.loads(pickle.dumps(target)),
}


@pytest.mark.parametrize("kind", MAKERS)
@pytest.mark.parametrize("way", COPIES)
def test_a_copy_and_its_original_go_their_own_ways(makes_inactive, kind, way):
    make = instants_of if kind == "fused" else scans_of
    given, others = make(5), make(6)
    rng = np.random.default_rng(1)
    target = MAKERS[kind]()
    for each in given[:4]:
        target.step(each, rng=rng)
    rngs = [copy.deepcopy(rng) for _ in range(3)]
    expected = [told(target.step(each, rng=rngs[0])) for each in given[4:]]
    original = MAKERS[kind]()
    rng = np.random.default_rng(1)
    for each in given[:4]:
        original.step(each, rng=rng)
    twin = COPIES[way](original)
    strangers = [renumbered(each) for each in others[4:]]
    found = []
    # In turn, so that whatever they share shows.
    for mine, stranger in zip(given[4:], strangers, strict=True):
        found.append(told(twin.step(mine, rng=rngs[1])))
        original.step(stranger, rng=rngs[2])
    assert found == expected


def renumbered(given):
    if isinstance(given, list):
        return [renumbered(each) for each in given]
    return scan(given.time, given.measurement, given.sensor)


def test_a_copy_shares_what_never_changes():
    target = halves()
    assert copy.copy(target)._search is target._search
    assert copy.copy(target)._motion is target._motion


@pytest.mark.parametrize("kind", ["multi-hypothesis", "nearest-neighbour"])
def test_a_number_serves_once_in_a_life(kind):
    target, scans = MAKERS[kind](), scene(1, times=range(20), names=("a",))
    run(target, scans)
    last = max(each.report.max(initial=-1) for each in scans)
    for number in (0, last // 2, last):
        with pytest.raises(InvalidInputError, match="used before"):
            run(target, [scan(20.0, [(0.0, 0.0)], "a", report=[number])])
    run(target, [scan(20.0, [(0.0, 0.0)], "a", report=[last + 1])])


def test_a_number_serves_once_in_the_life_of_fused_plots():
    target, steps = fused(), instants_of()
    run(target, steps)
    with pytest.raises(InvalidInputError, match="used before"):
        run(target, [[scan(8.0, [(0.0, 0.0)], "a", report=[0])]])
