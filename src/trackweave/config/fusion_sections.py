"""The table ``[fusion]`` of ``tracker.toml``: how tracks of several sensors become objects."""

from typing import Annotated, Literal

from pydantic import AfterValidator, ConfigDict, Field

from trackweave.config.fields import Count, Expected, Positive, Section, one_of

__all__ = ["FusionSection", "SolverSection", "StatisticSection"]

Share = Annotated[float, Field(gt=0, lt=1), Expected("a number between 0 and 1")]
Bias = Annotated[
    str, one_of(("translation", "rotation", "range", "azimuth", "clock")),
]  # fmt: skip


def _confirmation(value: str) -> str:
    needed, slash, of = value.partition("/")
    if not (slash and needed.isdecimal() and of.isdecimal()):
        raise ValueError("form")
    if not int(needed) <= int(of) < 2 * int(needed):
        raise ValueError("range")
    return value


class SolverSection(Section):
    """Which solver decides; further keys are the method's own."""

    # Checked against the solver itself, which takes a second to import.
    model_config = ConfigDict(extra="allow")

    method: Annotated[str, Expected("the name of a solver")] | None = None
    """Name of a solver."""


class StatisticSection(Section):
    """What decides whether tracks may be of one object."""

    kind: (
        Annotated[
            Literal["chain", "all-pairs", "fused-mean"],
            Expected('"chain", "all-pairs" or "fused-mean"'),
        ]
        | None
    ) = None
    """Distances of neighbouring sensors, of all pairs, or to the fused mean."""

    memory: (
        Annotated[Literal["full", "sliding", "fading"], Expected('"full", "sliding" or "fading"')]
        | None
    ) = None
    """All times count, the last ``length``, or each ``factor`` times as much as the next."""

    length: Count | None = None
    """How many times a sliding memory holds."""

    factor: Share | None = None
    """What a fading memory keeps from time to time."""

    false_rejection: Share | None = None
    """Probability of rejecting tracks of one object."""

    correlation: (
        Annotated[
            Literal["none", "inflated", "effective", "cross-covariance", "both"],
            Expected('"none", "inflated", "effective", "cross-covariance" or "both"'),
        ]
        | None
    ) = None
    """What to do about correlated errors."""

    inflation: Positive | None = None
    """Factor on the covariances, for ``correlation = "inflated"``."""


class FusionSection(Section):
    """How ``trackweave fuse`` makes objects of the tracks of several sensors."""

    method: (
        Annotated[
            Literal[
                "convex", "covariance-intersection", "fast-covariance-intersection",
                "information-matrix",
            ],
            Expected(
                'one of "convex", "covariance-intersection", "fast-covariance-intersection" and '
                '"information-matrix"'
            ),
        ]
        | None
    ) = None  # fmt: skip
    """How estimates are combined."""

    process_noise: (
        Annotated[float, Field(ge=0, le=1e15), Expected("a number ≥ 0 in m²/s³")] | None
    ) = None
    """Power spectral density of the acceleration [m²/s³]; left out, told from covariances."""

    confirm: (
        Annotated[
            str,
            AfterValidator(_confirmation),
            Expected('text of the form "3/4": more than half of the last associations'),
        ]
        | None
    ) = None
    """Declare a pairing that came out so often."""

    complete: Annotated[bool, Expected("true or false")] | None = None
    """Whether every sensor sees every object, and each track is in one tuple with one of each."""

    hysteresis: (
        Annotated[float, Field(ge=1e-6, le=1), Expected("a number above 0 and at most 1")] | None
    ) = None
    """What is held is tested at so many times the rate of false rejection."""

    patience: Annotated[float, Field(ge=1, le=1e9), Expected("a number ≥ 1")] | None = None
    """A sensor's tracks count until it is silent for so many of its periods."""

    register_: (
        Annotated[bool, Expected("true or false")] | None
    ) = Field(default=None, alias="register")  # fmt: skip
    """Whether each sensor's shift, turn and clock beside the first is looked for."""

    bias: (
        Annotated[
            list[Bias],
            Field(min_length=1),
            Expected("some of translation, rotation, range, azimuth and clock"),
        ]
        | None
    ) = None
    """What ``register`` looks for."""

    statistic: StatisticSection = StatisticSection()
    search: SolverSection = SolverSection()
