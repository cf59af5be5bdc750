"""Records of one category: where they begin and end, and their fields, all records at once."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from trackweave.formats.asterix.layout import (
    Compound,
    Explicit,
    Item,
    Octets,
    Places,
    Plan,
    UndecodableError,
)

__all__ = ["Reader", "Records"]

# As far beyond the last octet fields and items may look where they are not there.
_MARGIN = 256


class Reader:
    """Goes through data blocks of one category and gathers their records.

    Parameters
    ----------
    layout
        The category's items.
    """

    def __init__(self, layout: Compound) -> None:
        self.layout = layout
        self.count = 0
        self._groups: dict[bytes, tuple[Plan, list[int]]] = {}

    def take(self, block: bytes, place: int, base: int) -> int:
        """Enter the record that begins at a place of a block; return where it ends.

        Parameters
        ----------
        block
            The data block.
        place
            Where the record begins in it.
        base
            Where the block begins in the buffer.

        Returns
        -------
        Where the record ends in the block.

        Raises
        ------
        UndecodableError
            If the record is not as its category says.
        """
        try:
            end = place
            while block[end] & 1:
                end += 1
            end += 1
            specification = block[place:end]
            group = self._groups.get(specification)
            if group is None:
                group = self._groups[specification] = (self.layout.plan(specification), [])
            plan, marks = group
            found = [self.count, base + place, base + end]
            for gap, measure in plan.steps:
                end = measure(block, end + gap)
                found.append(base + end)
            end += plan.tail
        except IndexError:
            end = len(block) + 1
        if end > len(block):
            raise UndecodableError("a record that goes on beyond its data block")
        marks += found
        self.count += 1
        return end

    def records(self, buffer: bytes) -> "Records":
        """Return the records that were gathered from a buffer."""
        return Records(self.layout, buffer, self.count, list(self._groups.values()))


class Records:
    """Records of one category, in the order of the stream.

    Parameters
    ----------
    layout
        The category's items.
    buffer
        The octets in which they lie.
    count
        How many there are.
    groups
        Records with the same items: how to go through them, and for each its number and where it,
        its first item, and what follows each item of varying length begin.
    """

    def __init__(
        self, layout: Compound, buffer: bytes, count: int, groups: list[tuple[Plan, list[int]]]
    ) -> None:
        self._layout = layout
        self._octets: Octets = np.frombuffer(buffer + bytes(_MARGIN), dtype=np.uint8)
        self.count = count
        self._groups = [
            (plan, np.array(marks, dtype=np.int64).reshape(-1, 3 + len(plan.steps)))
            for plan, marks in groups
        ]
        self._places: dict[str, Places] = {}
        self.begin = np.zeros(count, dtype=np.int64)
        for _, marks in self._groups:
            self.begin[marks[:, 0]] = marks[:, 1]

    def places(self, item: str) -> Places:
        """Return where an item such as "040" or "130/SAM" begins, -1 where it is not there."""
        if item not in self._places:
            outer, _, inner = item.partition("/")
            if inner:
                self._places[item] = self._inner_places(outer, inner)
            else:
                self._places[item] = self._top_places(item)
        return self._places[item]

    def _inner_places(self, outer: str, inner: str) -> Places:
        layout, places = self._layout.named[outer], self.places(outer)
        if not isinstance(layout, Explicit):
            return _inside(layout).places_of(inner, self._octets, places)
        within = np.where(places >= 0, places + 1, -1)
        found = _inside(layout).places_of(inner, self._octets, within)
        ends = _inside(layout).named[inner].ends(self._octets, found)
        return np.where(ends <= layout.ends(self._octets, places), found, -1)

    def _top_places(self, item: str) -> Places:
        places = np.full(self.count, -1)
        for plan, marks in self._groups:
            if item in plan.where:
                step, gap = plan.where[item]
                places[marks[:, 0]] = marks[:, 2 + step] + gap
        return places

    def read(self, item: str, field: str = "") -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """Return an item's field, the first of a repeated item, and where it is there."""
        outer, _, inner = item.partition("/")
        layout = self._layout.named[outer]
        if inner:
            layout = _inside(layout).named[inner]
        places = self.places(item)
        if not isinstance(layout, Compound):
            for here, fixed in layout.elements(self._octets, places):
                for each in fixed.fields:
                    if each.name == field:
                        return each.read(self._octets, here), here >= 0
        return np.zeros(self.count, dtype=np.int64), np.zeros(self.count, dtype=np.bool_)

    def number(self, item: str, field: str = "", scale: float = 1.0) -> NDArray[np.float64]:
        """Return a field times its unit, NaN where it is not there."""
        values, there = self.read(item, field)
        return np.where(there, values * scale, np.nan)

    def flag(self, item: str, field: str) -> NDArray[np.bool_]:
        """Return where a field is there and not 0."""
        values, there = self.read(item, field)
        return np.logical_and(there, values)

    def knows(self, item: str) -> bool:
        """Return whether the layout has an item."""
        return item in self._layout.named

    def has(self, item: str) -> NDArray[np.bool_]:
        """Return where an item is there."""
        return self.places(item) >= 0

    def every_field(self) -> Iterator[tuple[str, NDArray[np.int64], NDArray[np.bool_]]]:
        """Yield all fields: a name such as "130/SAM" or "250/2/BDS", numbers, where it is."""
        for outer, layout in self._layout.named.items():
            if isinstance(layout, Compound):
                for inner, nested in layout.named.items():
                    yield from self._fields(f"{outer}/{inner}", nested)
            else:
                yield from self._fields(outer, layout)

    def _fields(
        self, item: str, layout: Item
    ) -> Iterator[tuple[str, NDArray[np.int64], NDArray[np.bool_]]]:
        assert not isinstance(layout, Compound)
        for number, (here, fixed) in enumerate(layout.elements(self._octets, self.places(item))):
            place = str(number + 1) if getattr(layout, "repeated", False) else ""
            for each in fixed.fields:
                name = "/".join(filter(None, (item, place, each.name)))
                yield name, each.read(self._octets, here), here >= 0


def _inside(item: Item) -> Compound:
    """Return the items inside an item."""
    inside = item.inner if isinstance(item, Explicit) else item
    assert isinstance(inside, Compound)
    return inside
