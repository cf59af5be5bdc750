"""From the tracks of several sensors to system tracks."""

import os
import time as clock
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from string import ascii_uppercase
from typing import Any, Generic, TypeAlias, overload

import numpy as np
import polars as pl

from trackweave.config.fusion import FusionOrder, FusionSettings, order_of, settle_fusion
from trackweave.config.presets import preset_notes
from trackweave.domain.frames import LocalFrame
from trackweave.domain.tracks import TrackTable
from trackweave.errors import InvalidInputError
from trackweave.fusion.aging import assumed_process_noise
from trackweave.fusion.bias import BiasModel
from trackweave.fusion.fuser import TrackFuser
from trackweave.fusion.pairings import Pairing
from trackweave.fusion.pictures import LocalPicture
from trackweave.fusion.registration import Registration, register
from trackweave.io.encoding import to_native
from trackweave.io.frames_out import associations_frame, tracks_frame
from trackweave.io.tracks_in import LocalTracks, read_local_tracks
from trackweave.randomness import RandomSource, generator_of, seed_of
from trackweave.run.consistency import on_one_plane, require_agreement
from trackweave.run.fusion_record import FusionLog, fusion_record, local_pictures
from trackweave.run.result import Result, Table, named
from trackweave.summaries import counted, summary

__all__ = ["FusionResult", "FusionValues", "fuse"]

# A sensor of so many tracks, more than such a share of whose rows lie where others see, sees some
# of their objects: if hardly any, it is elsewhere than it says.
FEWEST_ALONE, BESIDE, HARDLY_ANY = 3, 0.5, 0.2
Config: TypeAlias = str | Path | Mapping[str, Any] | FusionOrder | None
Progress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class FusionResult(Result, Generic[Table]):
    """What a fusion found, in the kind of table that came in.

    Parameters
    ----------
    tracks
        Fused tracks, one row per object and time.
    associations
        Which local track was of which object, from when to when, and why that ended.
    run
        The record: configuration as used, each update's cost and bound, changes, totals.
    values
        The same as values of the library.

    Examples
    --------
    >>> import numpy as np
    >>> import polars as pl
    >>> import trackweave as tw
    >>> frame = pl.DataFrame({
    ...     "time": [0.0], "track": [7], "x": [0.0], "y": [0.0], "vx": [1.0], "vy": [0.0],
    ...     "p_x_x": [4.0], "p_x_y": [0.0], "p_x_vx": [0.0], "p_x_vy": [0.0],
    ...     "p_y_y": [4.0], "p_y_vx": [0.0], "p_y_vy": [0.0],
    ...     "p_vx_vx": [1.0], "p_vx_vy": [0.0], "p_vy_vy": [1.0],
    ... })
    >>> fused = tw.fuse({"A": frame, "B": frame}, rng=np.random.default_rng(1))
    >>> fused.tracks.select("track", "status", "x", "y").rows()
    [(1, 'confirmed', 0.0, 0.0)]
    """

    tracks: Table
    associations: Table
    run: dict[str, Any]
    values: "FusionValues"

    def _facts(self) -> dict[str, str]:
        totals, names = self.run["totals"], list(self.run["input"]["sensors"])
        return {
            "objects": f"{totals['objects']:,} in {counted(len(self.values.tracks), 'row')}",
            "sensors": named(names),
            "notes": f'{len(self.run["notes"])}, in .run["notes"]',
        }


@dataclass(frozen=True, slots=True, eq=False)
class FusionValues:
    """A fusion's results as values of the library."""

    tracks: TrackTable
    """One row per object and time."""
    pairings: tuple[Pairing, ...]
    """Which local track was of which object."""
    registrations: Mapping[str, Registration]
    """What was found wrong with sensors, by name; empty where none was asked for."""
    frame: LocalFrame | None
    """The plane of the positions; None where they were taken as they came."""
    settings: FusionSettings
    """The configuration as used."""

    __repr__ = summary


@overload
def fuse(
    tracks: Sequence[str | os.PathLike[str]] | Mapping[str, str | os.PathLike[str]],
    config: Config = None,
    *,
    preset: str | None = None,
    rng: RandomSource = 0,
    progress: Progress | None = None,
) -> FusionResult[pl.DataFrame]: ...
@overload
def fuse(
    tracks: Sequence[LocalTracks] | Mapping[str, LocalTracks],
    config: Config = None,
    *,
    preset: str | None = None,
    rng: RandomSource = 0,
    progress: Progress | None = None,
) -> FusionResult[Any]: ...
@overload
def fuse(
    tracks: Sequence[Table] | Mapping[str, Table],
    config: Config = None,
    *,
    preset: str | None = None,
    rng: RandomSource = 0,
    progress: Progress | None = None,
) -> FusionResult[Table]: ...
def fuse(
    tracks: Sequence[Any] | Mapping[str, Any],
    config: Config = None,
    *,
    preset: str | None = None,
    rng: RandomSource = 0,
    progress: Progress | None = None,
) -> FusionResult[Any]:
    """Turn the tracks of several sensors into system tracks.

    Parameters
    ----------
    tracks
        The tracks of each sensor: paths of tracks files, or pandas, polars or Arrow tables, with
        the columns that ``track`` writes. As a mapping each has the name of its sensor; as a
        sequence they are called A, B, C, …. At least two, the reference of registration first.
    config
        What is not to be as by default: path of a configuration whose table ``[fusion]`` says
        it, or as a mapping that table, or a whole configuration. Its keys: ``method`` (how
        estimates are combined), ``process_noise``, ``confirm``, ``complete``, ``hysteresis``,
        ``patience``, ``register``, ``bias``, ``statistic`` and ``search``.
    preset
        Name of a preset, such as huo, applied key by key where ``config`` is silent; of a search
        by another method than the preset's none of its options are left.
    rng
        The only source of randomness: a generator, or a seed.
    progress
        Called after each update with the number of updates done and of all.

    Returns
    -------
    Fused tracks and associations in the kind of table that came in, and the run's record.

    Raises
    ------
    InvalidInputError
        If a table, a configuration value or an argument cannot be used.

    Examples
    --------
    >>> import polars as pl
    >>> import trackweave as tw
    >>> path = pl.DataFrame({"t": range(6), "x": [0, 6, 12, 15, 21, 27], "y": [0, 2, 0, 2, 0, 2]})
    >>> radar = tw.track(path).tracks
    >>> lidar = tw.track(path.with_columns(pl.col("x") + 0.3)).tracks
    >>> tw.fuse({"radar": radar, "lidar": lidar}).run["totals"]["common_objects"]
    1
    """
    if progress is not None and not callable(progress):
        raise InvalidInputError(f"progress: {progress!r:.80}; expected something to call, or None")
    generator = generator_of(rng)
    order = config if isinstance(config, FusionOrder) else order_of(config)
    tables = {name: _table(source) for name, source in _named(tracks).items()}
    require_agreement(tables)
    tables, frame, notes = on_one_plane(tables)
    settings = settle_fusion(order, preset=preset, process_noise=_process_noise(tables))
    noise = settings.values["process_noise"]
    pictures = {name: local_pictures(name, table.tracks, noise) for name, table in tables.items()}
    found = _registrations(pictures, settings) if settings.values["register"] else {}
    fuser = TrackFuser(settings.associator(list(tables)), settings.values["method"], found)
    log, rows = FusionLog(), []
    updates = _updates(pictures)
    for number, (time, news) in enumerate(updates, start=1):
        cpu, wall = clock.process_time(), clock.perf_counter()
        fused = fuser.step(time, news, rng=generator)
        log.add(fused, news, clock.process_time() - cpu, clock.perf_counter() - wall)
        rows.append(fused.tracks)
        if progress is not None:
            progress(number, len(updates))
    first = next(table for table in tables.values() if len(table))
    fused_tracks = TrackTable.concatenate(rows, first.tracks.dim)
    values = FusionValues(fused_tracks, log.pairings.all(), found, frame, settings)
    iso = first.iso_time
    notes += [*preset_notes(preset), *_notes(tables), *_notes_on_pairings(tables, values, log)]
    return FusionResult(
        to_native(tracks_frame(fused_tracks, frame, iso_time=iso), first.kind),
        to_native(associations_frame(values.pairings, iso_time=iso), first.kind),
        {**fusion_record(tables, values, log, notes), "seed": seed_of(rng)},
        values,
    )


def _named(tracks: Sequence[Any] | Mapping[str, Any]) -> dict[str, Any]:
    """Return sources by the names of their sensors."""
    if isinstance(tracks, Mapping):
        return dict(tracks)
    if isinstance(tracks, str) or not isinstance(tracks, Sequence):
        raise InvalidInputError(
            f"tracks: {tracks!r:.80}; expected a list of tables, or a mapping from names to tables"
        )
    if len(tracks) > len(ascii_uppercase):
        raise InvalidInputError(
            f"tracks: {len(tracks)} tables without names; expected a mapping from names to tables"
        )
    return dict(zip(ascii_uppercase, tracks, strict=False))


def _table(source: Any) -> LocalTracks:
    return source if isinstance(source, LocalTracks) else read_local_tracks(source)


def _process_noise(tables: Mapping[str, LocalTracks]) -> float | None:
    """Return what the sensors' trackers assumed, the middle of it where they differ."""
    noises = [assumed_process_noise(table.tracks) for table in tables.values()]
    known = [noise for noise in noises if noise is not None]
    return float(np.median(known)) if known else None


def _notes(tables: Mapping[str, LocalTracks]) -> list[str]:
    """Return sentences on tables that do not take part as one might think."""
    notes = []
    for name, table in tables.items():
        if not len(table):
            notes.append(f"{table.name}: no tracks; sensor {name} sees nothing")
        elif table.is_tentative:
            notes.append(f"{table.name}: all tracks are tentative, so they take part")
    return notes


def _registrations(
    pictures: Mapping[str, list[LocalPicture]], settings: FusionSettings
) -> dict[str, Registration]:
    """Return what is wrong with each sensor beside the first, the reference."""
    reference, *others = [name for name, own in pictures.items() if own]
    found = {}
    for name in others:
        # About its own middle, a turn and a shift of the picture are told apart best.
        middle = np.median(np.concatenate([each.mean for each in pictures[name]]), axis=0)
        dim = pictures[name][0].dim
        model = BiasModel(tuple(settings.values["bias"]), tuple(middle[:dim].tolist()))
        found[name] = register(
            pictures[reference], pictures[name],
            process_noise=settings.values["process_noise"], model=model,
        )  # fmt: skip
    return found


def _updates(
    pictures: Mapping[str, list[LocalPicture]],
) -> list[tuple[float, dict[str, LocalPicture]]]:
    """Return the times at which any sensor has news, and the news."""
    by_time: dict[float, dict[str, LocalPicture]] = {}
    for name, own in pictures.items():
        for picture in own:
            by_time.setdefault(picture.time, {})[name] = picture
    return sorted(by_time.items(), key=lambda update: update[0])


def _notes_on_pairings(
    tables: Mapping[str, LocalTracks], values: FusionValues, log: FusionLog
) -> list[str]:
    """Return a sentence where sensors that both see objects have none in common."""
    seeing = [name for name, table in tables.items() if len(table)]
    if len(seeing) < 2 or values.registrations:
        return []
    register = "misplaced, turned or late, --register tells by how much"
    if not log.pairings.common:
        return [
            f"no object is common to two of {', '.join(seeing)}: where one of them is {register}"
        ]
    alone = []
    for name in seeing:
        pairings = [each for each in values.pairings if each.sensor == name]
        own = {each.track for each in pairings}
        common = {each.track for each in pairings if each.object in log.pairings.common}
        others = [tables[each].tracks.mean[:, :2] for each in seeing if each != name]
        low, high = np.min(np.concatenate(others), axis=0), np.max(np.concatenate(others), axis=0)
        place = tables[name].tracks.mean[:, :2]
        is_beside = np.mean(((place >= low) & (place <= high)).all(axis=1)) > BESIDE
        is_alone = len(own) >= FEWEST_ALONE and len(common) <= HARDLY_ANY * len(own)
        if is_alone and is_beside:
            alone.append(name)
    return [
        f"hardly any object of {name} is one of another sensor's, though it looks where they do: "
        f"where it is {register}"
        for name in alone
    ]
