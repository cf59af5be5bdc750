"""From a file or a mapping to a checked configuration."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from trackweave.config.messages import explain
from trackweave.config.search import check_search
from trackweave.config.sections import Configuration
from trackweave.errors import InvalidInputError
from trackweave.toml_file import read_toml

__all__ = ["load_configuration"]


def load_configuration(
    source: str | Path | Mapping[str, Any] | Configuration | None,
) -> Configuration:
    """Return the configuration that a file or a mapping holds, every value checked."""
    # The keys that were not given are None. A message names file, key, value and what was
    # expected.
    if isinstance(source, Configuration):
        return source
    if source is None:
        return Configuration()
    if isinstance(source, Mapping):
        name, values = "configuration", dict(source)
    elif not isinstance(source, str | os.PathLike):
        raise InvalidInputError(
            f"config: {source!r:.80}; expected the path of a TOML file, or a mapping of its keys"
        )
    else:
        name, values = str(source), read_toml(Path(source), "a configuration")
    try:
        configuration = Configuration.of(values)
    except ValidationError as err:
        raise InvalidInputError(explain(err, Configuration, [name], values)) from None
    except InvalidInputError as err:
        raise InvalidInputError(f"{name}, {err}") from err
    check_search(configuration.search, name)
    check_search(configuration.fusion.search, name, "fusion.search")
    return configuration.called(name)
