"""Files of any format, found by their content, and several as one network."""

import gzip
import io
import json
from importlib.metadata import EntryPoint
from pathlib import Path
from types import SimpleNamespace

import polars as pl
import pytest

import trackweave as tw
from formats.samples import AIRCRAFT, COCO, KITTI_FOUND, MOT, NMEA, SBS, SPOTS, STATES
from trackweave.domain.facts import Place
from trackweave.errors import DataFormatError, InvalidInputError
from trackweave.formats import registry
from trackweave.formats.csv_stream import CsvDecoder
from trackweave.formats.format import Facts, Format, Skips
from trackweave.formats.opensky import OpenskyDecoder
from trackweave.formats.reading import load, read_reports


def written(path: Path, data: bytes) -> Path:
    path.write_bytes(data)
    return path


def test_a_file_is_known_by_its_content_whatever_it_is_called(tmp_path):
    assert len(load(written(tmp_path / "some.data", MOT))) == 3
    assert len(load(written(tmp_path / "det.csv", KITTI_FOUND))) == 2
    assert len(load(written(tmp_path / "packed.gz", gzip.compress(MOT)))) == 3


def test_a_table_stays_a_table_under_any_name(tmp_path):
    path = written(tmp_path / "reports.txt", b"time,x,y\n0,1,2\n1,2,3\n")
    assert tw.read_reports(path).measurement.tolist() == [[1.0, 2.0], [2.0, 3.0]]


def test_what_is_of_no_format_is_told(tmp_path):
    path = written(tmp_path / "picture.png", b"\x89PNG\r\n\x1a\n" + bytes(50))
    with pytest.raises(DataFormatError, match=r"picture.png: of no format that is known .*--from"):
        load(path)


def test_skipped_records_are_told_and_kept(tmp_path):
    reports = tw.read_reports(written(tmp_path / "det.txt", MOT))
    assert reports.undecoded.count == 1
    assert reports.undecoded.listed[0].offset == MOT.index(b"2,-1,102,oops")
    assert any("1 records could not be decoded" in note for note in reports.notes)


def test_a_reader_is_told_what_the_file_does_not_say(tmp_path):
    path = written(tmp_path / "det.txt", MOT)
    told = load(path, "mot?frame_rate=10&point=foot").columns
    assert told["time"].to_list() == [0.0, 0.0, 0.1]
    assert told["y"][0] == 240.0


@pytest.mark.parametrize(
    ("name", "data", "rate"), [("mot", MOT, 25), ("kitti", KITTI_FOUND, 10), ("coco", COCO, 25)]
)
def test_a_rate_is_noted_where_it_is_assumed_and_not_where_it_is_told(tmp_path, name, data, rate):
    path = written(tmp_path / "boxes.txt", data)
    assumed, told = load(path, name), load(path, f"{name}?frame_rate={rate}")
    assert assumed.columns.equals(told.columns)
    notes = [" ".join(each.facts.notes) for each in (assumed, told)]
    assert f"{rate} " in notes[0]
    assert f"(--from {name}?frame_rate=… tells otherwise)" in notes[0]
    assert " a second" not in notes[1]


@pytest.mark.parametrize(
    ("told", "expected"),
    [
        ("mot?rate=10", "'rate'; expected frame_rate, point"),
        ("mot?frame_rate=-1", "frame_rate '-1'; expected a number > 0"),
        ("mot?point=head", "point 'head'; expected centre, foot"),
        ("nothing", "'nothing': expected one that can be read"),
        ("ais?x=1", "'x'; expected no option"),
    ],
)
def test_what_a_reader_cannot_be_told_is_refused(tmp_path, told, expected):
    with pytest.raises(InvalidInputError) as refused:
        load(written(tmp_path / "det.txt", MOT), told)
    assert expected in str(refused.value)


def test_reports_without_a_time_are_left_out_and_counted(tmp_path):
    table = load(written(tmp_path / "ships", NMEA))
    assert len(table) == 3
    assert "1 reports say no time and were left out" in table.notes


def test_a_file_without_reports_is_refused(tmp_path):
    with pytest.raises(DataFormatError, match="no reports in it"):
        load(written(tmp_path / "x", b'{"now": 1.0, "aircraft": []}'))


def test_why_a_file_has_no_reports_is_told_in_full(tmp_path):
    sentence = NMEA.splitlines()[0].rpartition(b"\\")[2]
    path = written(tmp_path / "a.nmea", sentence + b"\n!AIVDM,1,1,,A,oops,0*00\n")
    with pytest.raises(DataFormatError, match=r"1 reports say no time.*; 1 records skipped"):
        load(path)
    path = written(tmp_path / "cat034.raw", bytes.fromhex("22000bf0191100000000"[:22] + "00"))
    with pytest.raises(DataFormatError) as caught:
        load(path, "asterix")
    assert "empty" not in str(caught.value)


def test_an_input_without_a_byte_is_empty(monkeypatch):
    monkeypatch.setattr("sys.stdin", SimpleNamespace(buffer=io.BytesIO()))
    with pytest.raises(DataFormatError, match="standard input: empty"):
        load("-")


def test_times_of_spots_may_count_from_1970(tmp_path):
    path = written(tmp_path / "a.xml", SPOTS.replace(b'POSITION_T="', b'POSITION_T="170000000'))
    assert load(path).columns["time"].to_list()[:2] == [1.7e9, 1.7e9 + 0.5]


def test_several_files_are_one_network_of_sensors(tmp_path):
    north = written(tmp_path / "north.csv", b"time,x,y\n0,1,2\n1,2,3\n")
    south = tmp_path / "south.parquet"
    pl.DataFrame({"time": [0.5], "x": [5.0], "y": [6.0], "report": ["a"]}).write_parquet(south)
    reports = tw.read_reports([north, south])
    assert reports.sensors == ("north", "south")
    assert reports.report.tolist() == ["north:1", "south:a", "north:2"]


def test_files_of_a_plane_and_of_the_earth_are_not_one_network(tmp_path):
    plane = written(tmp_path / "a.csv", b"time,x,y\n0,1,2\n")
    earth = written(tmp_path / "b.csv", b"time,latitude,longitude\n0,50,10\n")
    with pytest.raises(DataFormatError, match=r"a.csv tells x, y and .*b.csv lat, lon; expected"):
        tw.read_reports([plane, earth])


def test_files_of_one_name_are_told_apart_by_their_folders(tmp_path):
    paths = []
    for folder in "ab":
        (tmp_path / folder).mkdir()
        paths.append(written(tmp_path / folder / "r.csv", b"time,x,y\n0,1,2\n"))
    assert tw.read_reports(paths).sensors == tuple(map(str, paths))
    with pytest.raises(InvalidInputError, match="given twice"):
        load([paths[0], paths[0]])


def test_a_bad_row_of_one_of_several_files_is_named_with_its_file(tmp_path):
    good = written(tmp_path / "good.csv", b"time,x,y\n0,1,2\n")
    bad = written(tmp_path / "bad.csv", b"time,x,y\n0,1,2\n1,zwei,2\n")
    with pytest.raises(DataFormatError, match=r"bad.csv, row 2, column x: zwei"):
        tw.read_reports([good, bad])


def test_every_bad_row_of_several_files_has_the_number_that_it_has_there(tmp_path):
    good = written(tmp_path / "good.csv", b"Time,x,y\n0,1,2\n0,1\n")
    bad = written(tmp_path / "bad.csv", b"time,x,y\n0,1,2\n1,zwei,2\n2,1,1,1\n3,4,5\n4,4,drei\n")
    with pytest.raises(DataFormatError) as caught:
        tw.read_reports([good, bad])
    named = f"{good} 2, {bad} 2, {bad} 3, {bad} 5"
    assert (
        f"{good}, row 2: 2 cells; expected 3 as in the header; 4 rows are bad in all ({named})"
        in (str(caught.value))
    )
    reports = tw.read_reports([good, bad], on_bad_row="skip")
    assert len(reports) == 3
    assert sorted(reports.report.tolist()) == ["bad:1", "bad:4", "good:1"]
    assert [(each.file, each.row) for each in reports.skipped] == [
        (str(good), 2), (str(bad), 2), (str(bad), 3), (str(bad), 5),
    ]  # fmt: skip
    assert "good: column Time: taken for time, for there is no column time" in reports.notes
    run = tw.track([good, bad], on_bad_row="skip").run
    assert [(each["file"], each["row"]) for each in run["skipped_rows"]][-1] == (str(bad), 5)


def test_standard_input_is_read_like_a_file(monkeypatch):
    monkeypatch.setattr("sys.stdin", SimpleNamespace(buffer=io.BytesIO(SBS)))
    assert len(load("-")) == 2


def test_a_document_that_is_none_is_named(tmp_path):
    path = written(tmp_path / "spots.xml", SPOTS[:300])
    with pytest.raises(DataFormatError, match=r"spots\.xml: no XML of TrackMate"):
        load(path)


class Radar:
    """A reader of somebody else: a line is a range and an azimuth."""

    def __init__(self) -> None:
        self.skips = Skips()
        self.facts = Facts(places={"r": Place(50.0, 10.0)}, scan_periods={"r": 4.0})

    def feed(self, data: bytes) -> pl.DataFrame | None:
        rows = [line.split() for line in data.decode().splitlines()[1:]]
        time, far, azimuth = ([float(row[k]) for row in rows] for k in range(3))
        columns = {"time": time, "range_m": far, "azimuth_deg": azimuth}
        return pl.DataFrame(columns).with_columns(sensor=pl.lit("r"))

    def finish(self) -> None:
        return None


RADAR = Format(
    "radar", "Somebody's radar", (".radar",), "all", "nothing",
    recognise=lambda head, name: head.startswith(b"RADAR"), decoder=Radar,
)  # fmt: skip
NO_FORMAT = "no format at all"


@pytest.fixture
def plugged(monkeypatch):
    """Make the registry look as if a package with readers were installed."""

    def entries(group: str) -> list[EntryPoint]:
        if group != "trackweave.readers":
            return []
        return [
            EntryPoint("radar", f"{__name__}:RADAR", group),
            EntryPoint("none", f"{__name__}:NO_FORMAT", group),
            EntryPoint("gone", "no_such_package:FORMAT", group),
        ]

    monkeypatch.setattr(registry, "entry_points", entries)
    registry.formats.cache_clear()
    with pytest.warns(UserWarning, match="not used"):
        registry.formats()
    yield
    registry.formats.cache_clear()


@pytest.mark.usefixtures("plugged")
def test_a_reader_of_another_package_is_found_and_its_facts_count_as_told(tmp_path):
    lines = [f"{t} {20000.0 - 100 * t} 45.0" for t in range(0, 60, 4)]
    path = written(tmp_path / "x", "\n".join(["RADAR", *lines]).encode())
    reports = tw.read_reports(path)
    assert reports.frame is not None
    assert (reports.frame.latitude_deg, reports.frame.longitude_deg) == (50.0, 10.0)
    result = tw.track(path)
    sensor = result.run["configuration"]["sensors"]["r"]
    assert sensor["position"][:2] == [0.0, 0.0]
    assert sensor["scan_period"] == 4.0
    assert {"lat", "lon"} <= set(result.tracks.columns)
    assert any("the recording tells where it stands" in note for note in result.run["notes"])


@pytest.mark.usefixtures("plugged")
def test_a_reader_of_another_package_that_fails_is_named(tmp_path):
    path = written(tmp_path / "x", b"RADAR\n1.0 oops 3.0\n")
    with pytest.raises(DataFormatError, match="format radar, a plug-in, failed"):
        load(path)


def test_a_run_lists_what_could_not_be_decoded(tmp_path):
    path = written(tmp_path / "aircraft.json", AIRCRAFT * 3)
    result = tw.track(path)
    assert result.run["totals"]["undecoded_records"] == 3
    assert len(result.run["undecoded_records"]) == 3
    assert json.dumps(result.run["undecoded_records"][0])
    assert result.run["input"]["file"] == str(path)


def test_states_without_their_answer_have_the_time_of_their_last_message():
    decoder = OpenskyDecoder()
    state = '["3c4591", null, "Germany", 1626098398, 1626098400, -0.44, 51.46, null]\n'
    found = decoder.feed((2 * state).encode())
    assert found["time"].dt.epoch("s").to_list() == [1626098400] * 2
    assert OpenskyDecoder("position").feed(state.encode())["time"].dt.epoch("s")[0] == 1626098398


def test_what_follows_a_damaged_beginning_of_states_is_read():
    decoder = OpenskyDecoder()
    assert decoder.feed(b'x"time": 5, "states": [') is None
    found = decoder.feed(b"]}\n" + STATES)
    assert found["identity"].to_list() == ["3c4591"]
    assert decoder.skips.listed[0].offset == 0


def test_a_carriage_return_amid_quoted_csv_is_skipped_and_what_follows_is_read():
    decoder = CsvDecoder()
    found = decoder.feed(b'time,sensor,x\n1,"a"\rb,2\n3,"c",4\n')
    assert found["time"].to_list() == [3.0]
    assert [(each.offset, each.what) for each in decoder.skips.listed] == [
        (14, "no line of comma-separated values")
    ]


def test_a_file_of_what_is_only_written_is_called_so(tmp_path):
    (tmp_path / "tracks.kml").write_text("<kml/>")
    with pytest.raises(DataFormatError, match=r"KML .*, which is written and not read; expected"):
        load(tmp_path / "tracks.kml")


def test_a_user_tells_what_columns_of_a_table_are_called(tmp_path):
    path = tmp_path / "survey.csv"
    path.write_text("moment,ost,nord,x\n0,1,2,9\n1,3,4,9\n")
    with pytest.raises(DataFormatError, match=r"column time: missing; .*--from 'csv[?]time=NAME'"):
        read_reports(path)
    with pytest.raises(DataFormatError, match="columns x and ost: both would be x"):
        read_reports(path, told="csv?time=moment&x=ost&y=nord")
    path.write_text("moment,ost,nord,x\n0,1,2,9\n1,3,4,9\n".replace(",x", ",code"))
    found = read_reports(path, told="csv?time=moment&x=ost&y=nord")
    assert found.measurement.tolist() == [[1.0, 2.0], [3.0, 4.0]]
    assert "column ost: taken for x, for there is no column x" in found.notes
    with pytest.raises(
        DataFormatError, match=r"survey\.csv, column east: missing; expected it as x"
    ):
        read_reports(path, told="csv?x=east")
    with pytest.raises(InvalidInputError, match=r"'ecks'; expected a column of ours"):
        read_reports(path, told="csv?ecks=ost")
