"""Scenarios from TOML files, every mistake named by file, key, value and what was expected."""

from collections.abc import Mapping
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any

from trackweave.errors import InvalidInputError
from trackweave.simulation.scenario import Area, RandomTargets, Scenario, SimulatedSensor
from trackweave.simulation.targets import Crossing, Manoeuvre, Parallel, Target
from trackweave.toml_file import read_toml

__all__ = ["read_scenario", "scenario_of"]


def read_scenario(path: str | Path) -> Scenario:
    """Return the scenario that a TOML file describes.

    The keys are those of ``Scenario`` and its parts; see the reference page "Scenario files".

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    The checked scenario.

    Raises
    ------
    InvalidInputError
        If the file cannot be read, is not TOML, or holds a key or value that does not fit.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from trackweave.simulation import read_scenario
    >>> text = '''
    ... duration = 30.0
    ... area = {low = [0.0, 0.0], high = [1000.0, 1000.0]}
    ... sensors = [{name = "radar", sigma = 5.0, scan_period = 2.0}]
    ... '''
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     size = Path(folder, "scene.toml").write_text(text)
    ...     read_scenario(Path(folder, "scene.toml")).sensors[0].name
    'radar'
    """
    file = Path(path)
    return scenario_of(read_toml(file, "a scenario"), str(file))


def scenario_of(table: Mapping[str, Any], name: str) -> Scenario:
    """Return the scenario that a file's keys and values describe.

    Parameters
    ----------
    table
        What the file holds.
    name
        What messages call it.

    Returns
    -------
    The checked scenario.

    Raises
    ------
    InvalidInputError
        If it holds a key or value that does not fit.

    Examples
    --------
    >>> from trackweave.simulation import scenario_of
    >>> area = {"low": [0.0, 0.0], "high": [1000.0, 1000.0]}
    >>> radar = {"name": "radar", "sigma": 5.0, "scan_period": 2.0}
    >>> scene = scenario_of({"area": area, "duration": 30.0, "sensors": [radar]}, "mine")
    >>> scene.area.high
    (1000.0, 1000.0)
    """
    try:
        values = _known(Scenario, table, "")
        for key, kind in _PARTS.items():
            if key in values:
                values[key] = _built(kind, values[key], key)
        return Scenario(**values)
    except InvalidInputError as err:
        raise InvalidInputError(f"{name}, {err}") from err


def _known(kind: type[Any], table: object, path: str) -> dict[str, Any]:
    """Return the table's values; refuse unknown keys, missing keys and what is no table."""
    if not isinstance(table, Mapping):
        raise InvalidInputError(f"{path}: {table!r}; expected a table of keys and values")
    inside = f"{path}." if path else ""
    keys = [field.name for field in fields(kind)]
    for key, value in table.items():
        if key not in keys:
            raise InvalidInputError(
                f"{inside}{key}: {value!r:.60}; expected one of the keys {', '.join(keys)}"
            )
    for field in fields(kind):
        needed = field.default is MISSING and field.default_factory is MISSING
        if needed and field.name not in table:
            raise InvalidInputError(f"{inside}{field.name}: missing; expected a value")
    return dict(table)


def _built(kind: type[Any] | list[type[Any]], told: object, path: str) -> Any:
    """Return what a table describes, or each of an array of tables."""
    if isinstance(kind, list):
        if not isinstance(told, list):
            raise InvalidInputError(f"{path}: {told!r:.60}; expected tables [[{path}]]")
        return tuple(_built(kind[0], each, f"{path}[{n}]") for n, each in enumerate(told))
    values = _known(kind, told, path)
    if "manoeuvres" in values:
        values["manoeuvres"] = _built([Manoeuvre], values["manoeuvres"], f"{path}.manoeuvres")
    try:
        return kind(**values)
    except InvalidInputError as err:
        raise InvalidInputError(f"{path}.{err}") from err


# Of a list there may be several.
_PARTS: dict[str, type[Any] | list[type[Any]]] = {
    "area": Area,
    "sensors": [SimulatedSensor],
    "targets": [Target],
    "crossings": [Crossing],
    "parallels": [Parallel],
    "random": RandomTargets,
}
