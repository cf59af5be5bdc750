"""What sequences of any reports cost under any motion, one at a time and from the beginning."""

import math
from dataclasses import dataclass, field
from itertools import product

import numpy as np
from scipy.stats import chi2, norm

from oracles import motion, sensing
from oracles.coverage import RANGING, blur_of, share
from oracles.levels import height_cost
from oracles.naming import is_own, naming, taken
from oracles.sequences import Hiding
from trackweave.domain.measurements import MeasurementKind as Kind
from trackweave.domain.scans import Scan
from trackweave.filters import _states
from trackweave.models.motion import COORDINATED_TURN, MotionRule
from trackweave.models.sensors import Sensor

GATE = 0.9997
MOST_EVIDENCE = 8.0


@dataclass
class View:
    """A scan as the oracle sees it, with where its sensor looked and when on the whole."""

    scan: Scan
    sensor: Sensor
    log_density: float
    survival_cost: float = 0.0
    reference: float | None = None
    separation: float = 0.0
    hiding: Hiding = field(default_factory=Hiding)
    blur = blur_of

    @property
    def sees_everything(self):
        return self.sensor.field_of_view is None

    def moment(self, index):
        return self.scan.time if self.scan.moments is None else self.scan.moments[index]

    def platform(self, index):
        if self.scan.platform is None:
            return self.sensor.platform
        return np.broadcast_to(self.scan.platform, (len(self.scan), 6))[index]

    def sigma(self, index, dim):
        width = self.scan.measurement.shape[1]
        own = self.scan.sigma[index]
        return np.where(np.isnan(own), self.sensor.sigmas(dim)[:width], own)


@dataclass
class Setting:
    """What sequences may do, and how many identities are known."""

    rule: MotionRule
    survival: float
    max_misses: float = math.inf
    max_unseen: float = math.inf
    n_identities: int = 1


@dataclass
class Mixture:
    """A state by modes of motion."""

    mean: np.ndarray
    covariance: np.ndarray
    weight: np.ndarray

    def moments(self):
        return motion.combine(self.mean, self.covariance, self.weight)


@dataclass
class Price:
    """A sequence's cost up to its last report, in all, and its state then."""

    cost: float
    total: float
    state: Mixture = field(repr=False)


_KNOWN = {}


def _linear(rule, mode, interval):
    """Return F and Q of a mode, kept because they are wanted again for every sequence."""
    key = rule.dim, rule.kind.tobytes(), rule.noise.tobytes(), rule.prior.tobytes(), mode, interval
    if key not in _KNOWN:
        # On the way back noise is minus the integral of the way there.
        signed = rule if interval > 0 else rule._replace(noise=-rule.noise)
        _KNOWN[key] = motion.linear(signed, mode, interval)
    return _KNOWN[key]


def ahead(state, interval, rule):
    """Return a state after an interval, before it where that is negative."""
    if interval == 0.0:
        return state
    mean, covariance, weight = state.mean, state.covariance, state.weight
    if weight.size > 1:
        change = rule.basis[0] @ np.diag(np.exp(-rule.decay * abs(interval))) @ rule.basis[1]
        assert np.allclose(change.sum(axis=1), 1.0)
        assert change.diagonal().min() > 0.0
        mean, covariance, weight = motion.mix(mean, covariance, weight, change)
    moved, spread = np.empty_like(mean), np.empty_like(covariance)
    for mode in range(weight.size):
        if rule.kind[mode] == COORDINATED_TURN:
            # Held to its own oracle where filters are tested.
            _states.move(
                mode, mean[mode], covariance[mode], interval, rule, moved[mode], spread[mode]
            )
            continue
        moving, noise = _linear(rule, mode, interval)
        moved[mode] = moving @ mean[mode]
        spread[mode] = moving @ covariance[mode] @ moving.T + noise
    return Mixture(moved, spread, weight)


def foreseen(kind, mean, covariance, platform, rule, width):
    """Return a measurement's moments without its own noise, and the covariance with the state."""
    if kind is Kind.POSITION:
        return mean[:width], covariance[:width, :width], covariance[:, :width]
    how = sensing.by_points if rule.unscented else sensing.by_slopes
    return how(kind, mean, covariance, platform, rule.dim)


def compare(view, index, state, rule, wild):
    """Return the least squared distance, the log likelihood, the state after the report, and how
    probably its noise was wide, as ``wild`` is of the report before it; None for nothing known.
    """
    sensor = view.sensor
    share = sensor.tail_share
    if share > 0.0 and wild is not None:
        # Likely to be as it was, or else anew: a chain whose long-run share is the share.
        anew = (1 - sensor.tail_persistence) * share
        share = wild * (sensor.tail_persistence + anew) + (1 - wild) * anew
    distances, narrow, after = _joined(view, index, state, rule, 1.0)
    if share > 0.0:
        far, wide, beside = _joined(view, index, state, rule, view.sensor.tail_scale)
        distances += far
        narrow, wide = (1 - share) * narrow, share * wide
        parts = zip(narrow, wide, after, beside, strict=True)
        after = [
            motion.combine(
                *map(np.array, zip(one, other, strict=True)), np.array([n, w]) / (n + w)
            )
            for n, w, one, other in parts
        ]
        if sensor.tail_persistence > 0.0:
            wild = wide.sum() / (narrow.sum() + wide.sum())
        narrow = narrow + wide
    means, covariances = map(np.array, zip(*after, strict=True))
    total = narrow.sum()
    return min(distances), math.log(total), Mixture(means, covariances, narrow / total), wild


def _joined(view, index, state, rule, scale):
    """Return each mode's distance, density with its share, and state after the report."""
    kind, measurement = view.sensor.measurement, view.scan.measurement[index]
    noise = np.diag((scale * view.sigma(index, rule.dim)) ** 2)
    distances, logs, after = [], [], []
    for mean, covariance in zip(state.mean, state.covariance, strict=True):
        expected, spread, cross = foreseen(
            kind, mean, covariance, view.platform(index), rule, measurement.size
        )
        spread = spread + noise
        off = sensing.difference(kind, measurement, expected)
        gain = cross @ np.linalg.inv(spread)
        distances.append(off @ np.linalg.solve(spread, off))
        logs.append(-0.5 * (distances[-1] + np.linalg.slogdet(2 * np.pi * spread)[1]))
        corrected = mean + gain @ off, covariance - gain @ spread @ gain.T
        if kind.value in RANGING and not rule.unscented:
            where = view.platform(index), rule.dim
            corrected = _iterated(kind, measurement, noise, where, (mean, covariance), corrected)
        after.append(corrected)
    return distances, state.weight * np.exp(logs), after


def _iterated(kind, measurement, noise, where, before, corrected):
    """Return the state that a report leads to, slopes taken where it leads if that is far."""
    (platform, dim), (mean, covariance), (here, _) = where, before, corrected
    reach = measurement[0]
    bend = reach * min(noise[0, 0] ** 0.5, reach * noise[1, 1] ** 0.5)
    if not bend < np.sum((here - mean)[:dim] ** 2) < reach**2:
        return corrected
    for _ in range(5):
        expected, _, slope = sensing.by_slopes(kind, here, np.eye(mean.size), platform, dim)
        cross = covariance @ slope
        gain = cross @ np.linalg.inv(slope.T @ cross + noise)
        off = sensing.difference(kind, measurement, expected) - (mean - here) @ slope
        last, here = here, mean + gain @ off
        if np.sum((here - last)[:dim] ** 2) <= bend:
            return here, covariance - gain @ cross.T
    return corrected


def place(view, index, dim):
    """Return where a report puts its object, how uncertain that is, and the ln |∂x/∂z|."""
    measurement, sigma = view.scan.measurement[index], view.sigma(index, dim)
    if view.sensor.measurement is Kind.POSITION:
        return measurement, np.diag(sigma**2), 0.0
    distance, azimuth = measurement[:2]
    upward = measurement[2] if dim == 3 else 0.0
    over = sigma[2] if dim == 3 else 0.0
    east, north, level, up = np.sin(azimuth), np.cos(azimuth), np.cos(upward), np.sin(upward)
    axes = np.array(
        [
            [level * east, level * north, up],
            [north, -east, 0.0],
            [-up * east, -up * north, level],
        ]
    )
    spread = np.diag([sigma[0], distance * sigma[1] * level, distance * over]) ** 2
    bent = math.exp(over**2 / 2) * np.exp(np.array([sigma[1], sigma[1], 0.0]) ** 2 / 2)
    position = view.platform(index)[:3] + distance * bent * axes[0]
    covariance = axes.T @ spread @ axes
    volume = distance if dim == 2 else distance**2 * level
    return position[:dim], covariance[:dim, :dim], math.log(volume)


def begin(view, index, rule):
    """Return what a new object costs and its state."""
    sensor, dim = view.sensor, rule.dim
    position, covariance, log_volume = place(view, index, dim)
    mean, spread = np.zeros(rule.prior.size), np.diag(rule.prior)
    mean[:dim], spread[:dim, :dim] = position, covariance
    cost = math.log(sensor.clutter_density / sensor.detection_probability)
    cost -= view.log_density + log_volume
    if sensor.measurement.has_rate:
        rate, sigma = view.scan.measurement[index, -1], view.sigma(index, dim)[-1]
        carried = view.platform(index)
        azimuth, upward = view.scan.measurement[index, 1], 0.0
        if dim == 3:
            upward = view.scan.measurement[index, 2]
        level = np.cos(upward)
        toward = np.array([level * np.sin(azimuth), level * np.cos(azimuth), np.sin(upward)])[:dim]
        # How fast it would come if it stood still.
        drift = -toward @ carried[3 : 3 + dim]
        deviation = math.sqrt(rule.prior[dim] + sigma**2)
        cost -= norm.logpdf(rate, drift, deviation)
        expected, own, cross = sensing.by_slopes(Kind.RANGE_RATE, mean, spread, carried, dim)
        own = own + sigma**2
        gain = cross @ np.linalg.inv(own)
        mean, spread = mean + gain @ (rate - expected), spread - gain @ own @ gain.T
    modes = rule.kind.size
    return cost, Mixture(np.array([mean] * modes), np.array([spread] * modes), rule.share)


def evidence(view, index):
    """Return what a report's strength says [nats]."""
    model, strength = view.sensor.strength, view.scan.strength
    if model is None or strength is None or np.isnan(strength[index]):
        return 0.0
    ratio = norm.logpdf(strength[index], model.target_mean, model.target_sigma)
    ratio -= norm.logpdf(strength[index], model.clutter_mean, model.clutter_sigma)
    return float(np.clip(ratio, -MOST_EVIDENCE, MOST_EVIDENCE))


def leap(view, index, known, rule):
    """Return how likely a report is of an object that moves as none of its models, and its state.

    One in a hundred is anywhere as far as its speed lets it come, one in 10⁴ as far as it is.
    """
    (state, time), dim = known, rule.dim
    off = np.linalg.norm(place(view, index, dim)[0] - state.mean[0, :dim])
    reach = rule.max_speed * abs(view.moment(index) - time)
    radius, share = max(off, reach), 0.01 if off <= reach else 1e-4
    volume = math.pi * radius**2 if dim == 2 else 4 / 3 * math.pi * radius**3
    cost, begun = begin(view, index, rule)
    log_volume = math.log(view.sensor.clutter_density / view.sensor.detection_probability)
    log_volume -= cost + view.log_density
    return math.log(share / volume) + log_volume, begun


def covered(view, state, rule, since):
    """Return how probable it is that a scan covers where the object is."""
    if view.sees_everything:
        return 1.0
    reference = view.scan.time if view.reference is None else view.reference
    there = ahead(state, reference - since, rule)
    parts = [share(view, m, p) for m, p in zip(there.mean, there.covariance, strict=True)]
    return float(there.weight @ parts)


def price(views, choice, setting, known=None):
    """Return what a sequence costs, None if it breaks a rule; as ``sequences.score`` does."""
    rule, dim = setting.rule, setting.rule.dim
    cost = living = misses = 0.0
    sight, hidden = 1.0, 0.0
    state = time = counted = wild = None
    said, heights, seen_by = [], [], {}
    given_up = False
    if known is not None:
        state, time = known
    for view, index in zip(views, choice, strict=True):
        sensor, now = view.sensor, view.scan.time
        if state is None:
            if index is None:
                continue
            cost, state = begin(view, index, rule)
            cost += taken(views, view, index) - evidence(view, index)
        else:
            seen = sensor.detection_probability * covered(view, state, rule, time)
            living += view.survival_cost
            sight, hidden = view.hiding.moved(sight, hidden)
            if index is None:
                sight *= 1 - seen
                before = counted[1] if counted and counted[0] == now else 0.0
                chance = max(0.0, seen / sensor.detection_probability - before)
                counted = (now, before + chance)
                misses += chance
                given_up |= misses >= setting.max_misses or now - time > setting.max_unseen
                continue
            moment = view.moment(index)
            if given_up or seen == 0.0:
                return None
            if abs(moment - seen_by.get(sensor.name, -math.inf)) < view.separation:
                return None
            followed = follow(view, index, (state, time, wild), said, rule)
            if followed is None:
                return None
            log_likelihood, after, wild = followed
            cost += living + math.log(sensor.clutter_density / (seen * sight))
            cost -= log_likelihood + evidence(view, index)
            cost += naming(view, index, said, setting.n_identities)
            cost += height_cost((view, index), heights)
            state = after
        living = misses = 0.0
        sight, hidden = 1.0, 0.0
        time, counted = view.moment(index), (now, 1.0)
        seen_by[sensor.name] = time
        if view.scan.identity is not None and view.scan.identity[index] >= 0:
            said.append(int(view.scan.identity[index]))
        heights.append((view, index))
    assert state.mean.shape[1] >= 2 * dim
    end = -math.log(1 - setting.survival)
    tail = living - math.log(sight + hidden)
    return Price(cost, cost + (end if given_up else min(tail, end)), state)


def follow(view, index, known, said, rule):
    """Return a report's log likelihood, the state after it and whether it is wild; or None."""
    state, time, wild = known
    if _reaches(view, index, state, time, rule):
        there = ahead(state, view.moment(index) - time, rule)
        distance, log_likelihood, after, tail = compare(view, index, there, rule, wild)
        if distance <= chi2.ppf(GATE, view.scan.measurement.shape[1]):
            return log_likelihood, after, tail
    if locates(view, rule.dim) and is_own(view, index, said):
        return *leap(view, index, (state, time), rule), wild
    return None


def _reaches(view, index, state, time, rule):
    """Tell whether the object can have come to where a report puts it."""
    kind, width = view.sensor.measurement, view.scan.measurement.shape[1]
    dim = rule.dim
    if not kind.gives_position(dim) or (kind is Kind.POSITION and width < dim):
        return True
    position, covariance, _ = place(view, index, dim)
    centre = state.weight @ state.mean
    spread = np.einsum("k,kij->ij", state.weight, state.covariance)
    scale = view.sensor.tail_scale if view.sensor.tail_share > 0.0 else 1.0
    variance = np.trace(spread[:dim, :dim]) + scale**2 * np.trace(covariance)
    reach = rule.max_speed * abs(view.moment(index) - time) + 3 * math.sqrt(variance)
    return np.linalg.norm(position - centre[:dim]) <= reach


def every(views, setting, known=()):
    """Return all sequences that keep the rules, by beginning and choice.

    The key is the number of the known track, or None, and the choice as for ``price``. Objects
    begin with reports that say where they are.
    """
    priced = {}
    for choice in product(*([None, *range(len(view.scan))] for view in views)):
        beginnings = list(enumerate(known))
        first = next(
            (v for v, index in zip(views, choice, strict=True) if index is not None), None
        )
        if first is not None and locates(first, setting.rule.dim):
            beginnings.append((None, None))
        for number, track in beginnings:
            result = price(views, choice, setting, track)
            if result is not None:
                priced[number, choice] = result
    return priced


def locates(view, dim):
    """Tell whether a view's reports say where their objects are."""
    kind = view.sensor.measurement
    whole = kind is not Kind.POSITION or view.scan.measurement.shape[1] == dim
    return kind.gives_position(dim) and whole
