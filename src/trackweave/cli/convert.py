"""The commands ``convert`` and ``formats``."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import typer

from trackweave.cli.edge import Voice
from trackweave.domain.facts import Place
from trackweave.domain.reports import BadRow
from trackweave.errors import DataFormatError, InvalidInputError
from trackweave.formats.format import Format, Output
from trackweave.formats.reading import load
from trackweave.formats.registry import format_named, formats
from trackweave.io.columns import datetime_column, read_times, typed_column
from trackweave.io.encoding import encode_table
from trackweave.io.output import RECORD, OutputFile, write_folder
from trackweave.io.reports import reports_in
from trackweave.io.run_files import TABLES, read_run, reports_file
from trackweave.io.tables import OnBadRow, RawTable, load_table, with_our_names

__all__ = ["run_convert", "run_formats"]

_ASSIGNED = {"report", "track", "probability"}
_MEASURED = ({"x", "y"}, {"lat", "lon"}, {"range_m", "azimuth_deg"}, {"bearing_deg"})


def run_convert(
    voice: Voice,
    source: Path,
    out: Path,
    *,
    told: str | None = None,
    to: str | None = None,
    hide_identities: bool = False,
    on_bad_row: OnBadRow = "fail",
) -> dict[str, Any]:
    """Turn one format into another; return what was read and written."""
    target = _target(out, to)
    if not out.is_dir():
        OutputFile(out).check([source])
    notes, undecoded, skipped = tuple[str, ...](), 0, tuple[BadRow, ...]()
    if source.is_dir() and (source / RECORD).is_file():
        output = _of_run(source)
        table = output.tracks
    else:
        raw = _checked(with_our_names(load(source, told)), on_bad_row)
        skipped = raw.skipped
        table = _with_sensors_places(_typed(raw), raw.facts.places)
        notes, undecoded = raw.notes, raw.undecoded.count
        if hide_identities:
            table = _hidden(table)
        if target.name == "geojson" and set(table.columns) >= _ASSIGNED:
            table = _with_places(table, source)
        output = _beside_run(table, source)
    if target.is_table:
        ending = next(
            e for e in target.endings[::-1] if out.name.endswith(e) or e == target.endings[0]
        )
        files = {out.name: encode_table(table, f"x{ending}")}
    else:
        assert target.writer is not None
        if "track" not in table.columns and not target.takes_reports:
            output = Output(_truth(table, str(source)))
        files = dict(target.writer(output))
    _write(files, out)
    for note in notes:
        voice.say(note)
    if skipped:
        voice.say(f"{len(skipped):,} bad rows left out; the first: {raw.message_of(skipped[0])}")
    voice.say(f"written: {out}")
    return {
        "out": str(out),
        "to": target.name,
        "rows": len(table),
        "skipped_rows": len(skipped),
        "undecoded_records": undecoded,
        "notes": list(notes),
    }


def _checked(raw: RawTable, on_bad_row: OnBadRow) -> RawTable:
    """Return a table without rows that `track` would not take; refuse them where told to."""
    names = set(raw.columns.columns)
    if "track" not in names and "time" in names and any(each <= names for each in _MEASURED):
        bad = reports_in(raw, on_bad_row=on_bad_row, anywhere=True).skipped
    elif raw.skipped and on_bad_row == "fail":
        raise DataFormatError(raw.message_of(raw.skipped[0]))
    else:
        bad = raw.skipped
    keep = ~np.isin(raw.row, [each.row for each in bad])
    return replace(raw, columns=raw.columns.filter(keep), row=raw.row[keep], skipped=bad)


def _write(files: dict[str, bytes], out: Path) -> None:
    if len(files) == 1:
        OutputFile(out).write(next(iter(files.values())))
        return
    # In the folder that was asked for, without the name of the one that a run has.
    tops = {name.partition("/")[0] for name in files}
    whole = len(tops) == 1
    write_folder(out, {n.partition("/")[2] if whole else n: data for n, data in files.items()})


def _target(out: Path, to: str | None) -> Format:
    """Return the format to write, by what was told or by the name's ending."""
    if to is not None:
        return format_named(to, writes=True)
    able = [each for each in formats().values() if each.writer is not None]
    name = out.name.lower()
    fits = [(len(e), each) for each in able for e in each.endings if name.endswith(e)]
    longest = max((length for length, _ in fits), default=0)
    best = [each for length, each in fits if length == longest]
    if len(best) == 1:
        return best[0]
    endings = ", ".join(each.endings[0] for each in able)
    raise InvalidInputError(f"--out: {out}; expected a name that ends in {endings}, or --to")


def _typed(raw: RawTable) -> pl.DataFrame:
    """Return a table's columns as numbers and times where they are some."""
    columns = raw.columns
    if raw.is_text:
        columns = pl.DataFrame({each.name: typed_column(each) for each in columns.get_columns()})
    for name in {"time", "last_update"} & set(columns.columns):
        times = read_times(columns[name])
        if times.iso and columns[name].dtype == pl.String and not times.numbers.missing.any():
            columns = columns.with_columns(datetime_column(name, times.numbers.values))
    return columns


def _of_run(folder: Path) -> Output:
    frame = read_run(folder).frame
    tracks, history, assignments = (
        _typed(load_table(folder / name, may_be_empty=True)) for name in TABLES
    )
    return Output(tracks, history, assignments, frame)


def _with_sensors_places(table: pl.DataFrame, places: Mapping[str, Place]) -> pl.DataFrame:
    """Return ranges with where the recording tells that their sensors stand."""
    ours = {"sensor_lat", "sensor_lon", "sensor_x", "sensor_y"}
    is_relative = {"sensor", "range_m"} <= set(table.columns) or "bearing_deg" in table.columns
    if not places or not is_relative or ours & set(table.columns):
        return table
    sensor = pl.col("sensor").cast(pl.String)
    told = {
        "sensor_lat": {name: place.latitude_deg for name, place in places.items()},
        "sensor_lon": {name: place.longitude_deg for name, place in places.items()},
        "sensor_alt_m": {name: place.altitude_m for name, place in places.items()},
    }
    return table.with_columns(
        sensor.replace_strict(values, default=None, return_dtype=pl.Float64).alias(name)
        for name, values in told.items()
    )


def _beside_run(table: pl.DataFrame, source: Path) -> Output:
    """Return a table with what else its run has, where it is a run's own table of tracks."""
    folder = source.parent
    if source.name not in {"tracks.csv", "history.csv"} or not (folder / RECORD).is_file():
        return Output(table)
    run = _of_run(folder)
    return Output(table, assignments=run.assignments, frame=run.frame)


def _with_places(table: pl.DataFrame, source: Path) -> pl.DataFrame:
    """Return assignments with the latitudes and longitudes of the reports of their run."""
    if {"lat", "lon"} <= set(table.columns):
        return table
    run = read_run(source.parent) if (source.parent / RECORD).is_file() else None
    path = None if run is None else reports_file(run)
    raw = None
    if run is not None and path is not None:
        raw = with_our_names(load(path, run.record["input"].get("format")))
    if raw is None or not {"lat", "lon"} <= set(raw.columns.columns):
        gone = "the reports of a run are not where they were"
        have = gone if raw is None else "the reports of its run have none either"
        raise InvalidInputError(
            f"{source}: no columns lat and lon, and {have}; expected assignments of reports in "
            "lat,lon, or a run's tracks.csv, which has them where reports or [frame] origin do"
        )
    own = raw.columns["report"] if "report" in raw.columns.columns else pl.Series(raw.row)
    places = raw.columns.select(
        own.cast(pl.String).alias("report"),
        *(pl.col(name).cast(pl.Float64, strict=False) for name in ("lat", "lon")),
    )
    named = table.with_columns(pl.col("report").cast(pl.String))
    return named.join(places, on="report", how="left", maintain_order="left")


def _hidden(table: pl.DataFrame) -> pl.DataFrame:
    if "identity" not in table.columns:
        raise InvalidInputError("--hide-identities: the input tells no identity")
    return table.drop("target", strict=False).rename({"identity": "target"})


def _truth(reports: pl.DataFrame, name: str) -> pl.DataFrame:
    """Return reports that say whose they are as tracks, numbered as they first appear."""
    if "target" not in reports.columns:
        raise InvalidInputError(
            f"{name}: reports that do not say whose they are (no column target); expected tracks, "
            "for which `trackweave track --also` is"
        )
    known = reports.filter(pl.col("target").is_not_null()).rename({"target": "name"})
    if known["name"].dtype.is_integer() and known["name"].min() >= 0:  # type: ignore[operator]
        known = known.with_columns(track=pl.col("name").cast(pl.Int64))
    else:
        known = known.with_row_index("track").with_columns(pl.col("track").min().over("name"))
        known = known.with_columns(pl.col("track").rank("dense").cast(pl.Int64))
    return known.with_columns(status=pl.lit("confirmed")).sort("time", "track")


def run_formats(voice: Voice) -> dict[str, Any]:
    """Print every format there is; return what each carries and may be told."""
    found = [
        {
            "name": each.name,
            "title": each.title,
            "reads": each.can_read,
            "writes": each.writer is not None,
            "endings": list(each.endings),
            "carries": each.carries,
            "loses": each.loses,
            "extra": each.extra,
            "options": {
                option.name: {
                    "default": option.default,
                    "meaning": option.meaning,
                    "choices": list(option.choices),
                }
                for option in each.options
            },
        }
        for each in formats().values()
    ]
    if not voice.quiet:
        for line in _lines(found):
            typer.echo(line)
    return {"formats": found}


def _lines(found: list[dict[str, Any]]) -> list[str]:
    lines = []
    for each in sorted(found, key=lambda one: str(one["name"])):
        can = "+".join(word for word in ("reads", "writes") if each[word])
        extra = f"; needs pip install trackweave[{each['extra']}]" if each["extra"] else ""
        lines.append(f"{each['name']} ({can}): {each['title']}{extra}")
        lines.append(f"    carries {each['carries']}; loses {each['loses']}")
        for name, told in each["options"].items():
            choices = f" ({', '.join(told['choices'])})" if told["choices"] else ""
            lines.append(
                f"    --from '{each['name']}?{name}={told['default']}': {told['meaning']}{choices}"
            )
    return lines
