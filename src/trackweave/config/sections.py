"""The tables of ``tracker.toml``: which of the library's classes they fill, and what they add.

A key that is left out is filled later, from the data or by a default: the one of its class, or
that which stands here.
"""

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal

from trackweave.association.growth_limits import GrowthLimits
from trackweave.config.tables import Section
from trackweave.domain.frames import ORIGIN, PLACE
from trackweave.domain.measurements import MeasurementKind
from trackweave.keys import ANGLE_NOISE, COORDINATE, NOISE, POSITIVE, SECONDS, Key, Pair
from trackweave.models.biases import Biases
from trackweave.models.motion import MODELS, PROCESS_NOISE
from trackweave.models.sensors import Sensor
from trackweave.models.strength import StrengthModel
from trackweave.trackers.clock_guard import MAX_AHEAD
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.window import Window

__all__ = [
    "KINDS",
    "ConfigurationSection", "FieldOfViewSection", "FrameSection", "FusionSection",
    "GrowthSection", "ImmSection", "LifecycleSection", "LiveSection", "ModeSection",
    "MotionSection", "OutputSection", "PlotsSection", "SearchSection", "SensorSection",
    "SensorsSection", "SigmaTable", "SolverSection", "StatisticSection", "StrengthSection",
    "TrackerSection", "WindowSection",
]  # fmt: skip

_WAYS = tuple(MODELS)
_KINDS = [kind for kind in MeasurementKind if kind is not MeasurementKind.RANGE_RATE]
KINDS = tuple(kind.word for kind in _KINDS)
# Not read off BiasModel: a run that fuses nothing does not import what does.
_BIASES = ("translation", "rotation", "range", "azimuth", "clock")
_SIGMAS = [set(kind.columns(dim)) for kind in _KINDS for dim in (2, 3)]


def _or_plugin(words: tuple[str, ...]) -> str:
    """Return what a message says was expected of a word that plug-ins may bring too."""
    known = ", ".join(f'"{word}"' for word in words)
    return f"one of {known}, or the name of a plug-in"


def _is_rate(value: str, most: float = 100, part: float = 0.0) -> bool:
    """Tell whether a text says M out of N, of at most so many, and more than a part of them."""
    hits, slash, chances = value.partition("/")
    if not (slash and hits.isdecimal() and chances.isdecimal()):
        return False
    return 1 <= int(hits) <= int(chances) <= most and int(hits) > part * int(chances)


class ModeSection(Section, of=tuple(MODELS.values())):
    """One of the ways to move between which objects change."""

    process_noise: Annotated[
        float,
        PROCESS_NOISE,
        "Power spectral density of the acceleration along each axis [m²/s³]; of the jerk [m²/s⁵] "
        "for constant-acceleration, of the velocity [m²/s] for random-walk.",
    ]
    model: Annotated[
        str, Key(words=_WAYS), "Which way to move; left out = the one of the table's name."
    ]


class ImmSection(Section, entries=ModeSection):
    """The ways to move between which objects change; further tables are theirs, by name."""

    models: Annotated[
        tuple[str, ...],
        Key('two to eight names, such as ["constant-velocity", "coordinated-turn"]', size=(2, 8)),
        "Names of the ways to move: of models, or of tables here that say which model.",
    ]
    sojourn_time: Annotated[
        tuple[Annotated[float, SECONDS], ...],
        Key("a number > 0 of seconds for each model, such as [60.0, 15.0]", size=(2, 8)),
        "How long an object stays in each on average [s].",
    ]

    @staticmethod
    def rule(values: Mapping[str, Any]) -> str | None:
        """Return what was expected of names that are no models, or come twice."""
        models = values.get("models", [])
        tables = [name for name in values if name not in ("models", "sojourn_time")]
        for name in [*models, *tables]:
            if name not in MODELS and "model" not in values.get(name, {}):
                return f'"{name}" to be a model, or a table whose key model says one'
        if len(set(models)) < len(models):
            return "each name once; a table with a key model gives another name"
        return None


class MotionSection(ModeSection, of=tuple(MODELS.values())):
    """How objects move."""

    model: Annotated[
        str,
        Key(_or_plugin((*_WAYS, "imm")), words=(*_WAYS, "imm")),
        "How objects move: what wanders, or imm for changes between several ways.",
    ]
    filter: Annotated[
        Literal["extended", "unscented"],
        "How measurements that are not linear are taken: by slopes or by sigma points.",
    ] = "extended"
    imm: Annotated[
        ImmSection, "The ways to move between which objects change, where the model is imm."
    ]
    trust: Annotated[
        bool | tuple[Annotated[str, Key(words=("process_noise", "max_speed"))], ...],
        Key('true, false, or a list of keys: "process_noise", "max_speed"'),
        "Whether what is told is kept where tracks contradict it: of all keys, or of those named.",
    ] = False


class SigmaTable(Section):
    """Standard deviation by column."""

    x: Annotated[float, NOISE, "East [m]."]
    y: Annotated[float, NOISE, "North [m]."]
    z: Annotated[float, NOISE, "Up [m]; needed for positions in three dimensions."]
    range_m: Annotated[float, NOISE, "Range [m]."]
    azimuth_deg: Annotated[float, ANGLE_NOISE, "Azimuth [degrees]."]
    elevation_deg: Annotated[float, ANGLE_NOISE, "Elevation [degrees]."]
    range_rate_mps: Annotated[float, NOISE.said("a number > 0 in m/s"), "Range rate [m/s]."]
    bearing_deg: Annotated[float, ANGLE_NOISE, "Bearing [degrees]."]

    @staticmethod
    def rule(values: Mapping[str, Any]) -> str | None:
        """Return what was expected of columns of no one kind of measurement."""
        return None if set(values) in _SIGMAS else "one for each column of a measurement"


class FieldOfViewSection(Section):
    """Where a sensor sees: a ring sector around its position, a polygon, or what both share."""

    min_range_m: Annotated[float, Key("a number ≥ 0 in metres", 0, 1e9), "Nearest range [m]."]
    max_range_m: Annotated[float, Key("a number > 0 in metres", 1e-6, 1e9), "Farthest range [m]."]
    azimuth_deg: Annotated[
        tuple[Annotated[float, Key("", -360, 720)], ...],
        Key("two numbers from -360 to 720, such as [0, 360]", size=(2, 2)),
        "Where the sector starts and ends [degrees clockwise from north].",
    ]
    polygon: Annotated[
        tuple[Pair, ...],
        Key("at least three corners, such as [[0, 0], [9, 0], [0, 9]]", size=(3, math.inf)),
        "Corners of a polygon [m], in order.",
    ]

    @staticmethod
    def rule(values: Mapping[str, Any]) -> str | None:
        """Return what was expected of ranges that leave no ring."""
        is_ring = values.get("min_range_m", 0.0) < values.get("max_range_m", math.inf)
        return None if is_ring else "min_range_m below max_range_m"


class StrengthSection(Section, of=(StrengthModel,), needed=StrengthModel.NEEDED):
    """What the strength of a report tells of its origin: both kinds are about normal."""


class SensorSection(Section, of=(Sensor, Biases)):
    """What a sensor measures, how well and how often."""

    measurement: Annotated[
        str,
        Key(_or_plugin(KINDS), words=KINDS),
        "What its reports hold; read off the columns where left out.",
    ]
    sigma: Annotated[
        Annotated[float, NOISE] | SigmaTable,
        Key(
            "a number > 0 in metres, or one for each column: {x = 10.0, y = 12.0}, "
            "{range_m = 70.0, azimuth_deg = 0.08} or {bearing_deg = 1.0}"
        ),
        "Standard deviation of a report: of a position along each axis [m], or by column; a "
        "report's own columns come first.",
    ]
    clutter_per_scan: Annotated[
        float,
        POSITIVE.said("a number > 0 of false alarms per scan"),
        "False alarms per scan, uniform over what is covered; instead of ``clutter_density``.",
    ]
    rotation: Annotated[
        Literal["clockwise", "counter-clockwise", "none"],
        "How its beam turns, seen from above, where reports carry their own times; or that it "
        "does not, so that each time is a scan.",
    ]
    phase_deg: Annotated[
        float,
        Key("a number from 0 to 360 degrees", 0.0, 360.0),
        "Where its beam points at time 0 [degrees, clockwise from north]; with ``rotation`` and "
        "``scan_period`` its turn is as told. Left out = found from the reports.",
    ]
    position: Annotated[
        tuple[Annotated[float, COORDINATE], ...],
        Key("two or three numbers in metres, such as [0.0, 0.0]", size=(2, 3)),
        "Where the sensor stands, x, y[, z] [m].",
    ]
    place: Annotated[
        tuple[float, ...],
        PLACE,
        "The same as latitude, longitude [degrees][, altitude over the ellipsoid [m]].",
    ]
    field_of_view: Annotated[
        FieldOfViewSection,
        "Where it sees; left out = as its silence tells beside other sensors, else everywhere.",
    ]
    strength: Annotated[StrengthSection, "What the strength of its reports tells; or nothing."]

    @staticmethod
    def rule(values: Mapping[str, Any]) -> str | None:
        """Return what was expected of keys that say two things of one."""
        if "clutter_density" in values and "clutter_per_scan" in values:
            return "clutter_density or clutter_per_scan, not both"
        if "position" in values and "place" in values:
            return "position or place, not both"
        turns = values.get("rotation", "none") != "none"
        if "phase_deg" in values and not (turns and "scan_period" in values):
            return "a rotation and a scan_period beside phase_deg"
        if values.get("scans") is False and ("scan_period" in values or turns):
            return "scans = true with a scan_period or a rotation"
        return None


class SensorsSection(Section, entries=SensorSection):
    """Tables by the sensors' names; ``default`` for all."""


class TrackerSection(Section):
    """Which tracker gives reports to tracks."""

    kind: Annotated[
        Literal["multi-hypothesis", "nearest-neighbour"],
        "By a window of scans that later ones may amend, or scan by scan.",
    ] = "multi-hypothesis"
    pairing: Annotated[
        Literal["nearest", "one-to-one"],
        "Of nearest-neighbour: each track takes its own nearest report, or all together the "
        "pairs that are nearest in sum.",
    ] = "one-to-one"


class PlotsSection(Section, of=("trackweave.association.plots_rule:PlotsRule",)):
    """Whether plots that several sensors made at one instant are fused before they are tracked."""

    fuse: Annotated[bool, "Whether they are."] = False
    within: Annotated[
        float | Literal["period"],
        Key('a number ≥ 0 in seconds, or "period"', 0, 1e9),
        'How far apart the scans of one instant may be [s]; "period" = the shortest scan period.',
    ]
    keep_lone: Annotated[
        bool,
        "Whether positions where only one sensor looks become reports, for the tracker to judge.",
    ] = False


class WindowSection(Section, of=(Window,)):
    """The scans that are still open to change."""


class SolverSection(Section, is_open=True):
    """Which solver decides; further keys are the method's own."""

    method: Annotated[str, Key("the name of a solver"), "Name of a solver."]


class SearchSection(SolverSection, is_open=True):
    """How the best hypothesis of a window is found; further keys are the method's own."""

    deadline_ms: Annotated[
        float,
        POSITIVE.said("a number > 0 of milliseconds"),
        "Wall clock per scan [ms]; left out = none. With one, runs are not repeatable.",
    ]


class LifecycleSection(Section, of=(Lifecycle,)):
    """When tracks begin, are believed, and end."""

    confirm: Annotated[
        str,
        Key('text of the form "3/4": detections out of at most 100 opportunities', holds=_is_rate),
        "Detections out of opportunities that confirm a track.",
    ]
    divide: Annotated[
        bool, "Whether a track may end in two, as cells do: looked for after the run."
    ] = False
    join: Annotated[
        bool,
        "Whether tracks of one object, seen again after a silence, are brought under one name: "
        "looked for after the run.",
    ] = True
    merge: Annotated[float, NOISE, "Objects nearer than this may be one report of both [m]."]
    at_rest: Annotated[
        Literal["objects", "echoes"], "What stays at one place all the time is."
    ] = "objects"


class GrowthSection(Section, of=(GrowthLimits,)):
    """What bounds the number of sequences considered; larger is slower and surer."""


class LiveSection(Section):
    """What is believed of scans' times."""

    max_ahead: Annotated[
        float,
        SECONDS,
        "How far a scan's time may jump ahead of all others before it is held back, live, or "
        "in a recording stand apart from both its neighbours before it is set aside [s].",
    ] = MAX_AHEAD


class OutputSection(Section):
    """What is written."""

    period: Annotated[
        float, SECONDS, "Least time between rows of a track [s]; left out = every scan."
    ]
    estimate: Annotated[
        Literal["average", "best"],
        "What is told of a track: the average over its sequences, or the best hypothesis alone.",
    ] = "average"


class FrameSection(Section):
    """The plane on which latitudes and longitudes are laid."""

    origin: Annotated[
        tuple[float, ...],
        ORIGIN,
        "Latitude and longitude of the origin [degrees]; left out = the middle of the reports.",
    ]
    projection: Annotated[
        Literal["tangent", "stereographic"],
        "How the Earth is laid on the plane: seen along its normal, or true to angles, for "
        "wide areas.",
    ] = "tangent"


class StatisticSection(Section, of=("trackweave.fusion.statistic:Statistic",)):
    """What decides whether tracks may be of one object."""


class FusionSection(Section, of=("trackweave.fusion.associator:TrackAssociator",)):
    """How ``trackweave fuse`` makes objects of the tracks of several sensors."""

    # Trackers that follow one object share its turns: their errors are not independent.
    method: Annotated[
        Literal[
            "convex",
            "covariance-intersection",
            "fast-covariance-intersection",
            "information-matrix",
        ],
        "How estimates are combined.",
    ] = "fast-covariance-intersection"
    confirm: Annotated[
        str,
        Key(
            'text of the form "3/4": more than half of the last associations',
            holds=lambda rate: _is_rate(rate, math.inf, 0.5),
        ),
        "Declare a pairing that came out so often.",
    ]
    register: Annotated[
        bool, "Whether each sensor's shift, turn and clock beside the first is looked for."
    ] = False
    bias: Annotated[
        tuple[Annotated[str, Key(words=_BIASES)], ...],
        Key("some of translation, rotation, range, azimuth and clock", size=(1, math.inf)),
        "What ``register`` looks for.",
    ]
    statistic: StatisticSection
    search: SolverSection


class ConfigurationSection(Section):
    """Everything that ``tracker.toml`` can say; keys left out are estimated or take defaults."""

    seed: Annotated[
        int,
        Key("a whole number ≥ 0", 0, 2**63 - 1),
        "Seed of the random numbers; ``--seed`` comes first.",
    ]
    motion: MotionSection
    sensors: Annotated[SensorsSection, Key("tables such as [sensors.default]")]
    tracker: TrackerSection
    plots: PlotsSection
    window: WindowSection
    search: SearchSection
    lifecycle: LifecycleSection
    growth: GrowthSection
    live: LiveSection
    output: OutputSection
    frame: FrameSection
    fusion: FusionSection
