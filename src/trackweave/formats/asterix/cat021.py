"""Category 021: automatic dependent surveillance (ADS-B) as ground stations tell it.

Editions 2.1 to 2.7 agree with one another; before them each layout was another.
"""

from trackweave.formats.asterix.category import Category
from trackweave.formats.asterix.layout import parsed_layout
from trackweave.formats.asterix.records import Records
from trackweave.formats.asterix.values import (
    FOOT_M,
    QUARTER_LEVEL_M,
    TIME_S,
    Columns,
    address,
    callsign,
    chosen,
    latitude_longitude,
    mode_a,
    sensor_names,
)

__all__ = ["DEFAULT_EDITION", "EDITIONS"]

DEFAULT_EDITION = "2"

_ICAO_WEATHER_AND_INTENT = """\
220 {
  WS 16
  WD 16
  TMP 16s
  TRB 8
}
146 SAS:1 {source}:2 ALT:13s
148 MV:1 AH:1 AM:1 ALT:13s
110 {
  TIS + NAV:1 NVB:1 -5
  TID * TCA:1 NC:1 TCPN:6 ALT:16s LAT:24s LON:24s PT:4 TD:2 TRA:1 TOA:1 TOV:24 TTR:16
}
"""
_LAYOUT = (
    """
010 SAC:8 SIC:8
040 + ATP:3 ARC:2 RC:1 RAB:1 | DCR:1 GBS:1 SIM:1 TST:1 SAA:1 CL:2 \
| -1 LLC:1 IPC:1 NOGO:1 CPR:1 LDPJ:1 RCF:1 | TBC/EP:1 TBC/VAL:6 | MBC/EP:1 MBC/VAL:6
161 -4 TRNUM:12
015 8
071 24
130 LAT:24s LON:24s
131 LAT:32s LON:32s
072 24
150 IM:1 AS:15
151 RE:1 TAS:15
080 24
073 24
074 FSI:2 TOMRP:30
075 24
076 FSI:2 TOMRP:30
140 16s
090 + NUCRNACV:3 NUCPNIC:4 | NICBARO:1 SIL:2 NACP:4 | -2 SILS:1 SDA:2 GVA:2 \
| PIC:4 SRC:1 -2 | -2 VALSTATE/EP:1 VALSTATE/VAL:2 VD:1 VQ:1 \
| VALDISTP1:7 | VALDISTP2:7 | VALDISTQUALP1:7 | VALDISTQUALP2:7
210 -1 VNS:1 VN:3 LTT:3
070 -4 MODE3A:12
230 16s
145 16s
152 16
200 ICF:1 LNAV:1 ME:1 PS:3 SS:2
155 RE:1 BVR:15s
157 RE:1 GVR:15s
160 RE:1 GS:15 TA:16
165 -6 TAR:10s
077 24
170 48
020 8
"""
    + _ICAO_WEATHER_AND_INTENT.replace("{source}", "S")
    + """\
016 8
008 RA:1 TC:2 TS:1 ARV:1 CDTIA:1 NOTTCAS:1 SA:1
271 + -2 POA:1 CDTIS:1 B2LOW:1 RAS:1 IDENT:1 | LW:4 -3
132 8s
250 * MBDATA:56 BDS:8
260 TYP:5 STYP:3 ARA:14 RAC:4 RAT:1 MTE:1 TTI:2 TID:26
400 8
295 {
  AOS 8
  TRD 8
  M3A 8
  QI 8
  TI1 8
  MAM 8
  GH 8
  FL 8
  SAL 8
  FSA 8
  AS 8
  TAS 8
  MH 8
  BVR 8
  GVR 8
  GV 8
  TAR 8
  TI2 8
  TS 8
  MET 8
  ROA 8
  ARA 8
  SCC 8
}
-
-
-
-
-
RE =
SP =
"""
)
_OLD_LAYOUT = """
010 SAC:8 SIC:8
040 DCR:1 GBS:1 SIM:1 TST:1 RAB:1 SAA:1 SPI:1 -1 ATP:3 ARC:2 -3
030 24
130 LAT:{bits}s LON:{bits}s
080 24
140 16s
090 AC:2 MN:2 DC:2 -6 PA:4s
210 -3 DTI:1 MDS:1 UAT:1 VDL:1 OTR:1
230 16s
145 16s
150 IM:1 AS:15
151 16
152 16
155 16s
157 16s
160 GS:16s TA:16
165 + TI:2 -5 | ROT:7s
170 48
095 8
032 8
200 8
020 8
""" + _ICAO_WEATHER_AND_INTENT.replace("{source}", "SRC")
_END = 5 * "-\n" + "RE =\nSP =\n"
_LAYOUT_0_26 = _OLD_LAYOUT.replace("{bits}", "32") + "070 V:1 G:1 L:1 -1 MODE3A:12\n131 8\n"
_LAYOUT_0_23 = _OLD_LAYOUT.replace("{bits}", "24") + 2 * "-\n"


def _columns(records: Records) -> Columns:
    fine = latitude_longitude(records, "131", 180 / 2**30)
    coarse = latitude_longitude(records, "130", 180 / 2**23)
    moments = (records.number(item, scale=TIME_S) for item in ("071", "073", "075", "077"))
    code = mode_a(records)["mode_a"]
    return {
        "time": chosen(*moments),
        "lat": chosen(fine["lat"], coarse["lat"]),
        "lon": chosen(fine["lon"], coarse["lon"]),
        **_common(records),
        "mode_a": code,
        "strength": records.number("132"),
        "track_number": records.number("161", "TRNUM"),
    }


def _old_columns(records: Records) -> Columns:
    scale = 180 / 2 ** (25 if records.knows("131") else 23)
    codes = mode_a(records) if records.knows("070") else {}
    return {
        "time": records.number("030", scale=TIME_S),
        **latitude_longitude(records, "130", scale),
        **_common(records),
        **codes,
    }


def _common(records: Records) -> Columns:
    return {
        "sensor": sensor_names(records),
        "height_m": chosen(
            records.number("140", scale=6.25 * FOOT_M),
            records.number("145", scale=QUARTER_LEVEL_M),
        ),
        "identity": address(records, "080"),
        "callsign": callsign(records, "170"),
        "simulated": records.flag("040", "SIM") | records.flag("040", "TST"),
        "field_monitor": records.flag("040", "RAB"),
    }


EDITIONS = {
    DEFAULT_EDITION: Category((parsed_layout(_LAYOUT),), _columns),
    "0.26": Category((parsed_layout(_LAYOUT_0_26 + _END),), _old_columns),
    "0.23": Category((parsed_layout(_LAYOUT_0_23 + _END),), _old_columns),
}
