"""What is wrong with all reports of a sensor alike."""

from dataclasses import dataclass
from typing import Annotated

from trackweave.fields import settle
from trackweave.keys import Key, Pair

__all__ = ["Biases"]


@dataclass(frozen=True, slots=True)
class Biases:
    """What is wrong with all reports of a sensor alike.

    It is taken out of reports before they are tracked; a tracker is given them without.

    Parameters
    ----------
    range_bias_m
        How much too long its ranges are [m].
    range_scale
        How many times as long as the true ones its ranges are, beside that.
    azimuth_bias_deg
        How much too great its azimuths or bearings are, as where its north is not north
        [degrees, clockwise].
    translation
        How far its positions are shifted, east and north [m]; of sensors that report them.
    clock_offset
        How far its clock is ahead [s].
    """

    range_bias_m: Annotated[float, Key("a number of metres", -1e6, 1e6)] = 0.0
    range_scale: Annotated[float, Key("a number from 0.5 to 2, such as 1.001", 0.5, 2.0)] = 1.0
    azimuth_bias_deg: Annotated[float, Key("a number from -180 to 180 degrees", -180, 180)] = 0.0
    translation: Pair = (0.0, 0.0)
    clock_offset: Annotated[float, Key("a number of seconds", -1e6, 1e6)] = 0.0

    def __post_init__(self) -> None:
        settle(self)
