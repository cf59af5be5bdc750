"""What the kernels of a tree share: sequences, scans, rules."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._levels import SIZE as LEVEL_SIZE
from trackweave.association._rhythm import SIZE as RHYTHM_SIZE
from trackweave.domain.foreign_kind import ForeignKind, Reported
from trackweave.domain.measurements import MeasurementKind
from trackweave.models.coverage import Coverage
from trackweave.models.foreign_motion import ForeignMotion
from trackweave.models.motion import CONSTANT_VELOCITY, MotionRule

NO_COLUMNS = np.empty(0)
"""Of scans in which no sensor loses objects for a while."""


class ForeignReports(NamedTuple):
    """Reports of a kind from outside the package, in the order of their scan."""

    kind: ForeignKind
    reported: Reported

    def part(self, rows: Any) -> "ForeignReports":
        """Return some of them."""
        return ForeignReports(self.kind, self.reported.part(rows))


class Nodes(NamedTuple):
    """Sequences that share prefixes; a parent always stands before its children.

    ``report`` is the last report's slot in the window, -1 where a track from before the window
    starts. ``chosen`` is 1 for the last hypothesis's sequences. ``cost`` is what the sequence
    costs up to its last report and ``tail`` what the scans since then add while the object lives
    [nats]; ``hidden`` is how probable it is, if it lives, that no sensor can see it now, and
    ``unseen`` that this one cannot, by sensors of which such is known (``ScanInput.column``).
    ``misses`` counts the chances to be seen since the last report, where all sensors of
    one instant give one chance, of which ``counted`` is the share already counted at this
    instant; ``chances`` counts those up to and with the last report, from the object's first.
    ``price`` is what holding the last report against others is worth [nats], as far as they were
    known, and ``belief`` how probable it was then that this is what its object did and that it
    lives. ``identity`` is who it says it is, ``other`` who its last report said if that was not
    the same; -1 for nobody. ``sensor`` is the last report's, -1 for none. ``rhythm`` says at
    which intervals the object reports itself, see ``association._rhythm``. ``wild`` is how
    probable it is that the noise was wide of the last report but the first that was of a sensor
    whose tails persist; -1 where there was none. ``level`` is how high it is, as told beside its
    place, see ``association._levels``.

    ``mean``, ``covariance`` and ``weight`` are the state at ``time``, the last report's: one for
    each mode of motion, and how probable that mode is. Where ``is_line`` is 1 the object has been
    seen from one place by its bearing alone: then the first mode's mean holds that place x, y
    [m], the bearing and its standard deviation [rad], and the first number of the covariance
    what the report costs as far as it does not depend on the place [nats].
    """

    parent: IntArray
    report: IntArray
    family: IntArray
    hits: IntArray
    chosen: IntArray
    identity: IntArray
    other: IntArray
    sensor: IntArray
    is_line: IntArray
    cost: FloatArray
    tail: FloatArray
    hidden: FloatArray
    unseen: FloatArray
    misses: FloatArray
    counted: FloatArray
    chances: FloatArray
    price: FloatArray
    belief: FloatArray
    time: FloatArray
    wild: FloatArray
    rhythm: FloatArray
    level: FloatArray
    mean: FloatArray
    covariance: FloatArray
    weight: FloatArray


class Families(NamedTuple):
    """What is known of each family of sequences; see ``association.tree``.

    ``track`` is its identifier, -1 for one that begins in the window, and ``start_cost`` what its
    first report cost then, at least 0 [nats]. ``fixed_slot`` is the slot of its last report among
    those fixed, -1 for none. The rest is the last hypothesis's: under which ``name`` its chosen
    sequence is known, -1 for none, how probable it is that its object lives (``existence``),
    whether that is ``confirmed``, what its fixed reports cost (``score``), and what they say for
    false alarms that came again (``doubt``) [nats].
    """

    track: IntArray
    start_cost: FloatArray
    fixed_slot: IntArray
    name: IntArray
    existence: FloatArray
    confirmed: np.ndarray
    score: FloatArray
    doubt: FloatArray


class ScanInput(NamedTuple):
    """A scan as the kernels read it.

    Reports that say where their objects are (``is_located``) are sorted by the first coordinate.
    ``is_silence_telling`` says whether the scan tells anything of objects that it does not report,
    and ``is_heard`` whether its objects report themselves.
    ``reference`` is when the scan looks, ``time`` when it ends; with ``has_moments`` each report
    has its own time. Two reports of one object lie at least ``separation`` apart [s].
    A miss counts for ``pace``, less than 1 for a sensor that scans faster than the one that the
    window goes by.
    ``setting`` is which ``noise`` (covariance) and ``platform`` (place and velocity of the sensor)
    a report has. ``log_begin`` is what a report adds to the log evidence of a new object beyond
    the density at its place [nats]: the volume that a measurement stands for, and a rate's own.
    ``level`` is the height that it tells beside its place [m], NaN for none, and ``sigma_level``
    how exact it is.
    ``evidence`` is what its strength says [nats]. A report of the track's own identity is worth
    ``identity_gain``, one of another costs ``identity_loss`` [nats]. Since the last scan an object
    in sight was hidden with probability ``hiding``, and a hidden one came in sight with
    ``showing``. Where ``column`` is not -1 the sensor by itself loses an object from look to look
    with probability ``fading``, and finds one that it lost with ``clearing``. A share of the
    reports, ``tail_share``, has noise ``tail_scale`` times as wide;
    where none has, the scale is 1. ``tail_persistence`` says how much an object's last report
    tells of whether the noise of this one is. ``foreign`` is what the reports are where their
    kind is from outside the package; kernels take such scans without it.
    """

    kind: int
    sensor: int
    time: float
    reference: float
    new_instant: bool
    is_silence_telling: bool
    is_heard: bool
    has_moments: bool
    is_located: bool
    separation: float
    pace: float
    gate: float
    reach: float
    measurement: FloatArray
    moment: FloatArray
    setting: IntArray
    noise: FloatArray
    platform: FloatArray
    position: FloatArray
    position_covariance: FloatArray
    log_begin: FloatArray
    slot: IntArray
    identity: IntArray
    evidence: FloatArray
    level: FloatArray
    sigma_level: float
    identity_gain: float
    identity_loss: float
    detection_probability: float
    log_clutter: float
    survival_cost: float
    hiding: float
    showing: float
    coverage: Coverage
    tail_share: float = 0.0
    tail_scale: float = 1.0
    tail_persistence: float = 0.0
    column: int = -1
    fading: float = 0.0
    clearing: float = 0.0
    foreign: ForeignReports | None = None


class WindowRule(NamedTuple):
    """What it costs to extend a sequence; see ``association.window_rule``.

    ``unseen`` is how probably a new object is unseen, by columns of sensors. ``way`` is
    how objects move where the model is from outside the package; kernels take rules
    without it.
    """

    motion: MotionRule
    crossing_time: float
    end_cost: float
    most_tail: float
    max_misses: float
    max_unseen: float
    max_shown: float
    unseen: FloatArray = NO_COLUMNS
    way: ForeignMotion | None = None


class Misses(NamedTuple):
    """What each sequence becomes if the scan has no report of it, and how probably it has one."""

    tail: FloatArray
    hidden: FloatArray
    unseen: FloatArray
    seen: FloatArray
    misses: FloatArray
    counted: FloatArray


class Candidates(NamedTuple):
    """Children that a scan offers: parent node, index in the scan, cost.

    ``leap`` tells whose object moved as its model does not foresee, see ``association._leaps``.
    """

    node: IntArray
    report: IntArray
    cost: FloatArray
    leap: np.ndarray


class State(NamedTuple):
    """A state by modes of motion, to work in."""

    mean: FloatArray
    covariance: FloatArray
    weight: FloatArray


class Expectation(NamedTuple):
    """What each mode expects of a report, to work in: mean, S⁻¹, ln det S, P Hᵀ, and S."""

    mean: FloatArray
    inverse: FloatArray
    log_determinant: FloatArray
    cross: FloatArray
    spread: FloatArray
    innovation: FloatArray


def bare(scan: ScanInput) -> ScanInput:
    """Return a scan as kernels take it."""
    return scan._replace(foreign=None)


def n_modes_and_size(motion: MotionRule) -> tuple[int, int]:
    """Return how many modes a motion has, and how many numbers a state."""
    return int(np.shape(motion.kind)[0]), int(np.shape(motion.prior)[0])


def is_plain(scan: ScanInput, motion: MotionRule) -> bool:
    """Tell whether a scan holds whole positions without tails, states one constant velocity.

    Such scans go a short way, several times faster and sooner compiled than the general one, and
    to the same end.
    """
    return (
        scan.kind == MeasurementKind.POSITION
        and scan.measurement.shape[1] == motion.dim
        and not scan.has_moments
        and scan.tail_share == 0.0
        and motion.kind.tolist() == [CONSTANT_VELOCITY]
        and motion.prior.shape[0] == 2 * motion.dim
    )


def room_for_candidates(count: int) -> Candidates:
    """Return room for so many children."""
    whole, leap = np.empty((2, count), dtype=np.int64), np.zeros(count, dtype=np.bool_)
    return Candidates(whole[0], whole[1], np.empty(count), leap)


def allocate(capacity: int, modes: int, size: int, columns: int = 0) -> Nodes:
    """Return room for nodes of states of so many modes and numbers, and columns of sensors."""

    def column(*shape: int, dtype: Any = np.float64) -> NDArray[Any]:
        return np.empty((capacity, *shape), dtype=dtype)

    whole = (
        "parent", "report", "family", "hits", "chosen", "identity", "other", "sensor", "is_line",
    )  # fmt: skip
    real = (
        "cost", "tail", "hidden", "misses", "counted", "chances", "price", "belief", "time",
        "wild",
    )  # fmt: skip
    return Nodes(
        **{name: column(dtype=np.int64) for name in whole},
        **{name: column() for name in real},
        unseen=column(columns),
        rhythm=column(RHYTHM_SIZE),
        level=column(LEVEL_SIZE),
        mean=column(modes, size),
        covariance=column(modes, size, size),
        weight=column(modes),
    )


def sizes_of(nodes: Nodes) -> tuple[int, int, int]:
    """Return how many modes, numbers and columns of sensors nodes have."""
    _, modes, size = nodes.mean.shape
    return modes, size, nodes.unseen.shape[1]


def larger(nodes: Nodes, n_nodes: int, capacity: int) -> Nodes:
    """Return the first nodes in a larger room."""
    room = allocate(capacity, *sizes_of(nodes))
    for old, new in zip(nodes, room, strict=True):
        new[:n_nodes] = old[:n_nodes]
    return room


def new_families(track: IntArray, start_cost: FloatArray) -> Families:
    """Return families of which no hypothesis has spoken yet."""
    count = track.shape[0]
    nobody, nothing = np.full(count, -1, dtype=np.int64), np.zeros(count)
    return Families(
        track=track,
        start_cost=start_cost,
        fixed_slot=nobody,
        name=nobody,
        existence=nothing,
        confirmed=np.zeros(count, dtype=np.bool_),
        score=nothing,
        doubt=nothing,
    )


def part_of(families: Families, which: IntArray | NDArray[np.bool_]) -> Families:
    """Return some families, in the order asked for."""
    return Families._make(column[which] for column in families)


def joined(first: Families, second: Families) -> Families:
    """Return families and others behind them."""
    return Families._make(np.concatenate(pair) for pair in zip(first, second, strict=True))


def workspace(motion: MotionRule) -> State:
    """Return room for a state to work in."""
    modes, size = n_modes_and_size(motion)
    return State(np.empty((modes, size)), np.empty((modes, size, size)), np.ones(modes))
