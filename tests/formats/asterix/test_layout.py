"""Layouts in lines of text, and the fields that they place."""

import numpy as np
import pytest

from trackweave.formats.asterix.cat048 import CATEGORY
from trackweave.formats.asterix.layout import Fixed, UndecodableError, parsed_layout
from trackweave.formats.asterix.records import Reader

LAYOUT = parsed_layout(
    """
010 A:4 B:12s
-
020 + C:7 | D:3 -4
030 ~ E:15
040 * F:8 G:8
050 {
  P 16
  -
  Q * 8
}
SP =
"""
)


def read(data: bytes) -> dict[str, int]:
    reader = Reader(LAYOUT)
    assert reader.take(data, 0, 0) == len(data)
    fields = reader.records(data).every_field()
    return {name: int(numbers[0]) for name, numbers, there in fields if there[0]}


def test_fields_lie_one_behind_another_and_may_be_negative() -> None:
    item = LAYOUT.named["010"]
    assert isinstance(item, Fixed)
    octets = np.frombuffer(b"\x00\x5f\xff\x57\xff", dtype=np.uint8)
    places = np.array([1, 3])
    assert [field.read(octets, places).tolist() for field in item.fields] == [[5, 5], [-1, 2047]]


def test_items_of_all_kinds_follow_one_another() -> None:
    data = bytes.fromhex("be5fff03600003 000402 0102 0304a0 abcd 01 0703 eeff")
    assert read(data) == {
        "010/A": 5, "010/B": -1, "020/C": 1, "020/D": 3, "030/1/E": 1, "030/2/E": 2,
        "040/1/F": 1, "040/1/G": 2, "040/2/F": 3, "040/2/G": 4, "050/P": 0xABCD, "050/Q/1": 7,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("data", "why"),
    [
        ("40", "not in use"),
        ("8180", "more items"),
        ("805f", "beyond"),
        ("ff", "beyond"),
        ("0200", "no length"),
        ("0440", "not in use"),
    ],
)
def test_what_is_no_record_is_said(data: str, why: str) -> None:
    with pytest.raises(UndecodableError, match=why):
        Reader(LAYOUT).take(bytes.fromhex(data), 0, 0)


def test_noise_fills_no_memory() -> None:
    layout, rng = CATEGORY.layouts[0], np.random.default_rng(1)
    for _ in range(6000):
        octets = rng.integers(0, 128, 4) * 2 | [1, 1, 1, 0]
        layout.plan(bytes(octets.tolist()))
    assert len(layout._plans) <= 4096
