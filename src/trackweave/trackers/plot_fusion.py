"""From the plots of several sensors at one instant to reports fused of them."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from trackweave.arrays import FloatArray, IntArray, float_array, require_finite
from trackweave.association.plots_rule import PlotsRule
from trackweave.association.problem import Answer, Certificate, Status
from trackweave.association.scan_plots import plots_of
from trackweave.association.sensor_plots import SensorPlots
from trackweave.domain.foreign_kind import ours
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import TrackTable
from trackweave.errors import InvalidInputError
from trackweave.fields import checked_count, checked_members, settle
from trackweave.models.coverage import FieldOfView, everywhere
from trackweave.models.extent import extent
from trackweave.models.foreign_motion import AnyMotion
from trackweave.models.sensors import Sensor
from trackweave.randomness import RandomSource, generator_of
from trackweave.solvers.auto import Auto
from trackweave.solvers.protocol import Solver, Stop, answered, require_solver
from trackweave.summaries import summary
from trackweave.trackers._arguments import (
    checked_dim,
    checked_sensors,
    dimensions_of,
    with_dimensions,
)
from trackweave.trackers.common_time import carried_along
from trackweave.trackers.fused_sensors import chances_of, likely_places
from trackweave.trackers.lone_plots import Standing, with_lone
from trackweave.trackers.plot_choice import (
    every_set,
    identities_of,
    numbered_scans,
    objects_in,
    worth_choosing,
)

__all__ = ["FusedPlots", "PlotFuser", "fused_name"]

ALL_BUT_BLIND = 0.1
"""Instants at which objects are reported more rarely than this make no track miss a chance."""
NOWHERE = FieldOfView(min_range=1e15, max_range=2e15)
CLOCK_NOISE = 1e-6
"""Scans no further apart than this are simultaneous [s]: times are sums of periods."""
LEFT_OUT = "tuples left out"
"""Why a search ends that saw only some of the tuples in the gate."""


@dataclass(frozen=True, slots=True, eq=False)
class FusedPlots:
    """What the plots of an instant were fused to.

    Parameters
    ----------
    scan
        The fused reports, positions with covariances.
    members
        Numbers of the original reports that each holds.
    alone
        Numbers of the original reports that no fused report holds: false alarms.
    certificate
        Cost of the choice of tuples, and a bound that holds over all tuples that lie in the gate:
        minus infinity where some had to be left out.
    evaluations, stop_reason
        Of the search, as in ``Answer``.
    n_tuples
        How many tuples it chose from.
    is_complete
        Whether these were all that lie in the gate.
    """

    scan: Scan
    members: tuple[IntArray, ...]
    alone: IntArray
    certificate: Certificate
    evaluations: int
    stop_reason: str
    n_tuples: int
    is_complete: bool

    __repr__ = summary

    def __len__(self) -> int:
        return len(self.members)


@dataclass(frozen=True, slots=True)
class PlotFuser:
    """Fuses the plots that several sensors made of objects at one instant.

    Plots of one object are told by the cost of the tuple that they make, at most one of each
    sensor [1]_; each tuple that a solver chooses becomes one report: its most likely position,
    with its covariance. By evidence a single position may stand as an object that one sensor saw,
    if the rule prices these; by equation 1 a tuple of one plot is a false alarm, and has the price
    of that equation where the rule prices these.

    Parameters
    ----------
    sensors
        The sensors; scans of others are refused.
    rule
        Which plots are joined, and what a tuple costs.
    search
        Any solver.
    motion
        How objects move, for plots that are not all of one time; None to take them as if they
        were.
    volumes
        Each sensor's field of view in units of its measurement, by name, for equation 1; those
        left out are taken from ``Sensor.field_of_view``.
    ignored_widths
        How widely false alarms of a sensor are spread in what plots leave out, range rates [m/s]
        and in two dimensions elevations [rad]; needed where it measures such.
    dim
        Number of dimensions of the tracking space; None for what sensors or reports tell.
    keep_lone
        Whether a position where no other sensor looks at that instant becomes a report by itself,
        at its own moment, for the tracker to tell from a false alarm. By evidence only.

    Raises
    ------
    InvalidInputError
        If an argument is of another kind than it has to be, or names of sensors joined by "+"
        read alike.

    References
    ----------
    .. [1] I. Wiranto, Z. Bonok, *Application of ant system and nearest neighbor Kalman filter
       for multi target tracking in multi sensor radar system*, ARPN, 2018, eqs. (1) and (2).

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> sensors = [tw.Sensor(name, sigma=5.0, clutter_density=1e-6) for name in ("A", "B")]
    >>> fuser = tw.PlotFuser(sensors, tw.PlotsRule(object_density=1e-6))
    >>> scans = [
    ...     tw.Scan(time=0.0, sensor="A", measurement=[[7.0, 3.0]]),
    ...     tw.Scan(time=0.0, sensor="B", measurement=[[9.0, 3.0]]),
    ... ]
    >>> fuser(scans, rng=np.random.default_rng(1)).scan.measurement  # m
    array([[8., 3.]])
    """

    sensors: Sequence[Sensor]
    rule: PlotsRule
    search: Solver = field(default_factory=Auto)
    motion: AnyMotion | None = None
    volumes: Mapping[str, float] = field(default_factory=dict)
    ignored_widths: Mapping[str, float] = field(default_factory=dict)
    dim: int | None = None
    keep_lone: bool = False

    def __post_init__(self) -> None:
        settle(self)
        if self.keep_lone and self.rule.cost != "evidence":
            raise InvalidInputError("keep_lone: True; expected False with a cost by equation 1")
        require_solver(self.search, "search")
        known = checked_sensors(self.sensors)
        object.__setattr__(self, "sensors", tuple(known.values()))
        object.__setattr__(self, "dim", checked_dim(self.dim, None, known))
        for name in ("volumes", "ignored_widths"):
            given = getattr(self, name)
            for sensor in given:
                if sensor not in known:
                    names = ", ".join(sorted(known))
                    raise InvalidInputError(f"{name}: sensor {sensor!r:.80}; expected of {names}")

    def __call__(
        self,
        scans: Sequence[Scan],
        *,
        rng: RandomSource = 0,
        stop: Stop | None = None,
        tracks: TrackTable | None = None,
        first_report: int = 0,
    ) -> FusedPlots:
        """Return the fused reports of an instant.

        Parameters
        ----------
        scans
            One scan of each sensor that looked, in any order, at least one; their common time is
            that of the last. A sensor that looked and saw nothing has an empty scan, and what it
            covers was missed; one without a scan did not look. Reports without numbers are
            counted on from the greatest one, or from 0, in the order of the sensors.
        rng
            The only source of randomness: a generator, or a seed, which draws the same numbers at
            each call.
        stop
            Asked every few milliseconds whether to stop with the best choice so far.
        tracks
            The live tracks, along which plots near them move to the common time.
        first_report
            Number of the first fused report; the others count on.

        Returns
        -------
        The fused reports, in the order of their plots.

        Raises
        ------
        InvalidInputError
            If scans are not of different known sensors, or do not fit them or each other.
        """
        rng = generator_of(rng)
        first = checked_count(first_report, "first_report")
        looked = numbered_scans(self.checked(scans))
        time = max(scan.time for scan in looked)
        known = self._dimensions(looked)
        dim = known or 2
        plots = [self._plots(scan, dim, time, tracks) for scan in looked]
        tuples = worth_choosing(self.rule(plots), plots, self.rule)
        problem = tuples.problem()
        answer = answered(self.search, problem, rng=rng, stop=stop)
        chosen = objects_in(tuples, problem, answer, self.rule)
        made = Standing(tuples.tuples[chosen], tuples.positions[chosen],
                        tuples.covariances[chosen], np.full(chosen.shape[0], time))  # fmt: skip
        if self.keep_lone and known:
            measured = [self._measured(scan, dim, scan.time, 0.0) for scan in looked]
            made = with_lone(made, looked, plots, measured)
        held = [
            np.array([s.report[p - 1] for s, p in zip(looked, row, strict=True) if p > 0])
            for row in made.taken
        ]
        every = np.concatenate([scan.report for scan in looked])
        return FusedPlots(
            scan=Scan(
                time=time,
                sensor=fused_name(looked),
                # An empty scan that fits every tracker, where nothing tells the dimensions.
                measurement=made.position if known else np.empty((0, 0)),
                covariance=made.covariance if known else None,
                report=first + np.arange(len(held)),
                moments=made.moments if self.keep_lone else None,
                identity=identities_of(looked, made.taken),
            ),
            members=tuple(held),
            alone=every[~np.isin(every, np.concatenate([every[:0], *held]))],
            certificate=_certificate(answer, is_complete=tuples.is_complete),
            evaluations=answer.evaluations,
            stop_reason=answer.stop_reason if tuples.is_complete else LEFT_OUT,
            n_tuples=len(tuples),
            is_complete=tuples.is_complete,
        )

    def checked(self, scans: Iterable[Scan]) -> list[Scan]:
        """Return an instant's scans in the order of the sensors, once they are found sound.

        Parameters
        ----------
        scans
            As for a call.

        Returns
        -------
        The scans.

        Raises
        ------
        InvalidInputError
            If there is none, or they are not of different known sensors.
        """
        looked = checked_members(scans, Scan, "scans")
        place = {sensor.name: number for number, sensor in enumerate(self.sensors)}
        for scan in looked:
            if scan.sensor not in place:
                known = ", ".join(sorted(place))
                raise InvalidInputError(f"scan of sensor {scan.sensor!r}; expected one of {known}")
        if not 0 < len(looked) == len({scan.sensor for scan in looked}):
            raise InvalidInputError("scans: expected at least one, and each of another sensor")
        for scan in looked:
            dimensions_of(scan, self.sensors[place[scan.sensor]], self.dim)
        return sorted(looked, key=lambda scan: place[scan.sensor])

    def fused_sensors(
        self,
        scan_period: float | None,
        *,
        combinations: Iterable[Sequence[str]] | None = None,
        places: FloatArray | None = None,
    ) -> tuple[Sensor, ...]:
        """Return the sensors of fused reports, one for each set of sensors that look at once.

        Each reports positions and covers everything, or nothing where hardly any object could
        be reported, so that no track misses a chance. An object is among its reports if enough
        of the sensors that cover it report it for their plots to cost less as a tuple than alone;
        its false alarms are the tuples that chance makes of false alarms. One that takes the
        place of an object's missed plot is none: the tuple is of the object still.

        Parameters
        ----------
        scan_period
            Seconds from instant to instant, above 0; None where there is no telling.
        combinations
            Names of the sensors of each set; None for every set, of at most six sensors, or for
            all sensors together.
        places
            Where objects may be [m], shape (places, dimensions), over which both numbers are
            averaged; None for a grid over the fields of view, or about the sensors.

        Returns
        -------
        The sensors, all of the sensors first.

        Raises
        ------
        InvalidInputError
            If a name is unknown, or places are no places.
        """
        known = {sensor.name: sensor for sensor in self.sensors}
        sets = every_set(list(known)) if combinations is None else list(combinations)
        dim = self.dim or 2
        if places is None:
            places = likely_places(self.sensors, dim)
        places = float_array(places, "places", (None, dim))
        require_finite(places, "places")
        fused: dict[str, Sensor] = {}
        for names in sets:
            if not (names and set(names) <= set(known)):
                raise InvalidInputError(
                    f"combinations: {names!r:.80}; expected of {', '.join(sorted(known))}"
                )
            own = [sensor for sensor in self.sensors if sensor.name in names]
            name = "+".join(sensor.name for sensor in own)
            volumes = [self._volume(sensor, dim) for sensor in own]
            chance, density = chances_of(own, self.rule, places, volumes, keep_lone=self.keep_lone)
            if name in fused:
                raise InvalidInputError(
                    f"sensors: {name!r:.80} reads like several; expected names without '+'"
                )
            fused[name] = Sensor(
                name=name,
                detection_probability=chance,
                clutter_density=density,
                scan_period=scan_period,
                field_of_view=NOWHERE if chance < ALL_BUT_BLIND else None,
                identity_error=max(sensor.identity_error for sensor in own),
            )
        return tuple(fused.values())

    def _volume(self, sensor: Sensor, dim: int) -> float | None:
        """Return what a sensor's field of view holds, in units of what it measures."""
        if sensor.name in self.volumes:
            return self.volumes[sensor.name]
        view = sensor.field_of_view
        coverage = everywhere() if view is None else view.coverage()
        return extent(coverage, ours(sensor.measurement, sensor.name)) if dim == 2 else None

    def _dimensions(self, scans: Sequence[Scan]) -> int | None:
        """Return the number of dimensions, None where empty scans do not tell it."""
        known = {sensor.name: sensor for sensor in self.sensors}
        dim = self.dim
        for scan in scans:
            dim = dimensions_of(scan, known[scan.sensor], dim) or dim
        return dim

    def _plots(self, scan: Scan, dim: int, time: float, tracks: TrackTable | None) -> SensorPlots:
        """Return a scan's plots at the common time."""
        speed = 0.0 if self.motion is None else math.sqrt(self.motion.velocity_variance(dim))
        if abs(time - scan.time) <= CLOCK_NOISE:
            time = scan.time
        plots = self._measured(scan, dim, time, speed)
        if self.motion is None or tracks is None:
            return plots
        moments = np.full(len(scan), scan.time) if scan.moments is None else scan.moments
        return carried_along(plots, time - moments, time, tracks, self.rule.gate)

    def _measured(self, scan: Scan, dim: int, time: float, speed: float) -> SensorPlots:
        """Return a scan's plots as they were measured."""
        sensor = next(sensor for sensor in self.sensors if sensor.name == scan.sensor)
        return plots_of(
            with_dimensions(scan, sensor, dim),
            sensor,
            dim,
            time=time,
            speed=speed,
            volume=self.volumes.get(scan.sensor),
            ignored_width=self.ignored_widths.get(scan.sensor),
        )


def fused_name(scans: Sequence[Scan]) -> str:
    """Return the name of the sensor of an instant's fused reports: its sensors' joined by "+"."""
    return "+".join(scan.sensor for scan in scans)


def _certificate(answer: Answer, *, is_complete: bool) -> Certificate:
    """Return the answer's certificate, as far as its bound holds over all tuples in the gate."""
    unbounded = Certificate(answer.cost, -np.inf, Status.FEASIBLE)
    return answer.certificate if is_complete else unbounded
