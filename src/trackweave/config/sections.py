"""The tables of ``tracker.toml``, key by key.

A key that is left out is None here and is filled later, from the data or by a default.
"""

from dataclasses import replace
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, PrivateAttr

from trackweave.config.fields import (
    Count,
    Density,
    Expected,
    Positive,
    Probability,
    Seconds,
    Section,
)
from trackweave.config.fusion_sections import FusionSection, SolverSection
from trackweave.config.motion_sections import MODELS, MotionSection
from trackweave.config.plugins import NO_PLUGINS, Plugins, taken_apart
from trackweave.config.sensor_sections import (
    KINDS,
    FieldOfViewSection,
    SensorSection,
    SigmaTable,
)

__all__ = [
    "Configuration",
    "FieldOfViewSection",
    "FrameSection",
    "FusionSection",
    "GrowthSection",
    "LifecycleSection",
    "LiveSection",
    "MotionSection",
    "OutputSection",
    "PlotsSection",
    "SearchSection",
    "SensorSection",
    "SigmaTable",
    "TrackerSection",
    "WindowSection",
]


class WindowSection(Section):
    """The scans that are still open to change."""

    depth: Annotated[Count, Field(le=50), Expected("a whole number from 1 to 50")] | None = None
    """Scans of the slowest periodic sensor; the others' scans of that time are inside too."""

    max_scans: Annotated[Count, Field(le=200), Expected("a whole number from 1 to 200")] | None = (
        None
    )
    """Most scans over all sensors; older ones are fixed."""


class SearchSection(SolverSection):
    """How the best hypothesis of a window is found; further keys are the method's own."""

    deadline_ms: Annotated[Positive, Expected("a number > 0 of milliseconds")] | None = None
    """Wall clock per scan [ms]; left out = none. With one, runs are not repeatable."""


class TrackerSection(Section):
    """Which tracker gives reports to tracks."""

    kind: (
        Annotated[
            Literal["multi-hypothesis", "nearest-neighbour"],
            Expected('"multi-hypothesis" or "nearest-neighbour"'),
        ]
        | None
    ) = None
    """By a window of scans that later ones may amend, or scan by scan."""

    pairing: (
        Annotated[Literal["nearest", "one-to-one"], Expected('"nearest" or "one-to-one"')] | None
    ) = None
    """Of nearest-neighbour: each track takes its own nearest report, or all together the
    pairs that are nearest in sum."""


class PlotsSection(Section):
    """Whether plots that several sensors made at one instant are fused before they are tracked."""

    fuse: Annotated[bool, Expected("true or false")] | None = None
    """Whether they are."""

    within: (
        Annotated[
            Annotated[float, Field(ge=0, le=1e9)] | Literal["period"],
            Expected('a number ≥ 0 in seconds, or "period"'),
        ]
        | None
    ) = None
    """How far apart the scans of one instant may be [s]; "period" = the shortest scan period."""

    cost: (
        Annotated[Literal["evidence", "equation-1"], Expected('"evidence" or "equation-1"')] | None
    ) = None
    """What a tuple of plots costs: by its evidence, or by eq. 1 of Wiranto and Bonok."""

    gate: Annotated[Positive, Expected("a number > 0")] | None = None
    """Greatest squared distance of a plot from the tuple that it joins."""

    object_density: Annotated[Density, Expected("a number > 0 per m² (m³)")] | None = None
    """Objects expected per m² (m³), for the evidence."""

    keep_lone: Annotated[bool, Expected("true or false")] | None = None
    """Whether positions where only one sensor looks become reports, for the tracker to judge."""

    max_tuples: (
        Annotated[int, Field(ge=1, le=10**7), Expected("a whole number from 1 to 10000000")] | None
    ) = None
    """Greatest number of tuples at one instant; where there would be more, far plots are left
    out."""


def _confirmation(value: str) -> str:
    hits, slash, opportunities = value.partition("/")
    if not (slash and hits.isdecimal() and opportunities.isdecimal()):
        raise ValueError("form")
    if not 1 <= int(hits) <= int(opportunities) <= 100:
        raise ValueError("range")
    return value


class LifecycleSection(Section):
    """When tracks begin, are believed, and end."""

    confirm: (
        Annotated[
            str,
            AfterValidator(_confirmation),
            Expected('text of the form "3/4": detections out of at most 100 opportunities'),
        ]
        | None
    ) = None
    """Detections out of opportunities that confirm a track."""

    confirm_probability: (
        Annotated[float, Field(ge=0, le=1 - 1e-12), Expected("a number from 0 to below 1")] | None
    ) = None
    """How probable a track's object must be, besides, for the track to be confirmed."""

    certain_probability: (
        Annotated[float, Field(ge=1e-12, le=1), Expected("a number above 0, at most 1")] | None
    ) = None
    """How probable an object must be for its track to be confirmed at once; 1 = never."""

    delete_after_misses: Count | None = None
    """Misses in succession that end a track; left out = when its object is probably gone."""

    hidden_share: (
        Annotated[float, Field(ge=0, le=0.9), Expected("a number from 0 to 0.9")] | None
    ) = None
    """Share of their time for which objects are where no sensor can see them; 0 = never."""

    mean_silence: Seconds | None = None
    """How long they are hidden then, on average [s]."""

    rejoin: Seconds | None = None
    """For so long a track may be taken up again [s]; left out = as is probable."""

    new_target_density: (
        Annotated[Density, Expected("a number > 0 per m² (m³) and scan")] | None
    ) = None
    """Objects newly present per m² (m³) of tracking space and scan."""

    initial_target_density: Annotated[Density, Expected("a number > 0 per m² (m³)")] | None = None
    """Objects present per m² (m³) before the first scan."""

    survival: (
        Annotated[Probability, Expected("a number between 0 and 1, both excluded")] | None
    ) = None
    """Chance that an object is still there one scan period later."""


class OutputSection(Section):
    """What is written."""

    period: Seconds | None = None
    """Least time between rows of a track [s]; left out = every scan."""

    estimate: Annotated[Literal["average", "best"], Expected('"average" or "best"')] | None = None
    """What is told of a track: the average over its sequences, or the best hypothesis alone."""


class GrowthSection(Section):
    """What bounds the number of sequences considered; larger is slower and surer."""

    margin: Annotated[Positive, Expected("a number > 0 in nats")] | None = None
    """How far behind the best a track's sequence may lie and grow on [nats]."""

    keep: Count | None = None
    """Greatest number of sequences on which a track grows."""

    new_margin: Annotated[Positive, Expected("a number > 0 in nats")] | None = None
    """The same as ``margin`` for an object that begins in the window [nats]."""

    new_keep: Count | None = None
    """The same as ``keep`` for an object that begins in the window."""

    new_ceiling: Annotated[Positive, Expected("a number > 0 in nats")] | None = None
    """How far above the price of its first report such a sequence may lie [nats]."""

    max_nodes: (
        Annotated[int, Field(ge=1, le=10**8), Expected("a whole number from 1 to 100000000")]
        | None
    ) = None
    """Greatest number of sequences looked at together."""


class LiveSection(Section):
    """What is believed of scans' times."""

    max_ahead: (
        Annotated[float, Field(gt=0, le=1e9), Expected("a number > 0 in seconds")] | None
    ) = None
    """How far a scan's time may jump ahead of all others before it is held back, live, or in a
    recording stand apart from both its neighbours before it is set aside [s]."""


class FrameSection(Section):
    """The plane on which latitudes and longitudes are laid."""

    origin: (
        Annotated[
            list[float],
            Field(min_length=2, max_length=2),
            AfterValidator(lambda value: _on_earth(value)),
            Expected("[latitude, longitude] in degrees, from -90 to 90 and -180 to 360"),
        ]
        | None
    ) = None
    """Latitude and longitude of the origin [degrees]; left out = the middle of the reports."""

    projection: (
        Annotated[Literal["tangent", "stereographic"], Expected('"tangent" or "stereographic"')]
        | None
    ) = None
    """How the Earth is laid on the plane: seen along its normal, or true to angles, for wide
    areas."""


def _on_earth(value: list[float]) -> list[float]:
    if not (-90 <= value[0] <= 90 and -180 <= value[1] <= 360):
        raise ValueError("range")
    return value


class Configuration(Section):
    """Everything that ``tracker.toml`` can say; keys left out are estimated or take defaults."""

    _name: str = PrivateAttr("configuration")
    _plugins: Plugins = PrivateAttr(NO_PLUGINS)

    seed: Annotated[int, Field(ge=0, lt=2**63), Expected("a whole number ≥ 0")] | None = None
    """Seed of the random numbers; ``--seed`` comes first."""

    motion: MotionSection = MotionSection()
    sensors: Annotated[dict[str, SensorSection], Expected("tables such as [sensors.default]")] = {}  # noqa: RUF012 pydantic copies defaults
    tracker: TrackerSection = TrackerSection()
    plots: PlotsSection = PlotsSection()
    window: WindowSection = WindowSection()
    search: SearchSection = SearchSection()
    lifecycle: LifecycleSection = LifecycleSection()
    growth: GrowthSection = GrowthSection()
    live: LiveSection = LiveSection()
    output: OutputSection = OutputSection()
    frame: FrameSection = FrameSection()
    fusion: FusionSection = FusionSection()

    @classmethod
    def of(cls, values: Any) -> "Configuration":
        """Return what a file's keys say, those of plug-ins among them."""
        rest, plugins = taken_apart(values, {"motion": (*MODELS, "imm"), "measurement": KINDS})
        made = cls.model_validate(rest)
        made._plugins = plugins  # noqa: SLF001 a new one of ourselves
        return made

    @property
    def name(self) -> str:
        """What messages call the file."""
        return self._name

    @property
    def plugins(self) -> Plugins:
        """What the file names from outside the package."""
        return replace(self._plugins, file=self._name)

    def called(self, name: str) -> "Configuration":
        """Return the same under another name in messages."""
        named = self.model_copy()
        named._name = name  # noqa: SLF001 a copy of ourselves
        return named

    def as_file(self) -> dict[str, Any]:
        """Return the keys that were given, nested as in the file."""
        return self._plugins.put_back(self.model_dump(exclude_unset=True, by_alias=True))
