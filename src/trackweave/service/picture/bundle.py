"""The page's modules as one script."""

import re
from importlib.resources import files

__all__ = ["bundled", "file_of_page"]

_IMPORT = re.compile(r'^import \{[^}]*\} from "\./([a-z]+\.js)";\n', re.MULTILINE)
_EXPORT = re.compile(r"^export (?=(?:async )?(?:function|class|const) )", re.MULTILINE)


def file_of_page(name: str) -> str:
    """Return the text of one of the page's files."""
    return (files("trackweave.service") / "page" / name).read_text(encoding="utf-8")


def bundled(entry: str) -> str:
    """Join a module of the page and all that it imports to one script.

    Parameters
    ----------
    entry
        The module's name, such as ``picture.js``.

    Returns
    -------
    The script, without imports and exports. A module comes after those that it imports. They share
    one scope, so that no two of them may define one name.

    Examples
    --------
    >>> [line for line in bundled("store.js").splitlines() if line.startswith("// ")][:2]
    ['// geometry.js', '// store.js']
    """
    begun: set[str] = set()
    parts: list[str] = []

    def visit(name: str) -> None:
        if name in begun:
            return
        begun.add(name)
        text = file_of_page(name)
        for imported in _IMPORT.findall(text):
            visit(imported)
        parts.append(f"// {name}\n" + _EXPORT.sub("", _IMPORT.sub("", text)))

    visit(entry)
    return "\n".join(parts)
