"""From what was heard to a complete configuration, with which the tracker can begin."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import polars as pl

from trackweave.config import Configuration
from trackweave.config.fill import ANY_SENSOR, Settings, left_out, needs_estimates
from trackweave.config.sensing import sense_of
from trackweave.config.write import commented_toml
from trackweave.domain.facts import Facts
from trackweave.domain.frames import Projection
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.reports import ReportTable
from trackweave.errors import InvalidInputError
from trackweave.io.reports import reports_in
from trackweave.io.tables import RawTable
from trackweave.io.time_axes import on_one_axis
from trackweave.run.batches import hearing_in
from trackweave.run.cartesian_to_polar import as_measured, with_ranges
from trackweave.run.course import rotations_in
from trackweave.run.doubles import doubles_of
from trackweave.run.observing import settle
from trackweave.run.pieces import pieces_in
from trackweave.run.regions.cutting import cut, margin_of, positions_of, unplaced_sensors
from trackweave.run.registering import registration_of
from trackweave.run.scans import complete_scans
from trackweave.run.told_places import on_plane, with_facts
from trackweave.service.records import Arrived
from trackweave.service.spec import Spec, without_nothing

__all__ = ["FEWEST", "LONG_ENOUGH", "Learned", "is_enough", "learned", "left_open", "waiting_for"]

FEWEST, LONG_ENOUGH, TURNS = 200, 30.0, 3.0
"""Reports, and seconds or turns, after which a configuration is estimated."""
OFTEN, MOST = 6, 2000
"""Where reports carry identities, as many are of objects that were heard so often, or nothing
tells how they move; of so many reports in all a configuration is estimated anyway."""
RARE = 0.05
"""A sensor with a smaller share of what was heard may lack what only a person can tell."""
FEWEST_IN_REGION = 50
"""Of what was heard, so many reports lie in a region."""
MOST_NAMED = 4
"""So many keys are named that a configuration leaves open; of more, how many."""


@dataclass(frozen=True, slots=True, eq=False)
class Learned:
    """What was found out.

    Parameters
    ----------
    spec
        With what the tracker runs.
    text
        The same as a commented tracker.toml.
    notes
        Sentences that a user should read.
    """

    spec: Spec
    text: str
    notes: tuple[str, ...]


def is_enough(heard: Sequence[Arrived], facts: Facts) -> bool:
    """Tell whether so much was heard that a configuration can be estimated."""
    if sum(each.table.height for each in heard) < FEWEST or not _are_heard_often(heard):
        return False
    span = _span(heard)
    periods = facts.scan_periods.values()
    return span >= min([LONG_ENOUGH, *(TURNS * period for period in periods)])


def _are_heard_often(heard: Sequence[Arrived]) -> bool:
    """Tell whether most identities, if reports carry any, were heard more than once or twice."""
    # Threads of two or three reports each tell neither a rhythm nor a speed: of a receiver that
    # hears many ships one wild position would be the noise of all.
    named = [each.table["identity"] for each in heard if "identity" in each.table.columns]
    names = pl.concat([each.cast(pl.String) for each in named]) if named else pl.Series([])
    names = names.drop_nulls()
    count = sum(each.table.height for each in heard)
    if names.len() < count / 2 or count >= MOST:
        return True
    often = names.value_counts(name="count")["count"]
    return int(often.filter(often >= OFTEN).sum()) >= FEWEST


def left_open(configuration: Configuration, heard: Sequence[Arrived]) -> list[str]:
    """Return the keys that a configuration leaves to be estimated, of the sensors that were heard.

    Parameters
    ----------
    configuration
        What was told.
    heard
        Reports; without any, it is of the sensors that were told.

    Returns
    -------
    Dotted keys.
    """
    names = {str(name) for each in heard[:20] for name in each.table["sensor"].unique().to_list()}
    if not names:
        told = set(configuration.table("sensors"))
        names = told - {ANY_SENSOR} or {ANY_SENSOR}
    return left_out(configuration, sorted(names))


def waiting_for(
    configuration: Configuration, heard: Sequence[Arrived], *, is_cut: bool = False
) -> str:
    """Return for what a service waits that is not configured yet.

    Parameters
    ----------
    configuration
        What was told.
    heard
        What came so far.
    is_cut
        Whether the plane is to be cut into regions.

    Returns
    -------
    A sentence: what was heard, and what is needed for which keys.
    """
    count = sum(each.table.height for each in heard)
    heard_so_far = f"{count:,} reports of {_span(heard):.0f} s heard" if count else "no report yet"
    keys = left_open(configuration, heard)
    if not keys and is_cut:
        return (
            f"{heard_so_far}; {FEWEST} over {LONG_ENOUGH:g} s (or {TURNS:g} turns of a radar) are "
            "needed to cut the plane into regions"
        )
    if not keys:
        return f"{heard_so_far}; the configuration is complete: tracks begin with the first report"
    of = "" if _are_heard_often(heard) else f" of identities that were heard {OFTEN} times each"
    named = ", ".join(keys[:MOST_NAMED])
    if len(keys) > MOST_NAMED:
        named += f" and {len(keys) - MOST_NAMED} more keys"
    if any(
        key.endswith(".clutter_density")
        and "clutter_per_scan" in configuration.sensor(key.split(".", 1)[1].rpartition(".")[0])
        for key in keys
    ):
        named += " (clutter_per_scan says it only with a field_of_view)"
    return (
        f"{heard_so_far}; {FEWEST} over {LONG_ENOUGH:g} s (or {TURNS:g} turns of a radar){of} are "
        f"needed to estimate what the configuration leaves out: {named}"
    )


def learned(
    configuration: Configuration,
    heard: Sequence[Arrived],
    facts: Facts,
    known: Spec | None = None,
    *,
    most_regions: int | None = None,
) -> Learned | None:
    """Return a complete configuration, None where more has to be heard for it.

    Parameters
    ----------
    configuration
        What was told.
    heard
        Reports from which the rest is estimated.
    facts
        What was told beside them.
    known
        With what the tracker runs already, where sensors are added to it.
    most_regions
        Into how many regions the plane may be cut; None for one tracker.

    Returns
    -------
    What was found out.

    Raises
    ------
    InvalidInputError
        If something is missing that only a person can tell.
    """
    try:
        return _learned(configuration, heard, (facts, known), most_regions)
    except InvalidInputError as err:
        # Of a sensor that is hardly heard nobody waits for what it lacks.
        rest, left_out = _without_rare(heard)
        found = _learned(configuration, rest, (facts, known), most_regions) if left_out else None
        if found is None:
            raise
        named = ", ".join(left_out[:MOST_NAMED])
        note = f"left out, as hardly heard: sensor {named}; {err}"
        return replace(found, notes=(note, *found.notes))


def _without_rare(heard: Sequence[Arrived]) -> tuple[list[Arrived], list[str]]:
    """Return what was heard without sensors that reported hardly anything, and their names."""
    names = pl.concat([each.table["sensor"].cast(pl.String) for each in heard])
    count = names.value_counts(name="count")
    rare = count.filter(pl.col("count") < RARE * names.len())["sensor"].sort().to_list()
    is_kept = ~pl.col("sensor").cast(pl.String).is_in(rare)
    return [replace(each, table=each.table.filter(is_kept)) for each in heard], rare


def _learned(
    configuration: Configuration,
    heard: Sequence[Arrived],
    beside: tuple[Facts, Spec | None],
    most_regions: int | None,
) -> Learned | None:
    facts, known = beside
    reports = _table(configuration, heard, facts, known)
    if not len(reports):
        return None
    told = with_facts(configuration, reports)
    if needs_estimates(told, reports.sensors) and not is_enough(heard, facts):
        return None
    reports = as_measured(reports, told.sensor)
    # Where a beam turns that nobody placed takes more reports than the first.
    reports, told, polar = with_ranges(reports, told, unplaced=False)
    registration = replace(registration_of(reports, told), polar=polar)
    pieces = pieces_in(registration.reports, registration.configuration)
    reports, told = pieces.joined, pieces.configuration
    doubles, (settings, estimates) = doubles_of(reports, lambda once: settle(once, told))
    settings = registration.entered(pieces.entered(settings))
    if settings.plots is not None:
        raise InvalidInputError("plots.fuse: true; expected false, as live plots are not fused")
    values = _complete(settings)
    if known is not None:
        values["sensors"] = {**known.configuration["sensors"], **values["sensors"]}
    spec = Spec(
        values,
        reports.dim if known is None else known.dim,
        reports.frame if known is None else known.frame,
        reports.iso_time if known is None else known.iso_time,
        settings.together,
        None if known is None else known.regions,
        0.0 if known is None else known.margin,
    )
    if known is None and most_regions is not None:
        spec = _with_regions(spec, reports, settings, most_regions)
    elif spec.regions is not None:
        _require_places(reports, settings)
    spec = _with_told(replace(spec, configuration=without_nothing(values)), configuration)
    spec.settings()
    seconds, count = _span(heard), len(reports)
    # Sensors that run already are in the file too.
    shown = replace(settings, values={**settings.values, "sensors": values["sensors"]})
    text = commented_toml(
        shown if known else settings,
        head=[f"Written by trackweave serve from {count} reports of {seconds:.6g} s."],
        remarks=estimates.remarks if estimates else {},
        doubts=estimates.doubts if estimates else {},
    )
    return Learned(
        spec,
        text,
        (
            *reports.notes,
            *registration.notes(),
            *pieces.notes(),
            *doubles.notes(),
            *settings.notes,
        ),
    )


def _with_told(spec: Spec, configuration: Configuration) -> Spec:
    """Return the same with sensors that were told completely and not heard yet."""
    for name in configuration.table("sensors"):
        if name == ANY_SENSOR or name in spec.configuration["sensors"]:
            continue
        own = on_plane(configuration, spec.frame, spec.dim).sensor(name)
        sensors = {**spec.configuration["sensors"], name: own}
        more = replace(spec, configuration={**spec.configuration, "sensors": sensors})
        if not needs_estimates(configuration, [name]):
            with suppress(InvalidInputError):
                more.settings()
                spec = more
    return spec


def _with_regions(spec: Spec, reports: ReportTable, settings: Settings, most: int) -> Spec:
    """Return the same with the plane cut where about as much was heard on both sides."""
    _require_places(reports, settings)
    periods = {each.name: each.scan_period for each in settings.sensors}
    scans = complete_scans(reports, periods, rotations_in(settings), hearing_in(settings.sensors))
    margin = margin_of(reports, settings, [(scan,) for scan in scans])
    position = positions_of(reports, settings)
    regions = cut(position, margin, least=FEWEST_IN_REGION, most=most)
    return replace(spec, regions=tuple(regions), margin=margin)


def _require_places(reports: ReportTable, settings: Settings) -> None:
    """Refuse what cannot be tracked in regions."""
    unplaced, kind = unplaced_sensors(reports), settings.tracker.kind
    lone = [each.name for each in settings.sensors if each.scans is False]
    why = f"sensor {', '.join(unplaced)} tells no places" if unplaced else None
    if lone:
        # How far an object comes between two of its reports, no scan tells.
        why = f"sensor {', '.join(lone)} does not scan"
    if kind != "multi-hypothesis":
        why = f"tracker.kind is {kind}"
    if why is not None:
        raise InvalidInputError(
            f"engine: {why}, so that the plane cannot be cut into regions; expected sensors that "
            "scan and tell places, and the multi-hypothesis tracker, or no engine"
        )


def _table(
    configuration: Configuration, heard: Sequence[Arrived], facts: Facts, known: Spec | None
) -> ReportTable:
    # What comes later and has no date beside others that have one is refused.
    tables = on_one_axis([each.table for each in heard])
    columns = pl.concat(tables, how="diagonal_relaxed")
    raw = RawTable("reports", columns, np.arange(1, columns.height + 1), facts=facts)
    origin = configuration.said("frame", "origin")
    projection: Projection = configuration.said("frame", "projection") or "tangent"
    if known is not None and known.frame is not None:
        origin = known.frame.latitude_deg, known.frame.longitude_deg
        projection = known.frame.projection
    return reports_in(
        raw,
        frame_origin=None if origin is None else (origin[0], origin[1]),
        frame_projection=projection,
        on_bad_row="skip",
        kinds=configuration.plugins.kinds(),
        places=configuration.places(),
    )


def _complete(settings: Settings) -> dict[str, Any]:
    """Return the keys with the values used, each thing said once."""
    values = {
        key: dict(value) if isinstance(value, Mapping) else value
        for key, value in settings.values.items()
    }
    tables: dict[str, dict[str, Any]] = {
        name: dict(own) for name, own in values["sensors"].items()
    }
    for sensor in settings.sensors:
        own = tables[sensor.name]
        kind = sensor.measurement
        if isinstance(kind, MeasurementKind):
            own["measurement"] = kind.word
        own.pop("clutter_per_scan", None)
        own["clutter_density"] = sensor.clutter_density
        turn = sensor.rotation
        if turn is not None:
            # A wandering turn goes on as at present; the tracker follows it from there.
            time = float(getattr(turn, "knots", np.zeros(1))[-1])
            phase = turn.azimuth(time) - turn.direction * 2.0 * np.pi * time / turn.period
            own |= {
                "rotation": sense_of(turn),
                "scan_period": turn.period,
                "phase_deg": float(np.degrees(phase) % 360.0),
            }
            own.pop("scans", None)
    values["sensors"] = tables
    if "search" in values:
        values["search"] = {k: v for k, v in values["search"].items() if k != "deadline_ms"}
    return values


def _span(heard: Sequence[Arrived]) -> float:
    first, last = np.inf, -np.inf
    for each in heard:
        column = each.table["time"]
        if isinstance(column.dtype, pl.Datetime):
            column = column.dt.cast_time_unit("us").to_physical() / 1e6
        elif column.dtype == pl.String:
            dates = column.str.to_datetime(time_zone="UTC", strict=False)
            column = dates.dt.cast_time_unit("us").to_physical() / 1e6
        numbers = column.cast(pl.Float64).drop_nulls()
        if len(numbers):
            first = min(first, float(numbers.min()))  # type: ignore[arg-type]
            last = max(last, float(numbers.max()))  # type: ignore[arg-type]
    return max(0.0, last - first) if np.isfinite(last - first) else 0.0
