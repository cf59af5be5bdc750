"""Category 048: plots and local tracks of a radar (editions to 1.32)."""

import numpy as np

from trackweave.formats.asterix.category import Category
from trackweave.formats.asterix.layout import parsed_layout
from trackweave.formats.asterix.records import Records
from trackweave.formats.asterix.values import (
    DEGREES_16,
    NAUTICAL_MILE_M,
    QUARTER_LEVEL_M,
    TIME_S,
    Columns,
    Numbers,
    address,
    callsign,
    chosen,
    level,
    mode_a,
    sensor_names,
    words,
)

__all__ = ["CATEGORY"]

_LAYOUT = """
010 SAC:8 SIC:8
140 24
020 + TYP:3 SIM:1 RDP:1 SPI:1 RAB:1 | TST:1 ERR:1 XPP:1 ME:1 MI:1 FOEFRI:2 \
| ADSB/EP:1 ADSB/VAL:1 SCN/EP:1 SCN/VAL:1 PAI/EP:1 PAI/VAL:1 -1 \
| ACASXV/EP:1 ACASXV/VAL:4 POXPR/EP:1 POXPR/VAL:1 \
| POACT/EP:1 POACT/VAL:1 DTFXPR/EP:1 DTFXPR/VAL:1 DTFACT/EP:1 DTFACT/VAL:1 -1 \
| IRMXPR/EP:1 IRMXPR/VAL:1 IRMACT/EP:1 IRMACT/VAL:1 -3
040 RHO:16 THETA:16
070 V:1 G:1 L:1 -1 MODE3A:12
090 V:1 G:1 FL:14s
130 {
  SRL 8
  SRR 8
  SAM 8s
  PRL 8
  PAM 8s
  RPD 8s
  APD 8s
}
220 24
240 48
250 * MBDATA:56 BDS1:4 BDS2:4
161 -4 TRN:12
042 X:16s Y:16s
200 GSP:16 HDG:16
170 + CNF:1 RAD:2 DOU:1 MAH:1 CDM:2 | TRE:1 GHO:1 SUP:1 TCC:1 -3
210 SIGX:8 SIGY:8 SIGV:8 SIGH:8
030 ~ 7
080 -4 QA4:1 QA2:1 QA1:1 QB4:1 QB2:1 QB1:1 QC4:1 QC2:1 QC1:1 QD4:1 QD2:1 QD1:1
100 V:1 G:1 -2 MODEC:12 \
-4 QC1:1 QA1:1 QC2:1 QA2:1 QC4:1 QA4:1 QB1:1 QD1:1 QB2:1 QD2:1 QB4:1 QD4:1
110 -2 3DH:14s
120 {
  CAL D:1 -5 CAL:10s
  RDS * DOP:16 AMB:16 FRQ:16
}
230 COM:3 STAT:3 SI:1 -1 MSSC:1 ARC:1 AIC:1 B1A:1 B1B:4
260 56
055 V:1 G:1 L:1 MODE1:5
050 V:1 G:1 L:1 -1 MODE2:12
065 -3 QA4:1 QA2:1 QA1:1 QB2:1 QB1:1
060 -4 QA4:1 QA2:1 QA1:1 QB4:1 QB2:1 QB1:1 QC4:1 QC2:1 QC1:1 QD4:1 QD2:1 QD1:1
SP =
RE = {
  MD5 {
    SUM 8
    PMN 32
    POS 48
    GA 16
    EM1 16
    TOS 8
    XP 8
  }
  M5N {
    SUM 8
    PMN 32
    POS 48
    GA 16
    EM1 16
    TOS 8
    XP 8
    FOM 8
  }
  M4E + 7
  RPC {
    SCO 8
    SRC 16
    RW 16
    AR 16
  }
  ERR 24
}
"""
_DETECTIONS = (
    "none", "psr", "ssr", "psr+ssr",
    "mode-s-all-call", "mode-s-roll-call", "psr+mode-s-all-call", "psr+mode-s-roll-call",
)  # fmt: skip


def _columns(records: Records) -> Columns:
    doubtful = records.flag("120/CAL", "D")
    return {
        "time": records.number("140", scale=TIME_S),
        "sensor": sensor_names(records),
        "range_m": _range(records),
        "azimuth_deg": records.number("040", "THETA", DEGREES_16),
        "range_rate_mps": np.where(doubtful, np.nan, records.number("120/CAL", "CAL")),
        **level(records, records.number("110", "3DH", QUARTER_LEVEL_M)),
        "strength": chosen(records.number("130/PAM"), records.number("130/SAM")),
        "identity": address(records, "220"),
        "callsign": callsign(records, "240"),
        **mode_a(records),
        "track_number": records.number("161", "TRN"),
        "detection": words(records, "020", "TYP", _DETECTIONS),
        "simulated": records.flag("020", "SIM") | records.flag("020", "TST"),
        "field_monitor": records.flag("020", "RAB"),
    }


def _range(records: Records) -> Numbers:
    """Return ranges [m]; those beyond what the item can say stand in the reserved expansion."""
    unit = NAUTICAL_MILE_M / 256
    beyond = records.flag("020", "ERR")
    near = records.number("040", "RHO", unit)
    if not beyond.any():
        return near
    return np.where(beyond, records.number("RE/ERR", scale=unit), near)


CATEGORY = Category((parsed_layout(_LAYOUT),), _columns)
