"""Category 020: multilateration (editions 1.5 to 1.11)."""

import numpy as np

from trackweave.formats.asterix.category import Category
from trackweave.formats.asterix.layout import parsed_layout
from trackweave.formats.asterix.records import Records
from trackweave.formats.asterix.values import (
    FOOT_M,
    TIME_S,
    Columns,
    address,
    callsign,
    latitude_longitude,
    level,
    mode_a,
    sensor_names,
)

__all__ = ["CATEGORY"]

_LAYOUT = """
010 SAC:8 SIC:8
020 + SSR:1 MS:1 HF:1 VDL4:1 UAT:1 DME:1 OT:1 | RAB:1 SPI:1 CHN:1 GBS:1 CRT:1 SIM:1 TST:1 \
| CF:2 -5
140 24
041 LAT:32s LON:32s
042 X:24s Y:24s
161 -4 TRN:12
170 + CNF:1 TRE:1 CST:1 CDM:2 MAH:1 STH:1 | GHO:1 -6
070 V:1 G:1 L:1 -1 MODE3A:12
202 VX:16s VY:16s
090 V:1 G:1 FL:14s
100 V:1 G:1 -2 MODEC:12 \
-4 QC1:1 QA1:1 QC2:1 QA2:1 QC4:1 QA4:1 QB1:1 QD1:1 QB2:1 QD2:1 QB4:1 QD4:1
220 24
245 STI:2 -6 CHR:48
110 16s
105 16s
210 AX:8s AY:8s
300 8
310 TRB:1 MSG:7
500 {
  DOP X:16 Y:16 XY:16
  SDP X:16 Y:16 XY:16
  SDH 16
}
400 * BIT1:1 BIT2:1 BIT3:1 BIT4:1 BIT5:1 BIT6:1 BIT7:1 BIT8:1
250 * BDSDATA:56 BDS1:4 BDS2:4
230 COM:3 STAT:3 CASEVN:2 MSSC:1 ARC:1 AIC:1 B1A:1 B1B:4
260 56
030 ~ 7
055 V:1 G:1 L:1 MODE1:5
050 V:1 G:1 L:1 -1 MODE2:12
RE =
SP =
"""


def _columns(records: Records) -> Columns:
    plane = ~records.has("041")
    heights = [records.number(item, scale=6.25 * FOOT_M) for item in ("105", "110")]
    return {
        "time": records.number("140", scale=TIME_S),
        "sensor": sensor_names(records),
        **latitude_longitude(records, "041", 180 / 2**25),
        "x": np.where(plane, records.number("042", "X", 0.5), np.nan),
        "y": np.where(plane, records.number("042", "Y", 0.5), np.nan),
        "vx": records.number("202", "VX", 0.25),
        "vy": records.number("202", "VY", 0.25),
        **level(records, *heights),
        "identity": address(records, "220"),
        "callsign": callsign(records, "245", "CHR"),
        **mode_a(records),
        "track_number": records.number("161", "TRN"),
        "simulated": records.flag("020", "SIM") | records.flag("020", "TST"),
        "field_monitor": records.flag("020", "RAB"),
    }


CATEGORY = Category((parsed_layout(_LAYOUT),), _columns)
