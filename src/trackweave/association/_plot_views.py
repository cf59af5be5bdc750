"""What sensors cover that made no plot of an object. Nothing here checks or raises."""

import math
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.jit import jit
from trackweave.models._kernels import covered_share
from trackweave.models.coverage import Coverage


class Views(NamedTuple):
    """What each sensor covers, and how surely it reports it.

    ``is_bounded`` is False of a sensor that sees everywhere, and ``any_bounded`` if all do.
    ``bounds`` are those of a `Coverage`; of all polygons' corners, those from ``first_corner``
    on are the sensor's.
    """

    any_bounded: bool
    is_bounded: np.ndarray
    detection: FloatArray
    position: FloatArray
    bounds: FloatArray
    first_corner: IntArray
    corner: FloatArray


@jit
def unseen_price(
    views: Views, sensor: IntArray, mean: FloatArray, covariance: FloatArray
) -> float:
    """Return what it costs that only these sensors saw an object there [nats].

    Of the sensors that do not see everywhere; ``sensor`` ascends. A chance to see the object that
    depends on where it is counts by its average over where it may be.
    """
    price = 0.0
    entry = 0
    for other in range(views.detection.shape[0]):
        if entry < sensor.shape[0] and sensor[entry] == other:
            entry += 1
        elif views.is_bounded[other]:
            corners = views.corner[views.first_corner[other] : views.first_corner[other + 1]]
            coverage = Coverage(
                False, views.position[other], views.bounds[other], corners, np.zeros(3)
            )
            share = covered_share(mean, covariance, coverage)
            price -= math.log1p(-views.detection[other] * share)
    return price
