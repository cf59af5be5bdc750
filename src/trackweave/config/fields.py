"""Kinds of values that keys take, each with its range and the words that describe it."""

import dataclasses
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from trackweave.domain.reports import ANGLE_NOISE_DEG, NOISE_M

__all__ = [
    "AngleNoise",
    "Coordinate",
    "Count",
    "Density",
    "Expected",
    "Noise",
    "Pair",
    "Positive",
    "Probability",
    "Seconds",
    "Section",
    "Speed",
    "default_of",
    "one_of",
]


@dataclass(frozen=True, slots=True)
class Expected:
    """What an error message says was expected of a key."""

    text: str  # Goes after "expected"


class Section(BaseModel):
    """A table of the configuration: strict types, no unknown keys, no infinities."""

    model_config = ConfigDict(
        strict=True,
        extra="forbid",
        frozen=True,
        allow_inf_nan=False,
        use_attribute_docstrings=True,
    )


# Ranges end where nothing real goes on, far from where squares and products of 16 digits do.
Positive = Annotated[float, Field(ge=1e-9, le=1e9), Expected("a number > 0")]
"""What is counted or compared: false alarms of a scan, distances in units of noise, nats."""
Noise = Annotated[float, Field(ge=NOISE_M[0], le=NOISE_M[1]), Expected("a number > 0 in metres")]
AngleNoise = Annotated[
    float,
    Field(ge=ANGLE_NOISE_DEG[0], le=ANGLE_NOISE_DEG[1]),
    Expected("a number > 0 of degrees, at most 180"),
]
Density = Annotated[float, Field(ge=1e-30, le=1e30), Expected("a number > 0")]
"""From one in a cube of ten million kilometres to one in that of an atom."""
Seconds = Annotated[float, Field(ge=1e-6, le=1e9), Expected("a number > 0 in seconds")]
"""From the last digit of times since 1970, a microsecond, to three decades."""
Speed = Annotated[float, Field(ge=1e-12, le=3e8), Expected("a number > 0 in m/s")]
"""From a thirtieth of a millimetre a year to light."""
Probability = Annotated[float, Field(ge=1e-12, le=1 - 1e-12), Expected("a number between 0 and 1")]
"""Beyond are certainties, which no number of reports could amend."""
Count = Annotated[int, Field(ge=1, le=1000), Expected("a whole number from 1 to 1000")]
Coordinate = Annotated[float, Field(ge=-1e9, le=1e9)]
# TOML has arrays, which strict validation would not take for tuples.
Pair = Annotated[
    list[Coordinate],
    Field(min_length=2, max_length=2),
    Expected("two numbers in brackets, such as [0.0, 0.0]"),
]


def default_of(kind: type, name: str) -> Any:
    """Return a field's default in a class of the library: files and library have the same."""
    fields: dict[str, Any] = {field.name: field.default for field in dataclasses.fields(kind)}
    return fields[name]


def one_of(words: tuple[str, ...]) -> AfterValidator:
    """Return the check, for pydantic, of a key that takes one of a few words."""

    def check(value: str) -> str:
        if value not in words:
            raise ValueError("unknown")
        return value

    return AfterValidator(check)
