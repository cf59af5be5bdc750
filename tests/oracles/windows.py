"""Small random windows, as the tree and as the oracle see them."""

import numpy as np
from scipy.stats import chi2

from oracles.sequences import Hiding, Known, Look, Rules
from trackweave.association.growth_limits import GrowthLimits
from trackweave.association.tree import AssociationTree
from trackweave.association.window_rule import GATE_PROBABILITY, Context, scan_input, window_rule
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import TrackTable
from trackweave.models.coverage import FieldOfView
from trackweave.models.motion import ConstantVelocity
from trackweave.models.sensors import Sensor
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.scan_preparation import begun

WIDE = GrowthLimits(
    margin=1e9, keep=10**9, new_margin=1e9, new_keep=10**9, new_ceiling=1e9, max_nodes=10**6
)
SURVIVAL = 0.999
# Objects hide often here, so that it shows.
LIFE = Lifecycle(hidden_share=0.3, mean_silence=4.0)
GATES = {dim: float(chi2.ppf(GATE_PROBABILITY, dim)) for dim in (2, 3)}
MOTION = ConstantVelocity(process_noise=0.5, max_speed=30.0)


class Windows:
    """A window of few scans and reports: build the tree with ``tree``, the looks are there."""

    def __init__(
        self,
        seed,
        *,
        dim=2,
        n_known=0,
        views=False,
        max_misses=np.inf,
        times=None,
        heard=False,
        lost=False,
    ):
        rng = np.random.default_rng(seed)
        self.dim = dim
        self.lifecycle = (SURVIVAL, np.inf, max_misses, np.inf, np.inf)
        self.rules = Rules(
            MOTION.process_noise, MOTION.velocity_variance(dim), MOTION.max_speed,
            GATES[dim], SURVIVAL, max_misses,
        )  # fmt: skip
        n_sensors = int(rng.integers(1, 4))
        self.sensors = [
            Sensor(
                name=str(number),
                sigma=float(rng.uniform(5.0, 20.0)),
                detection_probability=float(rng.uniform(0.5, 0.95)),
                clutter_density=float(10.0 ** rng.uniform(-6, -4)) / 100.0 ** (dim - 2),
                field_of_view=_view(rng) if views else None,
                scan_period=None if heard else 1.0,
                scans=False if heard else None,
                hidden_share=float(rng.uniform(0.1, 0.5)) if lost else 0.0,
                mean_silence=3.0,
            )
            for number in range(n_sensors)
        ]
        shares = np.array([sensor.hidden_share for sensor in self.sensors if lost])
        self.rule = window_rule(MOTION, self.lifecycle, dim)._replace(unseen=shares)
        self.times = times or [float(t) for t in np.cumsum(rng.choice([0.0, 1.0, 2.5], size=3))]
        self.log_density = float(np.log(1e-5))
        self.known = [self._known(rng) for _ in range(n_known)]
        self.looks = [self._look(rng, time) for time in self.times]

    def _known(self, rng):
        root = rng.normal(size=(2 * self.dim, 2 * self.dim + 1))
        root *= np.repeat([8.0, 3.0], self.dim)[:, None]
        mean = np.concatenate([rng.normal(size=self.dim) * 20.0, rng.normal(size=self.dim) * 5.0])
        return Known(mean, root @ root.T, self.times[0] - 1.0)

    def _look(self, rng, time):
        sensor = self.sensors[rng.integers(len(self.sensors))]
        count = int(rng.integers(0, 4))
        positions = rng.normal(size=(count, self.dim)) * 30.0
        sigmas = np.tile(sensor.sigmas(self.dim), (count, 1))
        own = rng.random(count) < 0.3
        sigmas[own] = rng.uniform(3.0, 40.0, size=(int(own.sum()), self.dim))
        last = getattr(self, "_last", None)
        self._last = time
        waited = 0.0 if last is None else time - last
        living, hiding = -np.log(SURVIVAL) * waited, Hiding(*LIFE.hiding(waited))
        return Look(time, sensor, positions, sigmas, self.log_density, living, hiding)

    def inputs(self):
        """Return what ``grow`` takes of each look, and which report each slot is."""
        inputs, reports, slot, before = [], [], 0, None
        for place, look in enumerate(self.looks):
            scan = Scan(look.time, look.sensor.name, look.positions, look.sigmas)
            number = self.sensors.index(look.sensor)
            column = number if self.rule.unseen.size else -1
            context = Context(MOTION, self.dim, sensor=number, column=column)
            data, order = scan_input(scan, look.sensor, look.survival_cost, context)
            data = data._replace(
                slot=slot + np.arange(len(order)),
                new_instant=look.time != before,
                hiding=look.hiding.hiding,
                showing=look.hiding.showing,
            )
            inputs.append(data)
            reports += [(place, int(index)) for index in order]
            slot, before = slot + len(order), look.time
        return inputs, reports

    def beginning(self):
        """Return the known tracks as they enter a tree."""
        count, size = len(self.known), 2 * self.dim
        return begun(
            TrackTable(
                time=np.array([known.time for known in self.known]),
                track=np.arange(100, 100 + count),
                status=np.ones(count, dtype=np.int64),
                mean=np.array([known.mean for known in self.known]).reshape(count, size),
                covariance=np.array([known.covariance for known in self.known]).reshape(
                    count, size, size
                ),
                score=np.zeros(count),
                hits=np.ones(count, dtype=np.int64),
                last_update=np.zeros(count),
            ),
            self.rule,
        )

    def tree(self, limits=WIDE):
        """Return the tree grown by every look."""
        tree = AssociationTree(self.rule, limits)
        tree.add_tracks(self.beginning())
        for data in self.inputs()[0]:
            tree.grow(data, np.full(data.position.shape[0], self.log_density))
        return tree

    def key(self, tree, node):
        """Return the sequence of a node as the oracle names it."""
        _, reports = self.inputs()
        choice = [None] * len(self.looks)
        track = int(tree.track[tree.nodes.family[node]])
        while node >= 0:
            slot = tree.nodes.report[node]
            if slot >= 0:
                place, index = reports[slot]
                choice[place] = index
            node = tree.nodes.parent[node]
        return (track - 100 if track >= 0 else None), tuple(choice)


def _view(rng):
    """Return a field of view whose edge passes through the scene."""
    azimuth = float(rng.uniform(0, 360))
    angle = np.radians(azimuth)
    position = (-1000.0 * float(np.sin(angle)), -1000.0 * float(np.cos(angle)))
    if rng.random() < 0.5:
        return FieldOfView(position=position, max_range=1000.0 + float(rng.normal() * 20.0))
    return FieldOfView(position=position, azimuth_deg=(azimuth - 90.0, azimuth + 1.0))
