"""What sequences of reports cost, one at a time and from the beginning, and every one there is."""

import math
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from oracles import kalman
from oracles.coverage import share
from oracles.rhythms import Hearing
from trackweave.models.sensors import Sensor


@dataclass
class Hiding:
    """How probably an object since the last scan was hidden, or came in sight again."""

    hiding: float = 0.0
    showing: float = 0.0

    def moved(self, sight, hidden):
        """Return the probabilities to be in sight and hidden after it."""
        return (
            sight * (1 - self.hiding) + hidden * self.showing,
            hidden * (1 - self.showing) + sight * self.hiding,
        )


@dataclass
class Look:
    """A scan as the oracle sees it: positions in the order in which they came."""

    time: float
    sensor: Sensor
    positions: np.ndarray
    sigmas: np.ndarray
    log_density: float
    survival_cost: float = 0.0
    hiding: Hiding = field(default_factory=Hiding)

    @property
    def sees_everything(self):
        return self.sensor.field_of_view is None

    def blur(self, dim):
        """Return how far reports lie beside their objects: across [rad], along and across [m]."""
        none = self.sensor.sigmas(dim)[None]
        sigmas = self.sigmas if len(self.positions) else none
        widest = np.sqrt(np.mean(sigmas**2, axis=0))[:2].max()
        return 0.0, widest, widest


@dataclass
class Known:
    """A track from before the window."""

    mean: np.ndarray
    covariance: np.ndarray
    time: float


@dataclass
class Rules:
    """What sequences may do."""

    process_noise: float
    velocity_variance: float
    max_speed: float
    gate: float
    survival: float
    max_misses: float = math.inf
    max_unseen: float = math.inf

    @property
    def end_cost(self):
        return -math.log(1 - self.survival)


@dataclass
class Scored:
    """A sequence's cost up to its last report, in all, and its state then."""

    cost: float
    total: float
    mean: np.ndarray = field(repr=False)
    covariance: np.ndarray = field(repr=False)


def score(looks, choice, rules, known=None):
    """Return what a sequence costs, None if it breaks a rule.

    ``choice`` holds for each look the index of its report in the sequence, None for a miss.
    """
    cost = living = misses = 0.0
    hearing = Hearing()
    sight, hidden = 1.0, 0.0
    # How probably each sensor alone cannot see it.
    lost = {look.sensor.name: look.sensor.hidden_share for look in looks}
    counted = None
    mean = covariance = time = None
    if known is not None:
        mean, covariance, time = known.mean, known.covariance, known.time
    given_up = False
    for look, index in zip(looks, choice, strict=True):
        detection, clutter = look.sensor.detection_probability, look.sensor.clutter_density
        if mean is None:
            if index is None:
                continue
            dim = look.positions.shape[1]
            cost = -math.log(detection * math.exp(look.log_density) / clutter)
            cost += hearing.cost(look)
            mean = np.concatenate([look.positions[index], np.zeros(dim)])
            covariance = np.diag(
                np.concatenate([look.sigmas[index] ** 2, np.full(dim, rules.velocity_variance)])
            )
            time, counted = look.time, (look.time, 1.0)
            lost[look.sensor.name] = 0.0
            continue
        interval = look.time - time
        ahead, spread = kalman.predict(mean, covariance, interval, rules.process_noise)
        looked = share(look, ahead, spread)
        own = lost[look.sensor.name]
        fading, clearing = look.sensor.hiding()
        own += looked * ((1 - own) * fading - own * clearing)
        seen = detection * looked * (1 - own)
        living += look.survival_cost
        sight, hidden = look.hiding.moved(sight, hidden)
        if index is None:
            telling = look.sensor.tells_silence(len(look.positions))
            missed = (sight * (1 - seen * telling) + hidden) / (sight + hidden)
            lost[look.sensor.name] = own / missed if telling else own
            sight *= 1 - seen * telling
            before = counted[1] if counted and counted[0] == look.time else 0.0
            chance = max(0.0, looked * telling - before)
            counted = (look.time, before + chance)
            misses += chance
            given_up = given_up or misses >= rules.max_misses or interval > rules.max_unseen
            continue
        position, sigma = look.positions[index], look.sigmas[index]
        dim = position.shape[0]
        variance = np.trace(covariance[:dim, :dim]) + np.sum(sigma**2)
        reach = rules.max_speed * interval + 3 * math.sqrt(variance)
        if given_up or seen == 0.0 or np.linalg.norm(position - mean[:dim]) > reach:
            return None
        if kalman.squared_distance(ahead, spread, position, sigma) > rules.gate:
            return None
        cost += living + math.log(clutter / (seen * sight))
        cost -= kalman.log_likelihood(ahead, spread, position, sigma)
        cost += hearing.cost(look)
        mean, covariance = kalman.update(ahead, spread, position, sigma)
        living = misses = 0.0
        sight, hidden = 1.0, 0.0
        lost[look.sensor.name] = 0.0
        time, counted = look.time, (look.time, 1.0)
    tail = living - math.log(sight + hidden)
    ending = rules.end_cost if given_up else min(tail, rules.end_cost)
    return Scored(cost, cost + ending, mean, covariance)


def every_sequence(looks, rules, known=()):
    """Return all sequences that keep the rules, by beginning and choice.

    The key is the number of the known track, or None, and the choice as for ``score``.
    """
    scored = {}
    for choice in product(*([None, *range(len(look.positions))] for look in looks)):
        beginnings = list(enumerate(known))
        if any(index is not None for index in choice):
            beginnings.append((None, None))
        for number, track in beginnings:
            result = score(looks, choice, rules, track)
            if result is not None:
                scored[number, choice] = result
    return scored


def best_explanation(scored, n_known):
    """Return the least cost of disjoint sequences that cover every known track."""
    sequences = [
        (number, {(look, index) for look, index in enumerate(choice) if index is not None}, value)
        for (number, choice), value in scored.items()
    ]

    def search(place, taken, tracks):
        if place == len(sequences):
            return 0.0 if len(tracks) == n_known else math.inf
        best = search(place + 1, taken, tracks)
        number, reports, value = sequences[place]
        if not reports & taken and number not in tracks:
            further = tracks if number is None else tracks | {number}
            best = min(best, value.total + search(place + 1, taken | reports, further))
        return best

    return search(0, frozenset(), frozenset())
