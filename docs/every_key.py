"""The page of all keys and formats, made from the classes that check and read them."""

import json
import re

from trackweave.config.schema import tables
from trackweave.config.search import options_of
from trackweave.config.sections import ConfigurationSection
from trackweave.experiments.study_file import StudySection
from trackweave.formats.registry import formats
from trackweave.solvers import METHODS

HEAD = """# Every key and format, as the code has them

This page is made anew with each build of the site, from the classes that check keys and the
formats that read and write files: nothing is missing from it, and nothing is explained at length.
What is estimated where a key is left out, and when which key matters, stands in
[the configuration](configuration.md), [study files](study.md) and [formats](formats.md).
"""
KEYS = ("key", "takes", "means")
OPTIONS = ("option", "takes", "means", "left out")
WORDS = {
    "integer": "a whole number",
    "number": "a number",
    "string": "text",
    "boolean": "`true`, `false`",
    "object": "a table",
}
FORMATS = ("name", "what", "reads, writes", "carries", "loses", "`--from` options")


def page():
    """Return the page as Markdown."""
    parts = [HEAD, "## `tracker.toml`", *_file(*tables(ConfigurationSection))]
    parts += [
        "## Options of solvers",
        "Keys of `[search]` beside `method`, and of `[fusion.search]`.",
    ]
    for method in METHODS:
        parts += [f"### `{method}`", _options(options_of(method).content({})["properties"])]
    parts += ["## `STUDY.toml`", *_file(*tables(StudySection))]
    return "\n\n".join([*parts, "## Formats", _formats()]) + "\n"


def _file(content, shared):
    """Return the tables of a file: those that it names, and what these lead to."""
    own = {key: told for key, told in content["properties"].items() if "$ref" not in told}
    parts = [_table(KEYS, [_key(*item, shared) for item in own.items()])] if own else []
    for name, told in content["properties"].items():
        if "$ref" in told:
            parts += _section(name, _named(told, shared), shared)
    return parts


def _section(path, told, shared):
    """Return a table of a file with the tables in it, each under its dotted name."""
    inner = {key: each for key, each in told["properties"].items() if "$ref" in each}
    rows = [
        _key(key, each, shared) for key, each in told["properties"].items() if key not in inner
    ]
    parts = [f"### `[{path}]`", _shown(told["description"])]
    parts += [_table(KEYS, rows)] if rows else []
    for key, each in inner.items():
        parts += _section(f"{path}.{key}", _named(each, shared), shared)
    if isinstance(told["additionalProperties"], dict):
        parts += _section(f"{path}.NAME", _named(told["additionalProperties"], shared), shared)
    return parts


def _key(key, told, shared):
    return (f"`{key}`", _takes(told, shared), _shown(told.get("description", "")))


def _options(properties):
    return _table(
        OPTIONS,
        [
            (
                *_key(name, told, {}),
                f"`{json.dumps(told['default'])}`" if "default" in told else "–",
            )
            for name, told in properties.items()
        ],
    )


def _takes(told, shared):
    """Return what a key takes, in words, from its JSON schema."""
    if "anyOf" in told:
        return " or ".join(_takes(each, shared) for each in told["anyOf"])
    if "$ref" in told:
        inner = _named(told, shared)["properties"]
        return f"a table of {', '.join(f'`{key}`' for key in inner)}"
    if "enum" in told:
        return ", ".join(f'`"{word}"`' for word in told["enum"])
    if told["type"] == "array":
        inner = _takes(told["items"], shared)
        return f"a list of {inner}" if "enum" in told["items"] else f"{_lengths(told)}: {inner}"
    limits = [
        f"{word} {_number(told[limit])}"
        for word, limit in (("from", "minimum"), ("to", "maximum"))
        if limit in told
    ]
    return " ".join([WORDS[told["type"]], *limits])


def _lengths(told):
    least, most = told.get("minItems", 0), told.get("maxItems")
    if most is None:
        return f"a list of {least} and more" if least > 1 else "a list"
    return f"a list of {least}" if least == most else f"a list of {least} to {most}"


def _number(value):
    """Return a limit as a person would write it: 1e9, and 1 - 1e-12."""
    if 0 < 1 - value < 1e-6:
        return f"1 - {_number(1 - value)}"
    text = f"{value:.3g}" if abs(value) >= 1e5 or abs(value) < 1e-3 else f"{value:.12g}"
    return re.sub(r"e([+-])0*", lambda found: "e" + found[1].strip("+"), text)


def _formats():
    rows = []
    for each in formats().values():
        ways = [word for word, can in (("reads", each.can_read), ("writes", each.writer)) if can]
        extra = f" (extra `{each.extra}`)" if each.extra else ""
        told = [each.title + extra, ", ".join(ways), each.carries, each.loses]
        rows.append([f"`{each.name}`", *told, "; ".join(_told(o) for o in each.options) or "–"])
    return _table(FORMATS, sorted(rows))


def _told(option):
    """Return what a reader may be told."""
    choices = f" ({', '.join(option.choices)})" if option.choices else ""
    return f"`{option.name}={option.default}`: {option.meaning}{choices}"


def _named(told, shared):
    return shared[told["$ref"].rpartition("/")[2]]


def _shown(text):
    return text.replace("``", "`").replace("|", "\\|")


def _table(head, rows):
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)
