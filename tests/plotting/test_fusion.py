"""Figures of studies."""

import io

import matplotlib.image
import numpy as np

from trackweave.plotting.fusion import Curve, Sheet, picture_of_curves


def picture(**options: object) -> bytes:
    x = np.array([1.0, 10.0, 100.0])
    curves = {"one": Curve(x, np.array([1.0, np.nan, 0.0])), "two": Curve(x, x)}
    return picture_of_curves(Sheet("Title", "x", "y", **options), curves)  # type: ignore[arg-type]


def test_draws_curves_the_same_each_time() -> None:
    first = picture()
    assert first == picture()
    assert matplotlib.image.imread(io.BytesIO(first)).shape[:2] == (660, 1080)


def test_axes_may_be_logarithmic_and_have_words() -> None:
    plain = picture()
    assert picture(x_logarithmic=True, y_logarithmic=True) != plain
    assert picture(ticks={1.0: "a", 100.0: "b"}) != plain
