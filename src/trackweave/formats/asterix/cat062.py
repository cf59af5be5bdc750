"""Category 062: tracks of a system that fuses sensors (editions 1.16 to 1.21)."""

import numpy as np

from trackweave.formats.asterix.category import Category
from trackweave.formats.asterix.layout import parsed_layout
from trackweave.formats.asterix.records import Records
from trackweave.formats.asterix.values import (
    FOOT_M,
    QUARTER_LEVEL_M,
    TIME_S,
    Columns,
    Texts,
    address,
    callsign,
    chosen,
    latitude_longitude,
    mode_a,
    sensor_names,
    spelled,
)

__all__ = ["CATEGORY"]

_LAYOUT = """
010 SAC:8 SIC:8
-
015 8
070 24
105 LAT:32s LON:32s
100 X:24s Y:24s
185 VX:16s VY:16s
210 AX:8s AY:8s
060 V:1 G:1 CH:1 -1 MODE3A:12
245 STI:2 -6 CHR:48
380 {
  ADR 24
  ID 48
  MHG 16
  IAS IM:1 IAS:15
  TAS 16
  SAL SAS:1 SRC:2 ALT:13s
  FSS MV:1 AH:1 AM:1 ALT:13s
  TIS + NAV:1 NVB:1 -5
  TID * TCA:1 NC:1 TCPN:6 ALT:16s LAT:24s LON:24s PT:4 TD:2 TRA:1 TOA:1 TOV:24 TTR:16
  COM COM:3 STAT:3 -2 SSC:1 ARC:1 AIC:1 B1A:1 B1B:4
  SAB AC:2 MN:2 DC:2 GBS:1 -6 STAT:3
  ACS 56
  BVR 16s
  GVR 16s
  RAN 16s
  TAR TI:2 -6 ROT:7s -1
  TAN 16
  GS 16s
  VUN 8
  MET WS:1 WD:1 TMP:1 TRB:1 -4 WSD:16 WDD:16 TMPD:16s TRBD:8
  EMC 8
  POS LAT:24s LON:24s
  GAL 16s
  PUN -4 PUN:4
  BDSDATA * MBDATA:56 BDS:8
  IAR 16
  MAC 16
  BPS -4 BPS:12
}
040 16
080 + MON:1 SPI:1 MRH:1 SRC:3 CNF:1 | SIM:1 TSE:1 TSB:1 FPC:1 AFF:1 STP:1 KOS:1 \
| AMA:1 MD4:2 ME:1 MI:1 MD5:2 | CST:1 PSR:1 SSR:1 MDS:1 ADS:1 SUC:1 AAC:1 \
| SDS:2 EMS:3 PFT:1 FPLT:1 | DUPT:1 DUPF:1 DUPM:1 SFC:1 IDD:1 IEC:1 MLAT:1 | M5I:1 -6
290 {
  TRK 8
  PSR 8
  SSR 8
  MDS 8
  ADS 16
  ES 8
  VDL 8
  UAT 8
  LOP 8
  MLT 8
}
200 TRANS:2 LONG:2 VERT:2 ADF:1 -1
295 {
  MFL 8
  MD1 8
  MD2 8
  MDA 8
  MD4 8
  MD5 8
  MHG 8
  IAS 8
  TAS 8
  SAL 8
  FSS 8
  TID 8
  COM 8
  SAB 8
  ACS 8
  BVR 8
  GVR 8
  RAN 8
  TAR 8
  TAN 8
  GSP 8
  VUN 8
  MET 8
  EMC 8
  POS 8
  GAL 8
  PUN 8
  MB 8
  IAR 8
  MAC 8
  BPS 8
}
136 16s
130 16s
135 QNH:1 CTB:15s
220 16s
390 {
  TAG SAC:8 SIC:8
  CS 56
  IFI TYP:2 -3 NBR:27
  FCT GATOAT:2 FR1FR2:2 RVSM:2 HPR:1 -1
  TAC 32
  WTC 8
  DEP 32
  DST 32
  RDS NU1:8 NU2:8 LTR:8
  CFL 16
  CTL CENTRE:8 POSITION:8
  TOD * TYP:5 DAY:2 -4 HOR:5 -2 MIN:6 AVS:1 -1 SEC:6
  AST 48
  STS EMP:2 AVL:2 -4
  STD 56
  STA 56
  PEM -3 VA:1 MODE3A:12
  PEC 56
}
270 + LENGTH:7 | ORIENTATION:7 | WIDTH:7
300 8
110 {
  SUM M5:1 ID:1 DA:1 M1:1 M2:1 M3:1 MC:1 X:1
  PMN -2 PIN:14 -3 NAT:5 -2 MIS:6
  POS LAT:24s LON:24s
  GA -1 RES:1 GA:14s
  EM1 -4 EM1:12
  TOS 8s
  XP -3 X5:1 XC:1 X3:1 X2:1 X1:1
}
120 -4 MODE2:12
510 ~ IDENT:8 TRACK:15
500 {
  APC X:16 Y:16
  COV 16s
  APW LAT:16 LON:16
  AGA 8
  ABA 8
  ATV X:8 Y:8
  AA X:8 Y:8
  ARC 8
}
340 {
  SID SAC:8 SIC:8
  POS RHO:16 THETA:16
  HEIGHT 16s
  MDC V:1 G:1 LMC:14s
  MDA V:1 G:1 L:1 -1 MODE3A:12
  TYP TYP:3 SIM:1 RAB:1 TST:1 -2
}
-
-
-
-
-
RE =
SP =
"""
_STATUS = ("confirmed", "tentative", "coasting", "ended")


def _columns(records: Records) -> Columns:
    on_earth = records.has("105")
    status = records.flag("080", "CNF") * 1
    status[records.flag("080", "CST")] = 2
    status[records.flag("080", "TSE")] = 3
    return {
        "time": records.number("070", scale=TIME_S),
        "sensor": sensor_names(records),
        **latitude_longitude(records, "105", 180 / 2**25),
        "x": np.where(on_earth, np.nan, records.number("100", "X", 0.5)),
        "y": np.where(on_earth, np.nan, records.number("100", "Y", 0.5)),
        "vx": records.number("185", "VX", 0.25),
        "vy": records.number("185", "VY", 0.25),
        "height_m": chosen(
            records.number("130", scale=6.25 * FOOT_M),
            records.number("135", "CTB", QUARTER_LEVEL_M),
            records.number("136", scale=QUARTER_LEVEL_M),
        ),
        "identity": address(records, "380/ADR"),
        "callsign": _callsign(records),
        **mode_a(records, "060"),
        "track_number": records.number("040"),
        "status": spelled(status, records.has("080"), _STATUS.__getitem__),
        "simulated": records.flag("080", "SIM"),
    }


def _callsign(records: Records) -> Texts:
    own, told = callsign(records, "245", "CHR"), callsign(records, "380/ID")
    return np.where(own == None, told, own)  # noqa: E711


CATEGORY = Category((parsed_layout(_LAYOUT),), _columns)
