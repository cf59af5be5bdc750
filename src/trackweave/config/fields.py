"""Kinds of values that keys take, each with its range and the words that describe it."""

import dataclasses
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

__all__ = [
    "Coordinate",
    "Count",
    "Expected",
    "Pair",
    "Positive",
    "Probability",
    "Section",
    "default_of",
    "one_of",
]


@dataclass(frozen=True, slots=True)
class Expected:
    """What an error message says was expected of a key.

    Parameters
    ----------
    text
        Goes after "expected".
    """

    text: str


class Section(BaseModel):
    """A table of the configuration: strict types, no unknown keys, no infinities."""

    model_config = ConfigDict(
        strict=True,
        extra="forbid",
        frozen=True,
        allow_inf_nan=False,
        use_attribute_docstrings=True,
    )


Positive = Annotated[float, Field(gt=0, le=1e15), Expected("a number > 0")]
Probability = Annotated[float, Field(gt=0, lt=1), Expected("a number between 0 and 1")]
Count = Annotated[int, Field(ge=1, le=1000), Expected("a whole number from 1 to 1000")]
Coordinate = Annotated[float, Field(ge=-1e9, le=1e9)]
# TOML has arrays, which strict validation would not take for tuples.
Pair = Annotated[
    list[Coordinate],
    Field(min_length=2, max_length=2),
    Expected("two numbers in brackets, such as [0.0, 0.0]"),
]


def default_of(kind: type, name: str) -> Any:
    """Return what a dataclass of the library takes where nothing is said.

    Parameters
    ----------
    kind
        The class.
    name
        The field.

    Returns
    -------
    Its default, so that files and library have one and the same.
    """
    fields: dict[str, Any] = {field.name: field.default for field in dataclasses.fields(kind)}
    return fields[name]


def one_of(words: tuple[str, ...]) -> AfterValidator:
    """Return the check of a key that takes one of a few words.

    Parameters
    ----------
    words
        What it may be.

    Returns
    -------
    What pydantic calls with the value.
    """

    def check(value: str) -> str:
        if value not in words:
            raise ValueError("unknown")
        return value

    return AfterValidator(check)
