"""The coastline's file."""

import numpy as np
import pytest

from trackweave.service.picture.land import encode_land, land_around, whole_land

BARCELONA = (1.2, 40.9, 3.0, 41.9)


def decoded(raw: bytes) -> list[np.ndarray]:
    """Return rings as ``coast.js`` does, a byte at a time."""
    numbers, value, shift = [], 0, 0
    for byte in raw:
        value |= (byte & 127) << shift
        shift += 7
        if byte < 128:
            numbers.append(value)
            value = shift = 0
    rings, place, at = [], np.zeros(2), 0
    while at < len(numbers):
        n, ring = numbers[at], []
        for k in range(n):
            steps = numbers[at + 1 + 2 * k : at + 3 + 2 * k]
            place = place + [(-(step + 1) // 2 if step % 2 else step // 2) for step in steps]
            ring.append(place / 1000)
        rings.append(np.array(ring))
        at += 1 + 2 * n
    return rings


def is_land(rings: list[np.ndarray], x: float, y: float) -> bool:
    """Return whether a ray to the east crosses coasts an odd number of times."""
    crossings = 0
    for ring in rings:
        (x0, y0), (x1, y1) = ring.T, np.roll(ring, -1, axis=0).T
        spans = (y0 > y) != (y1 > y)
        at = x0[spans] + (y - y0[spans]) / (y1[spans] - y0[spans]) * (x1[spans] - x0[spans])
        crossings += int((at > x).sum())
    return crossings % 2 == 1


def test_rings_come_back_to_a_thousandth_of_a_degree() -> None:
    rng = np.random.default_rng(3)
    rings = [rng.uniform([-180, -90], [180, 90], (n, 2)) for n in (3, 50, 400)]
    for ring, found in zip(rings, decoded(encode_land(rings)), strict=True):
        np.testing.assert_allclose(found, ring, atol=0.00051)


@pytest.mark.parametrize(
    ("x", "y", "is_it"),
    [(-3.7, 40.4, True), (-30.0, 35.0, False), (2.6, 41.2, False), (1.9, 41.6, True),
     (134.0, -25.0, True), (-100.0, 40.0, True), (170.0, 0.0, False)],
)  # fmt: skip
def test_land_is_where_it_is_far_and_near(x: float, y: float, is_it: bool) -> None:
    assert is_land(decoded(whole_land()), x, y) is is_it
    assert is_land(decoded(land_around(*BARCELONA)), x, y) is is_it


def test_a_box_has_all_points_inside_and_few_elsewhere() -> None:
    west, south, east, north = BARCELONA

    def inside(rings: list[np.ndarray]) -> set[tuple[float, float]]:
        points = np.concatenate(rings)
        kept = (points >= [west, south]).all(axis=1) & (points <= [east, north]).all(axis=1)
        return {(round(x, 3), round(y, 3)) for x, y in points[kept].tolist()}

    around = land_around(*BARCELONA)
    assert inside(decoded(around)) == inside(decoded(whole_land()))
    assert len(inside(decoded(around))) > 10
    assert len(around) < len(whole_land()) / 2


def test_a_box_a_turn_further_on_is_the_same() -> None:
    west, south, east, north = BARCELONA
    assert land_around(west + 360, south, east + 360, north) == land_around(*BARCELONA)
