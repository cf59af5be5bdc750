"""What ASTERIX items are made of, said in lines of text, and where their fields lie.

A layout is a line for each item, in the order of the category's user application profile::

    010 SAC:8 SIC:8                     fields with their bits
    090 V:1 G:1 FL:14s                  two's complement
    140 24                              one number without a name
    020 + TYP:3 -3 RAB:1 | TST:1 -6     octets that each say whether another follows
    510 ~ ID:8 TRACK:15                 an element repeated for as long as its last bit is set
    250 * MB:56 BDS:8                   an element repeated as often as an octet says
    SP  =                               as long as its first octet says; "= {" says what is in it
    -                                   an item that is not in use
    130 {                               items of which the first octets say which are there
      SRL 8
    }

Items are measured one by one as plain numbers, which finds where records end, and read all at
once with NumPy.
"""

from collections.abc import Callable, Iterator
from itertools import cycle
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Chained",
    "Compound",
    "Explicit",
    "Field",
    "Fixed",
    "Item",
    "Octets",
    "Places",
    "Plan",
    "Repeated",
    "UndecodableError",
    "parsed_layout",
]

# As many are kept: what is sent has some dozens, noise any number.
_MOST_PLANS = 4096

Places: TypeAlias = NDArray[np.int64]
Octets: TypeAlias = NDArray[np.uint8]
Measure: TypeAlias = Callable[[bytes, int], int]


class UndecodableError(Exception):
    """A record that is not as its category says; never leaves the package."""


class Field(NamedTuple):
    """Some bits of an item."""

    name: str
    bit: int
    """How many bits of the item come before."""
    width: int
    signed: bool

    def read(self, octets: Octets, places: Places) -> NDArray[np.int64]:
        """Return the numbers in items that begin at ``places``."""
        first, end = self.bit // 8, (self.bit + self.width + 7) // 8
        value = octets[places + first].astype(np.int64)
        for octet in range(first + 1, end):
            value <<= 8
            value |= octets[places + octet]
        value >>= end * 8 - self.bit - self.width
        if self.width < 8 * (end - first):
            value &= (1 << self.width) - 1
        if self.signed:
            value -= (value >> (self.width - 1)) << self.width
        return value


class Fixed(NamedTuple):
    """An item that is always as long."""

    size: int
    fields: tuple[Field, ...]

    def measure(self, block: bytes, place: int) -> int:
        """Return where an item that begins at ``place`` ends."""
        return place + self.size

    def ends(self, octets: Octets, places: Places) -> Places:
        """Return where items that begin at ``places`` end."""
        return places + self.size

    def elements(self, octets: Octets, places: Places) -> Iterator[tuple[Places, "Fixed"]]:
        """Yield what is in the items, time after time: where, -1 where nothing is, and what."""
        yield places, self


class Chained(NamedTuple):
    """Elements of which the last bit says whether another follows."""

    parts: tuple[Fixed, ...]
    repeated: bool
    """Whether all are as the first; otherwise those beyond ``parts`` are unknown."""

    def measure(self, block: bytes, place: int) -> int:
        """Return where an item that begins at ``place`` ends."""
        size = self.parts[0].size
        place += size
        while block[place - 1] & 1:
            place += size
        return place

    def ends(self, octets: Octets, places: Places) -> Places:
        """Return where items that begin at ``places`` end."""
        size = self.parts[0].size
        ends = places + size
        more = np.flatnonzero(octets[ends - 1] & 1)
        while more.size:
            ends[more] += size
            more = more[octets[ends[more] - 1] & 1 > 0]
        return ends

    def elements(self, octets: Octets, places: Places) -> Iterator[tuple[Places, Fixed]]:
        """Yield what is in the items, time after time: where, -1 where nothing is, and what."""
        for part in cycle(self.parts) if self.repeated else self.parts:
            if not (places >= 0).any():
                return
            yield places, part
            more = octets[places + part.size - 1] & 1 > 0
            places = np.where((places >= 0) & more, places + part.size, -1)


class Repeated(NamedTuple):
    """As many elements as the first octet says."""

    element: Fixed
    repeated: bool = True

    def measure(self, block: bytes, place: int) -> int:
        """Return where an item that begins at ``place`` ends."""
        return place + 1 + block[place] * self.element.size

    def ends(self, octets: Octets, places: Places) -> Places:
        """Return where items that begin at ``places`` end."""
        return places + 1 + octets[places].astype(np.int64) * self.element.size

    def elements(self, octets: Octets, places: Places) -> Iterator[tuple[Places, Fixed]]:
        """Yield what is in the items, time after time: where, -1 where nothing is, and what."""
        count = np.where(places >= 0, octets[places], 0)
        for number in range(int(count.max(initial=0))):
            yield (
                np.where(number < count, places + 1 + number * self.element.size, -1),
                self.element,
            )


class Explicit(NamedTuple):
    """As long as the first octet says, which counts itself."""

    inner: "Compound | None" = None
    """What is inside, as far as it is of use; nothing checks that it keeps to the length."""

    def measure(self, block: bytes, place: int) -> int:
        """Return where an item that begins at ``place`` ends."""
        if block[place] == 0:
            raise UndecodableError("an item of no length")
        return place + block[place]

    def ends(self, octets: Octets, places: Places) -> Places:
        """Return where items that begin at ``places`` end."""
        return places + octets[places]

    def elements(self, octets: Octets, places: Places) -> Iterator[tuple[Places, Fixed]]:
        """Yield nothing."""
        yield from ()


class Plan(NamedTuple):
    """How to go through what one field specification announces."""

    steps: tuple[tuple[int, Measure], ...]
    """For each item whose length varies, the octets before it and how it is measured."""
    tail: int
    """The octets after the last such item."""
    where: dict[str, tuple[int, int]]
    """For each item, after how many of such items it comes, and how many octets later."""


class Compound:
    """Items of which the first octets say which are there: a record, or an item of a record."""

    def __init__(self, items: tuple[tuple[str, "Item"] | None, ...]) -> None:
        self.items = items
        self.named = dict(entry for entry in items if entry is not None)
        self.longest = -(-len(items) // 7)
        self._plans: dict[bytes, Plan] = {}

    def plan(self, specification: bytes) -> Plan:
        """Return how to go through what a field specification announces."""
        found = self._plans.get(specification)
        if found is None:
            found = self._planned(specification)
            if len(self._plans) >= _MOST_PLANS:
                self._plans.clear()
            self._plans[specification] = found
        return found

    def _planned(self, specification: bytes) -> Plan:
        if len(specification) > self.longest:
            raise UndecodableError("more items are announced than the category has")
        steps, where, gap = list[tuple[int, Measure]](), dict[str, tuple[int, int]](), 0
        for number in range(7 * len(specification)):
            if not specification[number // 7] >> (7 - number % 7) & 1:
                continue
            entry = self.items[number] if number < len(self.items) else None
            if entry is None:
                raise UndecodableError(f"item {number + 1}, which is not in use")
            name, item = entry
            where[name] = (len(steps), gap)
            if isinstance(item, Fixed):
                gap += item.size
            else:
                steps.append((gap, item.measure))
                gap = 0
        return Plan(tuple(steps), gap, where)

    def measure(self, block: bytes, place: int) -> int:
        """Return where an item that begins at ``place`` ends."""
        end = place
        while block[end] & 1:
            end += 1
        end += 1
        specification = block[place:end]
        plan = self._plans.get(specification) or self.plan(specification)
        for gap, measure in plan.steps:
            end = measure(block, end + gap)
        return end + plan.tail

    def ends(self, octets: Octets, places: Places) -> Places:
        """Return where items that begin at ``places`` end."""
        return self._walked(octets, places)[1]

    def places_of(self, name: str, octets: Octets, places: Places) -> Places:
        """Return where an item inside begins, -1 where it is not there."""
        return self._walked(octets, places, name)[0]

    def _walked(
        self, octets: Octets, places: Places, wanted: str | None = None
    ) -> tuple[Places, Places]:
        """Return where an item inside begins, and where all end: up to that item."""
        found = np.full(places.size, -1)
        rows = np.flatnonzero(places >= 0)
        # As many octets say what is there as have their last bit set, and one more.
        said, last = [rows], places[rows]
        while (more := octets[last] & 1 > 0).any():
            rows, last = rows[more], last[more] + 1
            said.append(rows)
        cursor = places + 1
        for rows in said[1:]:
            cursor[rows] += 1
        for number, entry in enumerate(self.items):
            if entry is None or number // 7 >= len(said):
                continue
            rows = said[number // 7]
            bits = octets[places[rows] + number // 7] >> (7 - number % 7) & 1
            rows = rows[bits > 0]
            name, item = entry
            if name == wanted:
                found[rows] = cursor[rows]
                break
            if rows.size:
                cursor[rows] = item.ends(octets, cursor[rows])
        return found, cursor


Item: TypeAlias = Fixed | Chained | Repeated | Explicit | Compound


def parsed_layout(text: str) -> Compound:
    """Return the items that lines of text say."""
    return _compound(iter(text.strip().splitlines()))


def _compound(lines: Iterator[str]) -> Compound:
    items = list[tuple[str, Item] | None]()
    for line in lines:
        name, _, said = line.strip().partition(" ")
        if name == "}":
            break
        items.append(None if name == "-" else (name, _item(said.strip(), lines)))
    return Compound(tuple(items))


def _item(said: str, lines: Iterator[str]) -> Item:
    kind, rest = said[0], said[1:]
    if kind == "{":
        return _compound(lines)
    if kind == "=":
        return Explicit(_compound(lines) if rest else None)
    if kind == "+":
        return Chained(tuple(_fixed(f"{part} -1") for part in rest.split("|")), repeated=False)
    if kind == "~":
        return Chained((_fixed(f"{rest} -1"),), repeated=True)
    return Repeated(_fixed(rest)) if kind == "*" else _fixed(said)


def _fixed(said: str) -> Fixed:
    fields, bit = list[Field](), 0
    for word in said.split():
        name, _, width = word.rpartition(":")
        bits = abs(int(width.removesuffix("s")))
        if not word.startswith("-"):
            fields.append(Field(name, bit, bits, width.endswith("s")))
        bit += bits
    assert bit % 8 == 0, f"{said}: {bit} bits; expected whole octets"
    return Fixed(bit // 8, tuple(fields))
