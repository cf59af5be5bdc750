"""Kernels are compiled, or loaded, before the first scan needs them."""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from trackweave.config import Configuration, load_configuration
from trackweave.domain.facts import Facts
from trackweave.errors import TrackweaveError
from trackweave.randomness import generator_of
from trackweave.run.small_recordings import Recording, recording_of
from trackweave.service.board import Board
from trackweave.service.engine import Engine
from trackweave.service.learning import learned
from trackweave.service.pacing import LEVELS
from trackweave.service.records import Arrived, Kind, as_json, packed_reports
from trackweave.service.spec import without_nothing
from trackweave.solvers.auto import Auto
from trackweave.solvers.warming import warm_up

__all__ = ["Rehearsal", "warm_solvers"]

USUAL = "position"
"""What sensors measure as long as nobody says otherwise."""
PIECE = 16
"""Reports that come at once."""
_KEYS = (
    ("motion", "model", "constant-velocity"), ("motion", "filter", "extended"),
    ("tracker", "kind", "multi-hypothesis"), ("search", "method", "auto"),
)  # fmt: skip
"""What decides about kernels beside what is measured, and what holds where nothing is said."""
_SEEN = {"detection_probability": 0.9, "clutter_density": 1e-7}


class Rehearsal:
    """Lets engines of their own take a minute of traffic, for each way of running once.

    Nothing of the service's own engine, journal or files is touched.
    """

    def __init__(self) -> None:
        self._done: set[_Part] = set()

    def needs(self, configuration: Configuration, dim: int = 2) -> bool:
        """Tell whether something in a configuration was not rehearsed yet."""
        return any(part not in self._done for part in _parts(configuration, dim))

    def run(self, configuration: Configuration, dim: int = 2) -> None:
        """Reach the kernels with which a configuration runs.

        Parameters
        ----------
        configuration
            What was told or found out, with gaps or without.
        dim
            Number of dimensions of the tracking space.
        """
        for part in _parts(configuration, dim):
            if part in self._done:
                continue
            self._done.add(part)
            # A kind of measurement from outside, or keys that go with it alone, are not
            # rehearsed: their kernels are compiled when they are needed.
            with suppress(TrackweaveError):
                _play(part)


def warm_solvers() -> None:
    """Reach the kernels of searches that only windows that are hard to decide ask for."""
    warm_up(Auto(), generator_of(0))


@dataclass(frozen=True, slots=True)
class _Part:
    """One way of running: what decides which kernels are reached."""

    kind: str
    dim: int
    is_lone: bool
    """Whether reports are no scans, as of ships that report themselves."""
    keys: tuple[tuple[str, str, Any], ...]


def _parts(configuration: Configuration, dim: int) -> Iterator[_Part]:
    """Yield the ways of running that a configuration has, one for each kind of measurement."""
    keys = tuple(
        (table, key, configuration.said(table, key) or usual) for table, key, usual in _KEYS
    )
    sensors = configuration.table("sensors").values()
    kinds = {(own.get("measurement", USUAL), own.get("scans") is False) for own in sensors}
    for kind, is_lone in sorted(kinds or {(USUAL, False)}):
        yield _Part(kind, dim, is_lone, keys)


def _configuration(part: _Part, recording: Recording) -> Configuration:
    """Return a configuration of a part in which nothing is left to be estimated."""
    turns = {"scans": False, "scan_period": None} if part.is_lone else {}
    tables: dict[str, Any] = {
        **recording.config,
        "lifecycle": {"new_target_density": 1e-7},
        "sensors": {
            name: {**own, **_SEEN, **turns} for name, own in recording.config["sensors"].items()
        },
    }
    for table, key, value in part.keys:
        tables[table] = {**tables.get(table, {}), key: value}
    tables["motion"]["process_noise"] = 0.1
    return load_configuration(without_nothing(tables))


def _play(part: _Part) -> None:
    """Track a small recording as the service does, from the estimates to a snapshot."""
    recording = recording_of(part.kind, n_sensors=2, dim=part.dim)
    told = _configuration(part, recording)
    found = learned(told, [Arrived(recording.reports, "rehearsal", Facts())], Facts())
    assert found is not None, "nothing is left to be estimated"
    engine, board = Engine(), Board()
    engine.take(1, Kind.CONFIGURE, found.spec.payload())
    rows = recording.reports
    for begin in range(0, rows.height, PIECE):
        piece = packed_reports(rows[begin : begin + PIECE], "rehearsal", Facts())
        engine.take(engine.sequence + 1, Kind.REPORTS, piece)
        board.draw(engine)
        engine.track_of()
        if begin > rows.height // 2:
            engine.take(engine.sequence + 1, Kind.BOUND, as_json(LEVELS[1]))
    engine = Engine.unpack(engine.pack())
    end = float(rows["time"].max()) + 10.0  # type: ignore[arg-type]
    engine.take(engine.sequence + 1, Kind.CLOSE, as_json({"until": {"": end}}))
    engine.finish()
