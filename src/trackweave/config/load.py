"""From a file or a mapping to a checked configuration."""

import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from trackweave.config.messages import explain
from trackweave.config.search import check_search
from trackweave.config.sections import Configuration
from trackweave.errors import InvalidInputError

__all__ = ["load_configuration"]


def load_configuration(
    source: str | Path | Mapping[str, Any] | Configuration | None,
) -> Configuration:
    """Return the configuration that a file or a mapping holds, every value checked.

    Parameters
    ----------
    source
        Path of a TOML file, or its content as a mapping; None for an empty configuration.

    Returns
    -------
    The keys that were given; the others are None.

    Raises
    ------
    InvalidInputError
        If the file cannot be read or is not TOML, or a key is unknown or its value is not what
        it must be. The message names file, key, value and what was expected.
    """
    if isinstance(source, Configuration):
        return source
    if source is None:
        return Configuration()
    if isinstance(source, Mapping):
        name, values = "configuration", dict(source)
    else:
        name, values = str(source), _read_toml(Path(source))
    try:
        configuration = Configuration.model_validate(values)
    except ValidationError as err:
        raise InvalidInputError(explain(err, Configuration, [name], values)) from None
    check_search(configuration.search, name)
    check_search(configuration.fusion.search, name, "fusion.search")
    return configuration.called(name)


def _read_toml(path: Path) -> dict[str, Any]:
    """Return what a TOML file holds."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except tomllib.TOMLDecodeError as err:
        place = re.search(r"\(at (.*)\)$", str(err))
        where = f", {place.group(1)}" if place else ""
        what = re.sub(r" \(at .*\)$", "", str(err))
        raise InvalidInputError(f"{path}{where}: {what}; expected TOML") from None
    except UnicodeDecodeError as err:
        raise InvalidInputError(
            f"{path}, byte {err.start}: not UTF-8; expected TOML as UTF-8 text"
        ) from None
    except FileNotFoundError:
        raise InvalidInputError(f"{path}: no such file; expected a configuration") from None
    except OSError as err:
        raise InvalidInputError(f"{path}: {err.strerror}; expected a configuration file") from None
