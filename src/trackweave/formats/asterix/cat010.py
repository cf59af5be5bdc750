"""Category 010: surface movement radars and multilateration of an airport (edition 1.1)."""

import numpy as np

from trackweave.formats.asterix.category import Category
from trackweave.formats.asterix.layout import parsed_layout
from trackweave.formats.asterix.records import Records
from trackweave.formats.asterix.values import (
    DEGREES_16,
    FOOT_M,
    TIME_S,
    Columns,
    address,
    callsign,
    latitude_longitude,
    level,
    mode_a,
    sensor_names,
    words,
)

__all__ = ["CATEGORY"]

_LAYOUT = """
010 SAC:8 SIC:8
000 8
020 + TYP:3 DCR:1 CHN:1 GBS:1 CRT:1 | SIM:1 TST:1 RAB:1 LOP:2 TOT:2 | SPI:1 -6
140 24
041 LAT:32s LON:32s
040 RHO:16 TH:16
042 X:16s Y:16s
200 GSP:16 TRA:16
202 VX:16s VY:16s
161 -4 TRK:12
170 + CNF:1 TRE:1 CST:2 MAH:1 TCC:1 STH:1 | TOM:2 DOU:3 MRS:2 | GHO:1 -6
060 V:1 G:1 L:1 -1 MODE3A:12
220 24
245 STI:2 -6 CHR:48
250 * MBDATA:56 BDS1:4 BDS2:4
300 8
090 V:1 G:1 FL:14s
091 16s
270 + LENGTH:7 | ORIENTATION:7 | WIDTH:7
550 NOGO:2 OVL:1 TSV:1 DIV:1 TTF:1 -2
310 TRB:1 MSG:7
500 DEVX:8 DEVY:8 COVXY:16s
280 * DRHO:8s DTHETA:8s
131 8
210 AX:8s AY:8s
-
SP =
RE =
"""
_DETECTIONS = (
    "multilateration-ssr", "multilateration-mode-s", "ads-b", "psr",
    "magnetic-loop", "multilateration-hf", "undefined", "other",
)  # fmt: skip


def _columns(records: Records) -> Columns:
    # A row measures one thing: latitude and longitude, or else range and azimuth, or else x, y.
    polar = ~records.has("041")
    plane = polar & ~records.has("040")
    return {
        "time": records.number("140", scale=TIME_S),
        "sensor": sensor_names(records),
        **latitude_longitude(records, "041", 180 / 2**31),
        "range_m": np.where(polar, records.number("040", "RHO"), np.nan),
        "azimuth_deg": np.where(polar, records.number("040", "TH", DEGREES_16), np.nan),
        "x": np.where(plane, records.number("042", "X"), np.nan),
        "y": np.where(plane, records.number("042", "Y"), np.nan),
        "vx": records.number("202", "VX", 0.25),
        "vy": records.number("202", "VY", 0.25),
        **level(records, records.number("091", scale=6.25 * FOOT_M)),
        "strength": records.number("131"),
        "identity": address(records, "220"),
        "callsign": callsign(records, "245", "CHR"),
        **mode_a(records, "060"),
        "track_number": records.number("161", "TRK"),
        "detection": words(records, "020", "TYP", _DETECTIONS),
        "simulated": records.flag("020", "SIM") | records.flag("020", "TST"),
        "field_monitor": records.flag("020", "RAB"),
    }


CATEGORY = Category((parsed_layout(_LAYOUT),), _columns)
