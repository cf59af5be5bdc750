"""The tables of ``tracker.toml`` on how objects move."""

from typing import Annotated, ClassVar, Literal

from pydantic import ConfigDict, Field, model_validator

from trackweave.config.fields import Expected, Section, Speed, one_of

__all__ = ["MODELS", "ImmSection", "ModeSection", "MotionSection"]

MODELS = ("constant-velocity", "constant-acceleration", "coordinated-turn", "random-walk")
_WORDS = ", ".join(f'"{name}"' for name in (*MODELS, "imm"))

ProcessNoise = Annotated[
    float,
    Field(ge=0, le=1e12),
    Expected("a number ≥ 0 in m²/s³"),
]
Acceleration = Annotated[float, Field(ge=1e-12, le=1e12), Expected("a number > 0 in m/s²")]
TurnNoise = Annotated[float, Field(ge=0, le=1e6), Expected("a number ≥ 0 in rad²/s³")]
TurnRate = Annotated[float, Field(ge=1e-9, le=1e3), Expected("a number > 0 in rad/s")]
Model = Annotated[
    str,
    one_of((*MODELS, "imm")),
    Field(json_schema_extra={"enum": [*MODELS, "imm"]}),
    Expected(f"one of {_WORDS}, or the name of a plug-in"),
]
Mode = Annotated[
    str,
    one_of(MODELS),
    Field(json_schema_extra={"enum": list(MODELS)}),
    Expected("one of " + ", ".join(f'"{name}"' for name in MODELS)),
]


class _Moving(Section):
    """What every way to move may say."""

    process_noise: ProcessNoise | None = None
    """Power spectral density of the acceleration along each axis [m²/s³]; of the jerk [m²/s⁵] for
    constant-acceleration, of the velocity [m²/s] for random-walk."""

    turn_noise: TurnNoise | None = None
    """Power spectral density of the turn rate's change [rad²/s³]; for coordinated-turn."""

    max_speed: Speed | None = None
    """How fast an object can be [m/s]; also the spread of a new track's velocity."""

    max_acceleration: Acceleration | None = None
    """Greatest acceleration [m/s²]; for constant-acceleration."""

    max_turn_rate: TurnRate | None = None
    """Greatest turn rate to either side [rad/s]; for coordinated-turn."""


class ModeSection(_Moving):
    """One of the ways to move between which objects change."""

    model: Mode | None = None
    """Which way to move; left out = the one of the table's name."""


class ImmSection(Section):
    """The ways to move between which objects change; further tables are theirs, by name."""

    model_config = ConfigDict(extra="allow")
    entries: ClassVar[type[Section]] = ModeSection
    __pydantic_extra__: dict[str, ModeSection] = Field(init=False)

    models: (
        Annotated[
            list[str],
            Field(min_length=2, max_length=8),
            Expected('two to eight names, such as ["constant-velocity", "coordinated-turn"]'),
        ]
        | None
    ) = None
    """Names of the ways to move: of models, or of tables here that say which model."""

    sojourn_time: (
        Annotated[
            list[Annotated[float, Field(ge=1e-6, le=1e9)]],
            Field(min_length=2, max_length=8),
            Expected("a number > 0 of seconds for each model, such as [60.0, 15.0]"),
        ]
        | None
    ) = None
    """How long an object stays in each on average [s]."""

    @model_validator(mode="after")
    def _names_known(self) -> "ImmSection":
        tables = self.model_extra or {}
        for name in [*(self.models or ()), *tables]:
            if name not in MODELS and getattr(tables.get(name), "model", None) is None:
                raise ValueError(f'"{name}" to be a model, or a table whose key model says one')
        if self.models is not None and len(set(self.models)) < len(self.models):
            raise ValueError("each name once; a table with a key model gives another name")
        return self


class MotionSection(_Moving):
    """How objects move."""

    model: Model | None = None
    """How objects move: what wanders, or imm for changes between several ways."""

    filter: (
        Annotated[Literal["extended", "unscented"], Expected('"extended" or "unscented"')] | None
    ) = None
    """How measurements that are not linear are taken: by slopes or by sigma points."""

    imm: ImmSection | None = None
    """The ways to move between which objects change, where the model is imm."""
