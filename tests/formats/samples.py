"""A small file of each format that can be read as bytes, with what is in it."""

import json

NMEA = rb"""\c:1609841515,s:r003669945*46\!AIVDM,1,1,,B,15NBj>PP1gG>1PVKTDTUJOv00<0M,0*09
# a comment
$PGHP,1,2009,5,9,0,0,0,10,338,2,,1,09*17
!AIVDM,1,1,,A,16:=?;0P00`SstvFnFbeGH6L088h,0*44
!AIVDM,1,1,,A,169a:nP01g`hm4pB7:E0;@0L088i,0*5E
!AIVDM,1,1,,A,169a:nP01g`hm4pB7:E0;@0L088i,0*5F,1609841516
!AIVDM,1,1,,A,16`l:v8P0W8Vw>fDVB0t8OvJ0H;9,0*0A,r003669945,1609841517
"""
# A position of two sentences, one of whose second part comes first and is lost, a voyage.
NMEA_PARTS = rb"""\s:a,c:1609841515*5F\!AIVDM,2,1,7,A,C5N3SRgPEnJGEBT>NhWA,0*54
!AIVDM,2,2,7,A,wwo862PaLELTBJ:V00000000S0D:R220,0*79
!AIVDM,2,2,8,A,wwo862PaLELTBJ:V00000000S0D:R220,0*76
!AIVDM,2,1,1,A,55?MbV02;H;s<HtKR20EHE:0@T4@Dn2222222216L961O5Gf0NSQEp6ClRp8,0*1C
!AIVDM,2,2,1,A,88888888880,2*25
!AIVDM,1,1,,A,16:=?;0P00`SstvFnFbeGH6L088h,0*44
"""
SBS = (
    b"MSG,3,1,1,4CA2D6,1,2008/11/28,14:53:50.594,2008/11/28,14:58:51.153,,37000,,,51.45735,"
    b"-1.02826,,,0,0,0,0\r\n"
    b"MSG,8,1,1,4CA2D6,1,2008/11/28,14:53:51.153,2008/11/28,14:53:51.153,,,,,,,,,,,,0\r\n"
    b"MSG,3,1,1,not one,1,2008/11/28,14:53:51.5,2008/11/28,14:58:51.5,,37000,,,51.4,-1.0,,,0,0\n"
    b"MSG,2,1,1,400F01,1,,,2008-11-28,14:58:52,BAW12,,20,90,51.4700,-0.4543,,,0,0,0,-1\n"
)
AIRCRAFT = json.dumps(
    {
        "now": 1600000000.5,
        "messages": 12,
        "aircraft": [
            {"hex": "3c4591", "flight": "BOX413  ", "alt_baro": 35000, "gs": 495.0,
             "track": 99.6, "lat": 51.468, "lon": -0.44, "seen_pos": 0.5},
            {"hex": "407a19", "alt_baro": "ground", "lat": 53.457, "lon": -4.053, "seen_pos": 2},
            {"hex": "4ca2d6", "flight": "a \"quoted\" {one"},
            {"lat": 1.0, "lon": 2.0},
        ],
    },
    indent=1,
).encode()  # fmt: skip
ONE_A_LINE = b"""\
{"now":1600000000.5,"hex":"3c4591","alt_baro":35000,"gs":495.0,"track":99.6,"lat":51.4,"lon":-0.4}
{"now":1600000001.5,"hex":"407a19","flight":"GMDSI   ","lat":53.457,"lon":-4.053,"seen_pos":0.5}
{"now":1600000001.5,"hex":"407a20","flight":"BAW12"}
{"now":1600000001.5,"lat":53.457,"lon":-4.053}
{"now":1600000002.5,"hex":"3c4591","alt_baro":"ground","lat":51.41,"lon":-0.4,"type":"mlat"}
"""
TRACE = json.dumps(
    {
        "icao": "3c4591",
        "timestamp": 1600000000.0,
        "trace": [
            [0.0, 51.468, -0.44, 35000, 495.0, 99.6],
            [4.5, 51.468, -0.42, "ground", None, None],
            [9.0, None, -0.40, 35000, 495.0, 99.6],
        ],
    }
).encode()  # fmt: skip
STATES = json.dumps(
    {
        "time": 1626098400,
        "states": [
            ["3c4591", "BOX413  ", "Germany", 1626098398, 1626098400, -0.4407, 51.4689, 10668.0,
             False, 254.6, 99.6, 0.0, None, 10843.2, "1174", False, 0],
            ["407a19", "GMDSI   ", "UK", None, 1626098400, None, None, None,
             True, 0.0, 0.0, None, None, None, None, False, 0],
            ["407a20", "", "UK", None, 1626098400, -400.0, 91.0, None,
             True, 0.0, 0.0, None, None, None, None, False, 0],
        ],
    }
).encode()  # fmt: skip
BARE_STATES = json.dumps(json.loads(STATES)["states"]).encode()
STATE_TABLE = b"""\
time,icao24,lat,lon,velocity,heading,vertrate,callsign,on,lastposupdate,lastcontact
1626098400,3c4591,51.46894,-0.44075,254.6,99.6,0.0,BOX413  ,False,1626098398.996,1626098400.0
1626098410,407a19,53.45765,-4.05322,142.8,83.7,-3.2,GMDSI   ,False,1626098409.76,1626098409.9
1626098410,407a20,,,142.8,83.7,-3.2,GMDSI   ,False,,1626098409.9
1626098410,407a21,95.0,-4.05322,142.8,83.7,-3.2,GMDSI   ,False,1626098409.76,1626098409.9
"""
MOT = b"""1,-1,100.5,200,20,40,0.9,-1,-1,-1
1,-1,300,200,20,40,0.4,-1,-1,-1
2,-1,102,oops,20,40,0.8,-1,-1,-1
2,-1,102,201,20,40,0.8,-1,-1,-1
"""
KITTI_FOUND = b"""0,2,298.3,165.1,458.2,293.4,8.2,1.9,1.8,4.7,-4.5,1.8,13.5,-2.1,-1.7
1,1,1095.2,161.6,1212.8,321.0,4.9,1.7,0.7,0.9,6.3,1.6,8.4,-1.4,-2.0
1,2,nan,161.6,1212.8,321.0,4.9,1.7,0.7,0.9,6.3,1.6,inf,-1.4,-2.0
"""
KITTI_LABELS = b"""0 -1 DontCare -1 -1 -10 219.3 188.4 245.5 218.5 -1000 -1000 -1000 -10 -1 -1 -1
0 0 Van 0 0 -1.79 296.7 161.7 455.2 292.3 2.0 1.8 4.4 -4.55 1.85 13.41 -2.11
1 1 Car 0 0 -1.79 296.7 161.7 455.2 292.3 2.0 1.8 4.4 -4.5 1.8 nothing -2.1
1 2 Cyclist 0 0 -1.79 737.6 161.5 931.1 374.0 1.7 0.8 1.7 0.96 1.8 7.8 1.8
"""
SPOTS = b"""<?xml version="1.0" encoding="UTF-8"?>
<TrackMate version="7.11.1"><Model spatialunits="pixel" timeunits="sec"><AllSpots nspots="4">
<SpotsInFrame frame="0"><Spot ID="1" QUALITY="5" POSITION_X="1.5" POSITION_Y="2.5" POSITION_Z="0"
 POSITION_T="0" FRAME="0" RADIUS="2.5"/><Spot ID="9" POSITION_X="no" POSITION_Y="2.5" FRAME="0"/>
</SpotsInFrame><SpotsInFrame frame="1"><Spot ID="2" QUALITY="5" POSITION_X="2.5" POSITION_Y="2.5"
 POSITION_Z="0" POSITION_T="0.5" FRAME="1"/><Spot ID="3" POSITION_X="9" POSITION_Y="9"
 POSITION_Z="0" FRAME="1"/></SpotsInFrame></AllSpots><AllTracks><Track TRACK_ID="7">
<Edge SPOT_SOURCE_ID="1" SPOT_TARGET_ID="2"/></Track></AllTracks></Model></TrackMate>
"""
COCO = json.dumps(
    {
        "images": [{"id": 12, "frame_id": 1}, {"id": 11, "frame_id": 0}],
        "categories": [{"id": 1, "name": "person"}],
        "annotations": [
            {"id": 1, "image_id": 11, "category_id": 1, "bbox": [10, 20, 4, 8], "track_id": 5},
            {"id": 2, "image_id": 12, "category_id": 1, "bbox": [12, 20, 4, 8], "score": 0.5},
            {"id": 3, "image_id": 13, "category_id": 1, "bbox": [12, 20, 4, 8]},
            {"id": 4, "image_id": 12, "bbox": [12, 20, None, 8]},
        ],
    }
).encode()
LINES = b"""{"time": 0.0, "x": 1, "y": 2.5, "sensor": "a", "report": 1}
{"time": 1.0, "x": 2, "y": 2.5, "sensor": "a", "more": [1, {"b": "}"}]}
{"time": 1.0, "x": "two", "y": 2.5}
not JSON
{"time": 2.0, "x": 3, "y": 2.5, "sensor": 7}
[1, 2]
"""
ROWS = b"""\xef\xbb\xbftime,sensor,X,y,note
2024-05-01T12:00:00Z,a,1.5,2,
2024-05-01T12:00:01.25Z,"b, c",2.5,2,more
2024-05-01T12:00:02Z,a,two,2,
2024-05-01T12:00:03Z,a,3
,a,4,2,

time,sensor,X,y,note
5.5,a,5,2,no longer seconds
2024-05-01T12:00:06Z,x,6,2,
t\tx\ty\tidentity
2024-05-01T12:00:07Z\t54.5\t10.25\t007
"""
# A radar's place, two plots, a record that announces more than there is, another plot.
BLOCKS = bytes.fromhex(
    "220015 e910 19c9 01 545e80 0279 030c200000f00000"
    "300019 f0 19c9 545e80 a0 32804000 f0 19c9 545f00 a0 34804000"
    "300007 ff00 19c9"
    "30000e f0 19c9 545f80 a0 33804000"
)
CAPTURE = bytes.fromhex(
    "d4c3b2a1 0200 0400 00000000 00000000 ffff0000 65000000"
    "00d03166 00000000 2a000000 2a000000"
    "4500002a0000000040110000 0000000000000000 0fa00fa100160000"
    "30000e f0 19c9 545f80 a0 33804000"
    "01d03166 00000000 22000000 22000000"
    "450000220000200040110000 0000000000000000 0fa00fa1000e0000 300006 f00000"
)

SAMPLES: dict[str, tuple[str, bytes, int, int]] = {
    "blocks": ("asterix", BLOCKS, 3, 1),
    "capture": ("asterix", CAPTURE, 1, 1),
    "nmea": ("ais", NMEA, 4, 1),
    "nmea parts": ("ais", NMEA_PARTS, 2, 1),
    "sbs": ("sbs", SBS, 2, 1),
    "aircraft": ("readsb", AIRCRAFT, 2, 1),
    "aircraft lines": ("readsb", ONE_A_LINE, 3, 1),
    "trace": ("readsb", TRACE, 2, 1),
    "states": ("opensky", STATES, 1, 1),
    "bare states": ("opensky", BARE_STATES, 1, 1),
    "state table": ("opensky", STATE_TABLE, 2, 1),
    "mot": ("mot", MOT, 3, 1),
    "trackmate": ("trackmate", SPOTS, 3, 1),
    "coco": ("coco", COCO, 2, 2),
    "json lines": ("jsonl", LINES, 3, 3),
    "csv lines": ("csv", ROWS, 5, 3),
    "kitti detections": ("kitti", KITTI_FOUND, 2, 1),
    "kitti labels": ("kitti", KITTI_LABELS, 2, 1),
}
"""What a sample is called: its format, its bytes, its reports, its records that are no such."""
