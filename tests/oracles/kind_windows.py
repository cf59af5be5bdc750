"""Small random windows of any sensors and motions, as the tree and as the oracle see them."""

import numpy as np

from oracles import sensing
from oracles.kinds import GATE, Mixture, Setting, View, locates
from oracles.sequences import Hiding
from oracles.windows import LIFE, SURVIVAL, WIDE
from trackweave.association._rhythm import SIZE as RHYTHM_SIZE
from trackweave.association.initial_tracks import InitialTracks
from trackweave.association.tree import AssociationTree
from trackweave.association.window_rule import GATE_PROBABILITY, Context, scan_input, window_rule
from trackweave.domain.measurements import MeasurementKind as Kind
from trackweave.domain.scans import Scan
from trackweave.models.sensors import Sensor

assert GATE == GATE_PROBABILITY
LOG_DENSITY = float(np.log(1e-7))


class KindWindow:
    """Scans of two moving objects by the given sensors in turn, with false alarms beside."""

    def __init__(self, seed, motion, sensors, *, dim=2, times=(0.0, 4.0, 4.0, 9.0), **options):
        self.rng = np.random.default_rng(seed)
        self.motion, self.sensors, self.dim = motion, sensors, dim
        self.options = {
            "unscented": False, "widths": {}, "moving": False, "turning": 0.0, "n_known": 0,
            "n_false": 1, "names": (), "max_misses": np.inf, "heights": (),
        } | options  # fmt: skip
        lifecycle = (SURVIVAL, np.inf, self.options["max_misses"], np.inf, np.inf)
        self.rule = window_rule(
            motion, lifecycle, dim, unscented=self.options["unscented"], crossing_time=4.0
        )
        self.setting = Setting(
            self.rule.motion, SURVIVAL, self.options["max_misses"],
            n_identities=max(1, len(self.options["names"])),
        )  # fmt: skip
        self.start = np.concatenate(
            [self.rng.uniform(2000.0, 4000.0, (2, dim)), self.rng.normal(0, 40.0, (2, dim))], 1
        )
        self.views, last = [], None
        for place, time in enumerate(times):
            sensor = sensors[place % len(sensors)]
            waited = 0.0 if last is None else time - last
            self.views.append(self._view(time, sensor, waited))
            last = time
        self.known = [self._known(times[0] - 2.0) for _ in range(self.options["n_known"])]

    def _known(self, time):
        modes, size = self.rule.motion.kind.size, self.rule.motion.prior.size
        spread = np.sqrt(self.rule.motion.prior)
        spread[: self.dim] = 60.0
        mean = self.rng.normal(0, 0.3, (modes, size)) * spread
        mean[:, : 2 * self.dim] += self.start[0]
        root = self.rng.normal(0, 0.3, (modes, size, size + 2)) * spread[:, None]
        weight = self.rng.dirichlet(np.ones(modes))
        return Mixture(mean, root @ root.transpose(0, 2, 1), weight), time

    def _view(self, time, sensor, waited):
        survival_cost, hiding = -np.log(SURVIVAL) * waited, Hiding(*LIFE.hiding(waited))
        rng, dim, turning = self.rng, self.dim, self.options["turning"]
        width = self.options["widths"].get(sensor.name, sensor.measurement.n_components(dim))
        count = 2 + self.options["n_false"]
        moments = time - rng.uniform(0, turning, count) if turning else np.full(count, time)
        platform = np.tile(sensor.platform, (count, 1))
        if self.options["moving"]:
            platform += rng.normal(0, [300.0] * 3 + [30.0] * 3, (count, 6))
        sigma = np.tile(sensor.sigmas(dim)[:width], (count, 1))
        own = rng.random(count) < 0.3
        sigma[own] *= rng.uniform(0.5, 2.0, (int(own.sum()), 1))
        rows = []
        for index in range(count):
            true = self.start[min(index, 1)].copy()
            true[:dim] += true[dim:] * moments[index] + (250.0 if index > 1 else 0.0)
            exact = sensing.expected(sensor.measurement, true, platform[index], dim)[:width]
            rows.append(exact + rng.normal(0, sigma[index]))
            if sensor.tail_share > 0.0 and rng.random() < 0.5:
                rows[-1] = exact + rng.normal(0, sensor.tail_scale * sigma[index])
        measurement = np.array(rows)
        if sensor.measurement is not Kind.POSITION:
            angle = 0 if sensor.measurement is Kind.BEARING else 1
            measurement[:, angle] %= 2 * np.pi
        seen = rng.random(count) < 0.85
        names, heights = self.options["names"], self.options["heights"]
        scan = Scan(
            time, sensor.name, measurement[seen], np.where(own[:, None], sigma, np.nan)[seen],
            moments=moments[seen] if turning else None,
            platform=platform[seen] if self.options["moving"] else None,
            identity=rng.choice([-1, *names], count)[seen] if names else None,
            strength=rng.normal(10.0, 6.0, count)[seen] if sensor.strength else None,
            height=rng.choice(heights, count)[seen] if heights else None,
        )  # fmt: skip
        apart = 0.5 if sensor.rotation is not None else 0.05
        separation = apart * sensor.scan_period if turning else 0.0
        reference = time - turning / 2 if turning else None
        return View(scan, sensor, LOG_DENSITY, survival_cost, reference, separation, hiding)

    def inputs(self):
        """Return what ``grow`` takes of each view, and which report each slot is."""
        inputs, reports, slot, before = [], [], 0, None
        for place, view in enumerate(self.views):
            time, turning = view.scan.time, self.options["turning"]
            context = Context(
                self.motion, self.dim, self.sensors.index(view.sensor),
                n_identities=self.setting.n_identities, start=time - turning if turning else None,
            )  # fmt: skip
            data, order = scan_input(view.scan, view.sensor, view.survival_cost, context)
            numbers = slot + np.arange(len(order))
            data = data._replace(hiding=view.hiding.hiding, showing=view.hiding.showing)
            inputs.append(data._replace(slot=numbers, new_instant=time != before))
            reports += [(place, int(index)) for index in order]
            slot, before = slot + len(order), time
        return inputs, reports

    def tree(self, limits=WIDE):
        """Return the tree grown by every view."""
        tree = AssociationTree(self.rule, limits)
        tree.add_tracks(self.initial())
        for data in self.inputs()[0]:
            tree.grow(data, np.full(data.measurement.shape[0], LOG_DENSITY))
        return tree

    def initial(self):
        """Return the known tracks as they enter a tree."""
        count, zero = len(self.known), np.zeros(len(self.known))
        nobody = np.full(count, -1)
        modes, size = self.rule.motion.kind.size, self.rule.motion.prior.size
        states = [state for state, _ in self.known]
        return InitialTracks(
            track=100 + np.arange(count),
            time=np.array([time for _, time in self.known]),
            mean=np.array([s.mean for s in states]).reshape(count, modes, size),
            covariance=np.array([s.covariance for s in states]).reshape(count, modes, size, size),
            weight=np.array([s.weight for s in states]).reshape(count, modes),
            hits=np.ones(count, dtype=np.int64),
            chances=zero, tail=zero, hidden=zero, misses=zero,
            rhythm=np.full((count, RHYTHM_SIZE), -1.0),
            wild=np.full(count, -1.0), level=np.full((count, 6), np.nan),
            identity=nobody, other=nobody,
            sensor=nobody,
            is_line=np.zeros(count, dtype=np.int64), slot=nobody, unseen=np.empty((count, 0)),
        )  # fmt: skip

    def sequences(self, tree):
        """Return the nodes that stand for objects with a place, as the oracle names them."""
        _, reports = self.inputs()
        found = {}
        for node in range(tree.n_nodes):
            choice, climb, root = [None] * len(self.views), node, node
            while climb >= 0:
                slot, root = tree.nodes.report[climb], climb
                if slot >= 0:
                    choice[reports[slot][0]] = reports[slot][1]
                climb = tree.nodes.parent[climb]
            slot = tree.nodes.report[root]
            if slot >= 0 and not locates(self.views[reports[slot][0]], self.dim):
                continue
            track = int(tree.track[tree.nodes.family[node]])
            key = (track - 100 if track >= 0 else None), tuple(choice)
            assert key not in found
            found[key] = node
        return found


def radar(name="radar", kind=Kind.RANGE_AZIMUTH, **changed):
    """Return a sensor of ordinary quality of a kind."""
    sigma = {
        Kind.POSITION: 40.0,
        Kind.RANGE_AZIMUTH: (30.0, 0.01),
        Kind.RANGE_AZIMUTH_RATE: (30.0, 0.01, 2.0),
        Kind.RANGE_AZIMUTH_ELEVATION: (30.0, 0.01, 0.015),
        Kind.RANGE_AZIMUTH_ELEVATION_RATE: (30.0, 0.01, 0.015, 2.0),
        Kind.BEARING: 0.01,
    }[kind]
    unit = {Kind.POSITION: 1e-7, Kind.BEARING: 1.0}.get(kind, 1e-4)
    values = {
        "name": name, "sigma": sigma, "detection_probability": 0.8, "clutter_density": unit,
        "scan_period": 4.0, "measurement": kind, "position": (500.0, -300.0, 20.0),
    }  # fmt: skip
    return Sensor(**(values | changed))
