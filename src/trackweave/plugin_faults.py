"""What somebody else's code raises is told as theirs: which plug-in it is, and what it did."""

from collections.abc import Iterator
from contextlib import contextmanager

from trackweave.errors import InvalidInputError

__all__ = ["is_ours", "told_as_theirs"]


def is_ours(part: object) -> bool:
    """Tell whether an object, a class or a function comes from this package."""
    kind = part if hasattr(part, "__qualname__") else type(part)
    return f"{kind.__module__}.".startswith("trackweave.")


@contextmanager
def told_as_theirs(part: object, group: str, method: str, word: str = "") -> Iterator[None]:
    """Name the plug-in and its method where the block raises; what is ours raises as it does."""
    # ``group`` is the last word of the entry points' group, such as "motions"; without a word the
    # plug-in is called as its entry point, else as its class. What it raised is the cause; but a
    # MemoryError, which is nobody's fault, comes as it came.
    try:
        yield
    except MemoryError:
        raise
    except Exception as err:  # somebody else's code may fail in any way
        if is_ours(part):
            raise
        said = " ".join(str(err).split())
        raise InvalidInputError(
            f"{_named(part, group, word)}: {method} raised {type(err).__name__}"
            + (f": {said:.300}" if said else "")
            + "; the plug-in is at fault, and expected to raise nothing"
        ) from err


def _named(part: object, group: str, word: str) -> str:
    """Return what a message calls a plug-in, with its package where it is an entry point."""
    from importlib.metadata import entry_points

    kind = part if hasattr(part, "__qualname__") else type(part)
    what, name = group.removesuffix("s"), getattr(kind, "__qualname__", "")
    for each in entry_points(group=f"trackweave.{group}"):
        if each.name == word or each.value == f"{kind.__module__}:{name}":
            package = each.dist.name if each.dist is not None else each.module
            return f'{what} "{each.name}" of package {package} ({each.value})'
    return f"{what} {word or name} ({kind.__module__})"
