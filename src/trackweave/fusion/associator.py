"""Which tracks of many sensors are of one object, one time after the other."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np

from trackweave.arrays import FloatArray, IntArray, require_instance
from trackweave.association.problem import Certificate
from trackweave.errors import InvalidInputError
from trackweave.fields import checked_number, settle
from trackweave.fusion._statistic import evaluate_all
from trackweave.fusion.complete import group_completely, require_equal_lists
from trackweave.fusion.confirmation import Confirmation
from trackweave.fusion.grouping import Grouping, Groups, Scene
from trackweave.fusion.histories import Histories
from trackweave.fusion.objects import Change, Evidence, described, renumber
from trackweave.fusion.pictures import LocalPicture
from trackweave.fusion.statistic import Statistic
from trackweave.keys import Key
from trackweave.randomness import RandomSource, generator_of
from trackweave.solvers.protocol import Solver, require_solver
from trackweave.summaries import summary

__all__ = ["Association", "TrackAssociator"]


@dataclass(frozen=True, slots=True, eq=False)
class Association:
    """Which object each live local track is of, at one time.

    Parameters
    ----------
    time
        That time [s].
    names
        Names of the sensors, in the order of the chain.
    sensor
        Place of each track's sensor in ``names``, shape (tracks,).
    track
        The sensor's number of the track, shape (tracks,).
    object
        Lasting number of its object, from 1, shape (tracks,).
    statistic, threshold
        λ of the object's tracks, and what it was allowed to be; 0 for a track alone.
    changes
        What became of objects at this time.
    certificate
        Cost of the association, half of what statistics exceed the prices of joins by [nats], and
        what it could cost at least; where tuples are complete, the document's J = Σ b.
    n_tuples
        Tuples that the search chose from.
    n_pruned
        Tuples left out for want of room. The bound covers neither these nor pairs that were left
        out because both tracks have a far better partner.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> state = [[100.0, 50.0, 10.0, 0.0]]  # x, y [m], vx, vy [m/s]
    >>> spread = np.diag([25.0, 25.0, 1.0, 1.0])[None]
    >>> pictures = {n: tw.LocalPicture(n, 0.0, [1], state, spread) for n in ("A", "B")}
    >>> associator = tw.TrackAssociator()
    >>> association = associator.step(0.0, pictures, rng=np.random.default_rng(1))
    >>> association.object  # both tracks are of object 1
    array([1, 1])
    """

    time: float
    names: tuple[str, ...]
    sensor: IntArray
    track: IntArray
    object: IntArray
    statistic: FloatArray
    threshold: FloatArray
    changes: tuple[Change, ...]
    certificate: Certificate
    n_tuples: int
    n_pruned: int

    __repr__ = summary

    def __len__(self) -> int:
        return int(self.track.shape[0])

    def of(self, name: str) -> dict[int, int]:
        """Return the object of each live track of one sensor."""
        if name not in self.names:
            return {}
        mine = self.sensor == self.names.index(name)
        return dict(zip(self.track[mine].tolist(), self.object[mine].tolist(), strict=True))

    def tuples(self) -> frozenset[tuple[int, ...]]:
        """Return the groups, each as its tracks' numbers sensor by sensor, -1 for none."""
        number, row = np.unique(self.object, return_inverse=True)
        table = np.full((number.shape[0], len(self.names)), -1, dtype=np.int64)
        table[row.reshape(-1), self.sensor] = self.track
        return frozenset(tuple(line) for line in table.tolist())


@dataclass(slots=True, eq=False)
class TrackAssociator:
    """Associates the tracks of many sensors, again at each time, and keeps objects' numbers.

    Sensors may see some of the objects only, none at all, and report at periods of their own;
    they may appear, vanish and return. What is held together is broken only on more evidence than
    it takes to keep it.

    Parameters
    ----------
    sensors
        Names of the sensors in the order of the chain; others join at the end when they appear.
    statistic
        What decides whether tracks may be of one object.
    process_noise
        Power spectral density of the objects' acceleration along each axis [m²/s³]: how fast an
        estimate ages.
    confirm
        Declare pairings only when they came out so often, as a rule, as (N, M) or as "N/M"; None
        to take each association as it is.
    search
        Any solver; None for ``Auto``.
    hysteresis
        What is held is tested at so many times the rate of false rejection.

        Tracks change places only where that is 1/hysteresis times likelier.
    patience
        A sensor's tracks count until it is silent for so many of its periods.
    breadth
        How many tuples of each size are kept per first track where very many compete, at least
        1; the fewer compete, the more are kept.
    complete
        Whether every sensor sees every object, and each track is in one tuple with one of each.

        The document's own problem [1]_. A tuple beyond the threshold is then no object.

    Raises
    ------
    InvalidInputError
        If an argument is out of range, or only one sensor is named.

    References
    ----------
    .. [1] Huo, Zhang, Bai, Song, Xiong, 2008, section 1.3.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> state = [[100.0, 50.0, 10.0, 0.0]]  # x, y [m], vx, vy [m/s]
    >>> spread = np.diag([25.0, 25.0, 1.0, 1.0])[None]
    >>> pictures = {n: tw.LocalPicture(n, 0.0, [1], state, spread) for n in ("A", "B")}
    >>> associator = tw.TrackAssociator()
    >>> association = associator.step(0.0, pictures, rng=np.random.default_rng(1))
    >>> association.object  # both tracks are of object 1
    array([1, 1])
    """

    sensors: Sequence[str] = ()
    statistic: Statistic = field(default_factory=Statistic)
    process_noise: Annotated[float, Key("a number ≥ 0 in m²/s³", 0, 1e15)] = 1.0
    confirm: Confirmation | tuple[int, int] | str | None = None
    search: Solver | None = None
    hysteresis: Annotated[float, Key("a number above 0 and at most 1", 1e-6, 1)] = 0.1
    patience: Annotated[float, Key("a number ≥ 1", 1, 1e9)] = 3.0
    breadth: int = 16
    complete: Annotated[bool, Key()] = False
    _histories: Histories = field(init=False, repr=False)
    _rule: Confirmation | None = field(init=False, repr=False)
    _outcomes: list[tuple[IntArray, IntArray]] = field(
        init=False, repr=False, default_factory=list
    )
    _before: IntArray = field(init=False, repr=False)
    _next: int = field(init=False, repr=False, default=1)

    def __post_init__(self) -> None:
        settle(self)
        self._require()
        names = list(self.sensors)
        self._histories = Histories(self.statistic, self.process_noise, self.patience, names)
        self._before = np.empty(0, dtype=np.int64)
        rule = self.confirm
        if isinstance(rule, str):
            rule = Confirmation.parse(rule)
        elif isinstance(rule, tuple):
            rule = Confirmation(*rule)
        self._rule = rule

    def _require(self) -> None:
        names = [self.sensors] if isinstance(self.sensors, str) else list(self.sensors)
        if len(names) == 1 or len(set(names)) < len(names):
            raise InvalidInputError(
                f"sensors: {names}; expected at least two, each once, or none to take all"
            )
        if self.search is not None:
            require_solver(self.search, "search")
        if self.complete and self.statistic.kind != "chain":
            raise InvalidInputError(
                f"statistic: kind {self.statistic.kind!r}; expected 'chain' for complete tuples"
            )
        if self.breadth < 1:
            raise InvalidInputError(f"breadth: {self.breadth!r:.80}; expected a whole number ≥ 1")

    def step(
        self, time: float, pictures: Mapping[str, LocalPicture], *, rng: RandomSource = 0
    ) -> Association:
        """Take what sensors say by a time, and return which tracks are of one object.

        Parameters
        ----------
        time
            That time [s], not before the last one. All tracks are brought to it by prediction.
        pictures
            For each sensor that has news its tracks, all of them: one that is not there any more
            has ended. A sensor that is left out has no news.
        rng
            Source of randomness: a generator, or a seed, which draws alike at each step.

        Returns
        -------
        The association.

        Raises
        ------
        InvalidInputError
            If times go back, or a picture does not fit; nothing has changed then.
        """
        time = checked_number(time, "time")
        require_instance(pictures, Mapping, "pictures")
        rng = generator_of(rng)
        histories = self._histories
        if self.complete:
            known = {name: len(source.picture) for name, source in histories.sources.items()}
            require_equal_lists(known | {name: len(new) for name, new in pictures.items()})
        live = histories.take(time, pictures)
        assert histories.rings is not None
        scene = Scene(histories.rings, histories.slots, live)
        groups = self._declared(scene, self._group(scene, rng))
        new = renumber(groups.label, live.held, self._before, self._next)
        changes = described(new, self._evidence(scene))
        histories.held[live.row] = new.object
        self._before, self._next = np.unique(new.object), new.next_number
        return Association(
            time=time,
            names=tuple(histories.names),
            sensor=live.sensor,
            track=histories.tracks(live),
            object=new.object,
            statistic=groups.value,
            threshold=groups.threshold,
            changes=changes,
            certificate=groups.certificate,
            n_tuples=groups.n_tuples,
            n_pruned=groups.n_pruned,
        )

    def _group(self, scene: Scene, rng: np.random.Generator) -> Groups:
        if self.complete:
            return group_completely(scene, self.statistic, self.search, rng)
        grouping = Grouping(self.statistic, self.hysteresis, breadth=self.breadth)
        return grouping(scene, self.search, rng)

    def _declared(self, scene: Scene, groups: Groups) -> Groups:
        """Return the groups that are declared, by how often their pairs came out lately."""
        if self._rule is None:
            return groups
        live, owner = scene.live, self._histories.owner
        outcome = np.full(owner.shape[0], -1, dtype=np.int64)
        outcome[live.row] = groups.label
        self._outcomes = [*self._outcomes, (owner.copy(), outcome)][-self._rule.of :]
        table = np.full((len(self._outcomes), live.row.shape[0]), -1, dtype=np.int64)
        for place, (had, was) in enumerate(self._outcomes):
            inside = live.row < was.shape[0]
            rows = live.row[inside]
            # A row may have been another track's then.
            table[place, inside] = np.where(had[rows] == owner[rows], was[rows], -1)
        label = self._rule.declared_groups(table, live.sensor)
        value, limit = self._judged(scene, label)
        return replace(groups, label=label, value=value, threshold=limit)

    def _judged(self, scene: Scene, label: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return the statistic and the threshold of each track's group."""
        live = scene.live
        n_groups, n_sensors = int(label.max(initial=-1)) + 1, int(live.sensor.max(initial=0)) + 1
        rows = np.full((n_groups, n_sensors), -1, dtype=np.int64)
        rows[label, live.sensor] = live.row
        value, limit = np.zeros((2, n_groups))
        form = self._evidence(scene).form
        evaluate_all(scene.rings, form, rows, value, limit)
        return value[label], limit[label]

    def _evidence(self, scene: Scene) -> Evidence:
        live, statistic = scene.live, self.statistic
        n_sensors = int(live.sensor.max(initial=0)) + 1
        size = live.mean.shape[1] * len(scene.slots) * n_sensors**2
        rate = statistic.false_rejection * (1.0 if self.complete else self.hysteresis)
        form = statistic.form(scene.slots, size, rate)
        count = f"; {self._rule.needed} of {self._rule.of} times" if self._rule else ""
        return Evidence(scene.rings, form, live.row, live.held, count)
