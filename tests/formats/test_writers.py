"""What goes out: valid by each format's own schema or reader, units and datum right, in UTC."""

import json
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave import track
from trackweave.domain.frames import LocalFrame
from trackweave.errors import InvalidInputError
from trackweave.formats.format import Output
from trackweave.formats.registry import format_named, formats
from trackweave.formats.writing import try_on, writers_named, written

KML = {"k": "http://www.opengis.net/kml/2.2", "gx": "http://www.google.com/kml/ext/2.2"}
BEGIN = datetime(2024, 5, 1, 12, tzinfo=UTC)
ON_EARTH = ("geojson", "kml", "czml", "cot", "readsb")


def states(*, altitude: bool = False, longitude: float = 10.0) -> Output:
    """Two confirmed tracks, the first to the east at 10 m/s, and a tentative one."""
    frame = LocalFrame(50.0, longitude)
    x = np.array([0.0, 10.0, 20.0, 0.0, 5.0])
    y = np.array([0.0, 0.0, 0.0, 300.0, 0.0])
    lat, lon, _ = frame.to_geodetic(np.stack([x, y], axis=-1))
    seconds = pl.Series([0, 1_000_000, 2_500_000, 0, 0]).cast(pl.Duration("us"))
    table = pl.DataFrame(
        {
            "time": pl.Series([BEGIN] * 5).cast(pl.Datetime("us", "UTC")) + seconds,
            "track": [1, 1, 1, 2, 3],
            "status": ["confirmed", "confirmed", "coasting", "confirmed", "tentative"],
            "x": x, "y": y, "lat": lat, "lon": lon,
            "vx": [10.0] * 5, "vy": [0.0] * 5,
            "p_x_x": [9.0] * 5, "p_x_y": [0.0] * 5, "p_y_y": [16.0] * 5,
            "score": [5.0] * 5, "hits": [3] * 5,
        }
    )  # fmt: skip
    if altitude:
        table = table.with_columns(alt_m=pl.lit(1000.0), p_z_z=pl.lit(25.0))
    return Output(table, frame=frame)


def text_of(name: str, output: Output) -> str:
    (content,) = format_named(name, writes=True).writer(output).values()
    return content.decode("utf-8")


def test_geojson_has_a_line_for_each_track_with_the_times_of_its_points():
    found = json.loads(text_of("geojson", states(altitude=True)))
    line, point = found["features"]
    assert line["geometry"]["type"] == "LineString"
    assert line["geometry"]["coordinates"][0] == pytest.approx([10.0, 50.0, 1000.0])
    assert line["properties"]["coordTimes"] == [
        "2024-05-01T12:00:00Z", "2024-05-01T12:00:01Z", "2024-05-01T12:00:02.500Z",
    ]  # fmt: skip
    assert line["properties"]["course_deg"] == pytest.approx([90.0] * 3, abs=0.01)
    assert line["properties"]["sigma_m"] == [4.0] * 3
    assert point["geometry"]["type"] == "Point"


def test_geojson_has_null_for_the_score_of_a_track_that_only_hindsight_knows():
    known = states()
    table = known.tracks.with_columns(score=pl.when(pl.col("track") == 2).then(float("nan")))
    line, point = json.loads(text_of("geojson", replace(known, tracks=table)))["features"]
    assert (line["properties"]["score"], point["properties"]["score"]) == (None, None)


def test_geojson_is_valid_by_its_own_library():
    library = pytest.importorskip("geojson")
    for output in (states(), states(altitude=True), states(longitude=180.0)):
        assert library.loads(text_of("geojson", output)).is_valid


def test_a_line_over_the_antimeridian_is_cut_there():
    table = pl.DataFrame(
        {"time": [0.0, 1.0, 2.0], "track": [1] * 3, "lat": [0.0, 1.0, 2.0],
         "lon": [179.0, -179.0, -178.0]}
    )  # fmt: skip
    (feature,) = json.loads(text_of("geojson", Output(table)))["features"]
    assert feature["geometry"]["coordinates"] == [
        [[179.0, 0.0], [180.0, 0.5]], [[-180.0, 0.5], [-179.0, 1.0], [-178.0, 2.0]],
    ]  # fmt: skip
    assert [len(times) for times in feature["properties"]["coordTimes"]] == [2, 3]


def test_kml_has_a_time_for_each_place():
    root = ET.fromstring(text_of("kml", states(altitude=True)))
    first = root.findall(".//gx:Track", KML)[0]
    whens = [when.text for when in first.findall("k:when", KML)]
    places = [place.text for place in first.findall("gx:coord", KML)]
    assert len(whens) == len(places) == 3
    assert whens[2] == "2024-05-01T12:00:02.500Z"
    assert places[0] == "10.00000000 50.00000000 1000.000"
    assert first.find("k:altitudeMode", KML).text == "absolute"


def test_kml_says_from_where_altitudes_count():
    root = ET.fromstring(text_of("kml", states(altitude=True)))
    (told,) = root.findall(".//k:Document/k:description", KML)
    assert "ellipsoid" in told.text
    assert "sea level" in told.text


def test_kml_is_valid_by_googles_schema():
    parser = pytest.importorskip("pykml.parser")
    schema = parser.Schema("kml22gx.xsd")
    for output in (states(), states(altitude=True)):
        assert schema.validate(parser.fromstring(text_of("kml", output).encode()))


def test_czml_counts_seconds_from_an_epoch_and_degrees_from_greenwich():
    document, first, second = json.loads(text_of("czml", states(altitude=True)))
    assert document["version"] == "1.0"
    assert document["clock"]["interval"] == "2024-05-01T12:00:00Z/2024-05-01T12:00:02.500Z"
    numbers = first["position"]["cartographicDegrees"]
    assert numbers[:4] == pytest.approx([0.0, 10.0, 50.0, 1000.0])
    assert numbers[8] == 2.5
    assert second["availability"] == "2024-05-01T12:00:00Z/2024-05-01T12:00:00Z"


def test_czml_is_read_by_its_own_library():
    core = pytest.importorskip("czml3.core")
    for packet in json.loads(text_of("czml", states()))[1:]:
        assert core.Packet.model_validate(packet).id == packet["id"]


def test_cot_has_an_event_for_each_state_in_order_of_time():
    lines = text_of("cot", states(altitude=True)).splitlines()
    events = [ET.fromstring(line) for line in lines]
    assert [event.get("uid") for event in events] == [
        "trackweave-1", "trackweave-2", "trackweave-1", "trackweave-1",
    ]  # fmt: skip
    point = events[0].find("point").attrib
    assert {name: float(value) for name, value in point.items()} == pytest.approx(
        {"lat": 50.0, "lon": 10.0, "hae": 1000.0, "ce": 4.0, "le": 5.0}
    )
    assert events[0].get("stale") == "2024-05-01T12:01:00Z"
    assert events[0].find("detail/track").get("course") == "90.00"
    unknown = ET.fromstring(text_of("cot", states()).splitlines()[0])
    assert unknown.find("point").get("hae") == "9999999.000"
    assert unknown.get("type") == "a-u-G"


@pytest.mark.parametrize("name", ["kml", "cot"])
def test_a_name_with_marks_of_xml_stays_a_name(name):
    table = states().tracks.with_columns(name=pl.lit('<a & "b">')).filter(pl.col("track") == 2)
    root = ET.fromstring(text_of(name, Output(table)))
    texts = [each.text for each in root.iter()] + [each.get("callsign") for each in root.iter()]
    assert '<a & "b">' in texts


@pytest.mark.parametrize("name", ON_EARTH)
def test_tracks_on_a_plane_are_refused_where_the_earth_is_needed(name):
    table = states().tracks.drop("lat", "lon")
    with pytest.raises(InvalidInputError, match="no latitudes and longitudes"):
        text_of(name, Output(table))


def test_no_tracks_make_an_empty_file_that_is_valid():
    nothing = Output(states().tracks.clear())
    assert json.loads(text_of("geojson", nothing))["features"] == []
    assert len(json.loads(text_of("czml", nothing))) == 1
    assert ET.fromstring(text_of("kml", nothing)).findall(".//gx:Track", KML) == []
    assert text_of("cot", nothing) == ""


def boxes() -> pl.DataFrame:
    """A box that moves to the right for ten frames."""
    frame = np.arange(1, 11)
    return pl.DataFrame(
        {
            "time": (frame - 1) / 10, "x": 10.0 * frame + 5, "y": [20.0] * 10, "frame": frame,
            "left": 10.0 * frame, "top": [10.0] * 10, "right": 10.0 * frame + 10,
            "bottom": [30.0] * 10, "width": [10.0] * 10, "height": [20.0] * 10,
            "strength": [0.9] * 10, "class": ["Car"] * 10,
        }
    )  # fmt: skip


CONFIG: Mapping[str, object] = {
    "motion": {"process_noise": 0.1, "max_speed": 200.0},
    "sensors": {"default": {
        "sigma": 1.0, "detection_probability": 0.95, "clutter_density": 1e-9, "scan_period": 0.1,
    }},
    "lifecycle": {"new_target_density": 1e-6},
}  # fmt: skip


def test_boxes_go_out_as_results_of_mot_and_kitti_and_come_back():
    output = track(boxes(), CONFIG).output()
    mot = text_of("mot", output).splitlines()
    assert mot[0] == "1,1,10.0,10.0,10.0,20.0,0.9,-1,-1,-1"
    assert len(mot) == 10
    kitti = text_of("kitti", output).splitlines()
    assert len(kitti) == 10
    assert kitti[0].split(" ")[:10] == [
        "1",
        "1",
        "Car",
        "-1",
        "-1",
        "-10",
        "10.0",
        "10.0",
        "20.0",
        "30.0",
    ]
    for name, text in (("mot", mot), ("kitti", kitti)):
        decoder = format_named(name).decoder()
        decoder.feed("\n".join(text).encode())
        back = decoder.finish()
        assert back is None or back["target"].unique().to_list() == [1]
        assert decoder.skips.count == 0


def test_reports_without_boxes_are_no_results_of_mot():
    output = track(boxes().select("time", "x", "y"), CONFIG).output()
    with pytest.raises(InvalidInputError, match="reports have no left, top, width, height"):
        text_of("mot", output)


def test_what_a_format_cannot_say_is_refused_before_anything_is_tracked():
    plane = tw.read_reports(boxes().drop("left"))
    for name, expected in (("kml", "no latitudes"), ("mot", "no left"), ("kitti", "no left")):
        with pytest.raises(InvalidInputError, match=expected):
            try_on(writers_named([name]), plane)
    assert (
        try_on(writers_named(["mot,kitti,trackmate,ctc,geff,csv,jsonl"]), tw.read_reports(boxes()))
        is None
    )
    earth = tw.read_reports(pl.DataFrame({"time": [0.0], "lat": [1.0], "lon": [2.0]}))
    assert try_on(writers_named(["kml,geojson,czml,cot"]), earth) is None


def test_further_formats_are_named_once_and_known():
    for several in (["geojson, kml"], ["geojson", "kml"]):
        assert [each.name for each in writers_named(several)] == ["geojson", "kml"]
    files = written(writers_named(["geojson,kml"]), states())
    assert set(files) == {"tracks.geojson", "tracks.kml"}
    with pytest.raises(InvalidInputError, match="twice"):
        writers_named(["kml,kml"])
    with pytest.raises(InvalidInputError, match="expected one that can be written"):
        writers_named(["ais"])


def test_every_writer_writes_under_the_name_of_tracks():
    for each in formats().values():
        assert all(not ending or ending.startswith(".") for ending in each.endings)
        assert Path(f"tracks{each.endings[0]}").name.startswith("tracks")


@pytest.mark.parametrize(
    ("identity", "kind"),
    [("211000001", "a-u-S"), ("002111234", "a-u-G"), ("111211001", "a-u-A"), ("4ca2d6", "a-u-G"),
     (None, "a-u-G")],
)  # fmt: skip
def test_cot_tells_ships_from_what_is_on_the_ground(identity, kind):
    output = states()
    reports = pl.DataFrame(
        {"track": output.tracks["track"], "identity": [identity] * len(output.tracks)},
        schema_overrides={"identity": pl.String},
    )
    ships = replace(output, assignments=reports)
    assert {ET.fromstring(line).get("type") for line in text_of("cot", ships).splitlines()} == {
        kind
    }


def test_cot_takes_for_aircraft_what_mostly_tells_a_height():
    output = states()
    count = len(output.tracks)
    for heights, kind in (([300.0, *[None] * (count - 1)], "a-u-G"), ([300.0] * count, "a-u-A")):
        told = {"track": output.tracks["track"], "height_m": heights}
        reports = pl.DataFrame(told, schema_overrides={"height_m": pl.Float64})
        text = text_of("cot", replace(output, assignments=reports))
        assert {ET.fromstring(line).get("type") for line in text.splitlines()} == {kind}


def test_cot_of_states_that_tell_it_themselves_needs_no_reports():
    output = states()
    ships = replace(output, tracks=output.tracks.with_columns(identity=pl.lit("211000001")))
    text = text_of("cot", replace(ships, history=None, assignments=None))
    assert {ET.fromstring(line).get("type") for line in text.splitlines()} == {"a-u-S"}


def test_boxes_by_their_corners_or_their_size_are_the_same_boxes():
    sized = boxes().drop("right", "bottom").with_columns(track=pl.lit(1))
    kitti = format_named("kitti", writes=True).writer(Output(sized))["tracks.kitti.txt"]
    corners = sized.with_columns(right=pl.col("left") + pl.col("width"))
    corners = corners.with_columns(bottom=pl.col("top") + pl.col("height"))
    mot = format_named("mot", writes=True).writer
    assert mot(Output(corners.drop("width", "height"))) == mot(Output(sized))
    cells = kitti.decode().splitlines()[0].split()
    left, top, right, bottom = map(float, cells[6:10])
    first = corners.sort("time", "track").row(0, named=True)
    assert (left, top) == (first["left"], first["top"])
    assert (right, bottom) == (first["right"], first["bottom"])
    assert cells[13:16] == ["-1000.0"] * 3  # where on the ground an image does not tell
    decoder = format_named("kitti").decoder()
    assert decoder.feed(kitti) is None
    assert decoder.facts.left_out == {"boxes without a place on the ground": 10}


@pytest.mark.parametrize(
    ("name", "wanted"), [("geojson", '"name":"227006760"'), ("kml", "<name>227006760</name>")]
)
def test_a_track_is_called_by_the_identity_of_most_of_its_reports(name, wanted):
    told = pl.DataFrame({"track": [1, 1, 1, 2], "identity": ["227006760", "227006760", "5", None]})
    output = replace(states(), assignments=told)
    assert wanted in text_of(name, output)
    assert wanted not in text_of(name, states())
