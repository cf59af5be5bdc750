"""What libasterix makes of records, in the words of our layouts."""

from collections.abc import Iterator
from typing import Any

import asterix.base as base
import asterix.generated as generated


def specification(category: int, edition: str = "") -> Any:
    """Return libasterix's newest edition of a category, or a certain one."""
    editions = {
        ".".join(map(str, each.cv_edition)): each for each in generated.manifest["CATS"][category]
    }
    return editions[edition] if edition else list(editions.values())[-1]


def blocks(data: bytes) -> list[tuple[int, bytes]]:
    """Return the category of each data block and its records."""
    found = base.RawDatablock.parse(base.Bits.from_bytes(data))
    assert not isinstance(found, ValueError)
    return [(block.get_category(), block.get_raw_records().to_bytes()) for block in found]


def records(spec: Any, data: bytes) -> list[dict[str, int]] | None:
    """Return every field of each record, None where libasterix refuses them."""
    bits = base.Bits.from_bytes(data)
    if issubclass(spec.cv_uap, base.UapMultiple):
        ways = spec.cv_uap.parse_any_uap(bits, 1000)
        if isinstance(ways, ValueError) or not ways:
            return None
        # Of several ways to read category 001, the descriptor's first bit says the right one.
        kinds = list(spec.cv_uap.cv_uaps.values())
        for found in ways:
            fields = [dict(_record(record)) for record in found]
            said = [each.get("020/TYP", 0) for each in fields]
            if said == [kinds.index(type(record)) for record in found]:
                return fields
        return None
    found = spec.cv_uap.parse(bits)
    if isinstance(found, ValueError):
        return None
    return [dict(_record(record)) for record in found]


def _record(record: Any) -> Iterator[tuple[str, int]]:
    for name, item in record.items_regular.items():
        yield from _variation(name, item.arg.arg)


def _variation(name: str, found: Any) -> Iterator[tuple[str, int]]:
    if isinstance(found, base.Element):
        yield from _element(name, found)
    elif isinstance(found, base.Repetitive):
        for number, each in enumerate(found.arg, start=1):
            yield from _variation(f"{name}/{number}", each)
    elif isinstance(found, base.Compound):
        for inner, item in found.arg.items():
            yield from _variation(f"{name}/{inner}", _inside(item.arg))
    elif not isinstance(found, base.Explicit):
        parts = found.arg if isinstance(found, base.Extended) else [found.arg]
        for item in (item for part in parts for item in part):
            yield from _item(name, item)


def _element(name: str, found: Any) -> Iterator[tuple[str, int]]:
    number = _number(found)
    if len(found.bs) == 64:  # a register's content, then its number
        yield f"{name}/MBDATA", number >> 8
        yield f"{name}/BDS", number & 0xFF
    else:
        yield name, number


def _item(name: str, item: Any) -> Iterator[tuple[str, int]]:
    if isinstance(item, base.Item):
        yield from _variation(f"{name}/{item.cv_non_spare.cv_name}", _inside(item.arg.arg))


def _inside(rule: Any) -> Any:
    return getattr(rule, "arg", rule)


def _number(element: Any) -> int:
    content = element.cv_rule
    content = getattr(content, "cv_content", None) or content.cv_default_content
    sign = getattr(content, "cv_signedness", base.Unsigned)
    return sign.convert(len(element.bs), element.as_uint())
