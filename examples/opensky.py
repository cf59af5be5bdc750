"""OpenSky: latitudes and longitudes of aircraft → reports.

    python examples/opensky.py OpenSky_Plane_States.csv OUT
    trackweave track OUT/reports.csv --out OUT/result

The file has a row for each aircraft every ten seconds, with columns time, icao24, lat and lon
among others. The address icao24 becomes ``target``, the truth, which no tracker reads; with
``--identities`` it becomes ``identity`` as well, which a tracker uses.
"""

import argparse
from pathlib import Path

import polars as pl


def read(path: Path) -> pl.DataFrame:
    """Return the reports, each with the aircraft that it is of."""
    if not path.exists():
        raise SystemExit(f"{path}: not there; expected a table of aircraft")
    table = pl.read_csv(path, infer_schema_length=None)
    return table.select("time", "lat", "lon", pl.col("icao24").alias("target"))


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("recording", type=Path, help="the table of aircraft")
    parser.add_argument("out", type=Path, help="folder for reports.csv")
    parser.add_argument("--identities", action="store_true", help="let the tracker know them")
    arguments = parser.parse_args()
    reports = read(arguments.recording)
    if arguments.identities:
        reports = reports.with_columns(pl.col("target").alias("identity"))
    arguments.out.mkdir(parents=True, exist_ok=True)
    reports.write_csv(arguments.out / "reports.csv")
    print(f"{len(reports)} reports of {reports['target'].n_unique()} aircraft")


if __name__ == "__main__":
    main()
