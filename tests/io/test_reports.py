"""Tables of reports."""

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest

from trackweave.domain.frames import LocalFrame
from trackweave.domain.reports import BadRow
from trackweave.errors import DataFormatError, InvalidInputError
from trackweave.formats.reading import read_reports
from trackweave.io.frames_out import reports_frame
from trackweave.io.truth import read_truth


@pytest.fixture
def write(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def write(text: str) -> str:
        (tmp_path / "reports.csv").write_text(text)
        return "reports.csv"

    return write


def test_reads_the_least_that_a_table_must_have(write):
    reports = read_reports(write("time,x,y\n0,1,2\n"))
    assert reports.time.tolist() == [0.0]
    assert reports.measurement.tolist() == [[1.0, 2.0]]
    assert reports.sensors == ("default",)
    assert np.isnan(reports.sigma).all()
    assert reports.report.tolist() == ["1"]
    assert (reports.scan, reports.frame, reports.iso_time) == (None, None, False)


def test_reads_all_that_a_table_may_have(write):
    reports = read_reports(
        write(
            "report,time,sensor,x,y,z,sigma_x,sigma_y,sigma_z,scan,target,identity,note\n"
            "a,2024-05-01T00:00:00Z,north,1,2,3,.1,.2,.3,7,t1,4CA2,hello\n"
            "b,2024-05-01T00:00:01Z,north,1,2,3,,,.3,8,,,\n"
        )
    )
    assert reports.report.tolist() == ["a", "b"]
    assert reports.iso_time
    assert reports.dim == 3
    np.testing.assert_array_equal(reports.sigma, [[0.1, 0.2, 0.3], [np.nan, np.nan, 0.3]])
    assert reports.scan.tolist() == [7, 8]
    assert reports.carried["target"].tolist() == ["t1", ""]
    assert reports.carried["identity"].to_list() == ["4CA2", None]
    assert list(reports.carried) == ["target", "identity", "note"]


def test_sorts_by_time_then_sensor_then_row(write):
    reports = read_reports(
        write("time,sensor,x,y\n1,2,0,0\n0,10,1,0\n0,2,2,0\n0,10,3,0\n1,1,4,0\n")
    )
    assert reports.sensors == ("1", "2", "10")
    assert reports.measurement[:, 0].tolist() == [2, 1, 3, 4, 0]
    assert reports.report.tolist() == ["3", "2", "4", "5", "1"]


def test_row_order_does_not_matter(write):
    rows = [f"{k // 3},{k % 3},{k},{k},r{k}" for k in range(12)]
    header = "time,sensor,x,y,report\n"
    forwards = read_reports(write(header + "\n".join(rows)))
    backwards = read_reports(write(header + "\n".join(rows[::-1])))
    assert forwards.report.tolist() == backwards.report.tolist()
    np.testing.assert_array_equal(forwards.measurement, backwards.measurement)


def test_equal_rows_are_two_reports(write):
    assert len(read_reports(write("time,x,y\n0,1,2\n0,1,2\n"))) == 2


def test_a_gap_of_years_is_no_fault(write):
    assert len(read_reports(write("time,x,y\n0,1,2\n1e9,1,2\n"))) == 2


def test_sigma_goes_with_latitudes_too(write):
    reports = read_reports(write("time,lat,lon,sigma_x,sigma_y\n0,47,8,10,20\n"))
    assert reports.sigma.tolist() == [[10.0, 20.0]]
    assert reports.frame == LocalFrame(47.0, 8.0)


def test_an_origin_that_is_given_is_taken(write):
    reports = read_reports(write("time,lat,lon\n0,47,8\n"), frame_origin=(46.0, 8))
    assert reports.frame == LocalFrame(46.0, 8.0)
    assert reports.measurement[0, 1] == pytest.approx(111_100, rel=1e-3)


def test_altitudes_that_are_not_everywhere_are_carried(write):
    reports = read_reports(write("time,lat,lon,alt_m\n0,47,8,900\n1,47,8,\n"))
    assert reports.dim == 2
    assert reports.carried["alt_m"].to_list() == ["900", None]


@pytest.mark.parametrize(
    ("library", "kind"),
    [(pl.DataFrame, "polars"), (pd.DataFrame, "pandas"), (pa.table, "pyarrow")],
)
def test_takes_tables_of_other_libraries(library, kind):
    data = {"time": [1.0, 0.0], "sensor": [2, 1], "x": [1, 2], "y": [3.5, 4.5]}
    reports = read_reports(library({**data, "target": [7.0, None]}))
    assert reports.sensors == ("1", "2")
    assert reports.measurement.tolist() == [[2.0, 4.5], [1.0, 3.5]]
    assert reports.carried["target"].tolist() == ["", "7"]
    assert reports.kind == kind


def test_empty_noise_of_pandas_is_left_to_the_sensor():
    table = pd.DataFrame({"time": [0.0, 1.0], "x": 1.0, "y": 2.0})
    table["sigma_x"] = table["sigma_y"] = [3.0, np.nan]
    np.testing.assert_array_equal(read_reports(table).sigma[:, 0], [3.0, np.nan])


def test_parquet_and_csv_give_the_same_reports(tmp_path):
    table = pl.DataFrame({"time": [0.1, 1 / 3], "sensor": ["b", "a"], "x": [1e-7, 2.0], "y": 1.5})
    table.write_csv(tmp_path / "r.csv")
    table.write_parquet(tmp_path / "r.parquet")
    one, other = read_reports(tmp_path / "r.csv"), read_reports(tmp_path / "r.parquet")
    for name in ("time", "sensor", "measurement", "report"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert one.sensors == other.sensors


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", ": no header, the file is empty; expected columns' names"),
        ("time,x,y\n", ": no data rows; expected at least one"),
        ("x,y\n1,2\n", ", column time: missing; expected seconds or ISO 8601 times; --from"),
        ("time,x,y\nnan,1,2\n", ", row 1, column time: nan; expected a finite number of seconds"),
        ("time,x,y\n0,1,2\n,1,2\n", ", row 2, column time: (empty); expected a finite number"),
        ("time,x,y\n1e12,1,2\n0,1,2\n", ", row 1, column time: 1e12; expected a number from"),
        ("time,x,y\nsoon,1,2\n", ", row 1, column time: soon; expected seconds or an ISO 8601"),
        (
            "time,x,y\n2024-05-01,1,2\n5,1,2\n",
            ", row 2, column time: 5; expected an ISO 8601 time",
        ),
        ("time,sensor,x,y\n0,,1,2\n", ", row 1, column sensor: (empty); expected the name or"),
        ("time,x,y\n0,inf,2\n", ", row 1, column x: inf; expected a number from -1e+09 to 1e+09"),
        ("time,x,y\n0,1,two\n", ", row 1, column y: two; expected a finite number"),
        (
            "time,x,y,sigma_x,sigma_y\n" + "0,1,2,3,3\n" * 16 + "0,1,2,-3.0,3\n",
            ", row 17, column sigma_x: -3.0; expected a positive number",
        ),
        (
            "time,x,y,sigma_x,sigma_y\n0,1,2,3,0\n",
            ", row 1, column sigma_y: 0; expected a positive number",
        ),
        (
            "time,x,y,sigma_x,sigma_y\n0,1,2,3,nan\n",
            ", row 1, column sigma_y: nan; expected a positive num",
        ),
        (
            "time,x,y,sigma_x,sigma_y\n0,1,2,3,inf\n",
            ", row 1, column sigma_y: inf; expected a positive num",
        ),
        (
            "time,x,y,sigma_x,sigma_y\n0,1,2,3,1e-10\n",
            ", row 1, column sigma_y: 1e-10; expected a positive",
        ),
        ("time,x,y,sigma_x\n0,1,2,3\n", ", column sigma_x: there is no sigma_y; expected sigma_y"),
        ("time,x,y,sigma_y\n0,1,2,3\n", ", column sigma_y: there is no sigma_x; expected sigma_x"),
        (
            "time,x,y,sigma_x,sigma_y\n0,1,2,3,4\n0,1,2,3,\n",
            ", row 2, column sigma_y: (empty); expected a positive number beside sigma_x",
        ),
        ("time,x,y,scan\n0,1,2,1.5\n", ", row 1, column scan: 1.5; expected a whole number"),
        ("time,x,y,scan\n0,1,2,\n", ", row 1, column scan: (empty); expected a whole number"),
        (
            "time,x,y,report\n0,1,2,a\n0,1,2,b\n0,1,2,a\n",
            ", row 3, column report: a; expected an identifier that no row before has",
        ),
        ("time,x,y,report\n0,1,2,\n", ", row 1, column report: (empty); expected an identifier"),
    ],
)
def test_says_what_is_wrong_with_a_table(write, text, message):
    with pytest.raises(DataFormatError) as caught:
        read_reports(write(text))
    assert str(caught.value).startswith(f"reports.csv{message}")


def test_tells_of_the_first_bad_row_whatever_the_column(write):
    with pytest.raises(DataFormatError, match=r"row 2, column y: b; "):
        read_reports(write("time,x,y\n0,1,2\n0,1,b\n0,a,2\n"))


def test_leaves_bad_rows_out_and_lists_them_when_told_to(write):
    text = "time,x,y,sigma_x,sigma_y\n0,1,2,3,3\n0,1\n1,a,2,-1,1\n2,5,6,-3.0,1\n3,7,8,,\n"
    reports = read_reports(write(text), on_bad_row="skip")
    assert reports.time.tolist() == [0.0, 3.0]
    assert reports.report.tolist() == ["1", "5"]
    assert reports.skipped == (
        BadRow(2, None, "2 cells", "5 as in the header"),
        BadRow(3, "x", "a", "a finite number"),
        BadRow(4, "sigma_x", "-3.0", "a positive number"),
    )
    message = reports.skipped[2].message("reports.csv")
    assert message == "reports.csv, row 4, column sigma_x: -3.0; expected a positive number"


def test_an_identifier_of_a_bad_row_is_free(write):
    text = "time,x,y,report\n0,a,2,r1\n0,1,2,r1\n0,1,2,r1\n"
    reports = read_reports(write(text), on_bad_row="skip")
    assert reports.report.tolist() == ["r1"]
    assert [bad.row for bad in reports.skipped] == [1, 3]


def test_altitude_and_origin_follow_from_the_good_rows_alone(write):
    text = "time,lat,lon,alt_m\n0,47,8,500\nx,0,0,\n0,99,8,\n1,47,8,600\n2,1,1,100\n"
    reports = read_reports(write(text), on_bad_row="skip")
    assert reports.frame == LocalFrame(47.0, 8.0)
    assert reports.measurement[:, 2].tolist() == [500.0, 600.0]
    assert [bad.row for bad in reports.skipped] == [2, 3, 5]


@pytest.mark.parametrize("rows", ["0,a,2\n1,1,b\n", "0,1\n1,2,3,4\n"])
def test_refuses_a_table_of_which_no_row_is_usable(write, rows):
    with pytest.raises(DataFormatError, match=r"row 1.*none of the other rows is usable"):
        read_reports(write("time,x,y\n" + rows), on_bad_row="skip")


def test_refuses_what_is_no_table():
    with pytest.raises(InvalidInputError, match="int: not a table"):
        read_reports(3)


def test_reads_many_rows_to_the_last_digit(tmp_path):
    rng = np.random.default_rng(5)
    values = rng.normal(size=(100_000, 2)) * 10.0 ** rng.integers(-5, 8, (100_000, 1))
    columns = {"time": np.arange(len(values)) // 100, "x": values[:, 0], "y": values[:, 1]}
    pl.DataFrame(columns).write_csv(tmp_path / "r.csv")
    np.testing.assert_array_equal(read_reports(tmp_path / "r.csv").measurement, values)


@pytest.mark.shared
def test_reads_recorded_aircraft(shared):
    path = shared / "data" / "opensky" / "OpenSky_Plane_States.csv"
    if not path.exists():
        pytest.skip("the recording is not beside the checkout")
    reports = read_reports(path)
    assert len(reports) == 6052
    assert reports.frame is not None
    assert len(reports.identities) == 84


class TestBadRows:
    """What is said of rows that cannot be used."""

    def test_one_bad_row_names_the_way_on(self, write):
        with pytest.raises(DataFormatError) as caught:
            read_reports(write("time,x,y\n0,1,2\n1,1,no\n"))
        assert str(caught.value) == (
            "reports.csv, row 2, column y: no; expected a finite number; --on-bad-row skip "
            '(in Python on_bad_row="skip") leaves out what is bad'
        )

    def test_all_are_counted_and_the_first_named_whatever_is_wrong(self, write):
        rows = ["0,1,2", "0,1", "0,1,no", "0,no,2", "0,1,2,3", "zap,1,2", "0,,2", "1,1,1"]
        with pytest.raises(DataFormatError) as caught:
            read_reports(write("\n".join(["time,x,y", *rows])))
        assert str(caught.value).startswith("reports.csv, row 2: 2 cells; expected 3 as in the ")
        assert "; 6 rows are bad in all (2, 3, 4, 5, 6, …); --on-bad-row skip" in str(caught.value)

    def test_skipping_is_no_advice_where_it_leaves_nothing(self, write):
        with pytest.raises(DataFormatError, match=r"--on-bad-row skip .* would leave no row"):
            read_reports(write("time,x,y\n0,1,no\n0,no,2\n"))

    def test_who_has_no_choice_is_given_none(self, write):
        write("time,target,x,y\n0,a,1,2\n0,b,no,2\n1,a,no,1\n")
        with pytest.raises(DataFormatError) as caught:
            read_truth("reports.csv")
        assert str(caught.value).endswith("; 2 rows are bad in all (2, 3)")


class TestNotAvailable:
    """Codes for a position that a ship does not know."""

    @pytest.mark.parametrize("code", ["91,181", "91.0,8", "47,181.000"])
    def test_each_code_sets_a_row_aside(self, code, write):
        reports = read_reports(write(f"time,lat,lon\n0,47,8\n1,{code}\n2,47.001,8\n"))
        assert reports.report.tolist() == ["1", "3"]
        assert reports.skipped == ()
        assert reports.unavailable.report.tolist() == ["2"]
        assert np.isnan(reports.unavailable.measurement).all()
        (note,) = reports.notes
        assert note.startswith('lat, lon: 1 of 3 rows hold the codes for "not available"')

    @pytest.mark.parametrize("count", [1, 4])
    def test_places_without_a_fix_are_set_aside_where_all_else_is_elsewhere(self, count, write):
        reports = read_reports(
            write("time,lat,lon\n0,47,8\n" + "1,0,0\n" * count + "2,47.001,8\n")
        )
        assert reports.report.tolist() == ["1", str(count + 2)]
        assert len(reports.unavailable) == count
        (note,) = reports.notes
        assert "or 0, 0 far from all others" in note

    @pytest.mark.parametrize(
        "others", ["0.1,0.2\n2,-0.3,0.1", "\n1,".join(["0,0"] * 9) + "\n2,47,8"]
    )
    def test_places_at_the_origin_of_the_map_are_places(self, others, write):
        reports = read_reports(write(f"time,lat,lon\n0,0,0\n1,{others}\n"), on_bad_row="skip")
        assert "1" in reports.report.tolist()

    def test_they_change_nothing_of_the_others(self, write):
        good = "time,lat,lon,sensor\n0,47,8,b\n1,47.001,8,b\n"
        alone = read_reports(write(good))
        reports = read_reports(write(good + "0.5,91,181,a\n"))
        assert reports.sensors == alone.sensors == ("b",)
        assert reports.frame == alone.frame
        assert np.array_equal(reports.measurement, alone.measurement)
        assert alone.unavailable is None
        assert alone.notes == ()

    def test_where_longitudes_go_round_181_is_one(self, write):
        reports = read_reports(write("time,lat,lon\n0,-17,180.5\n1,-17,181\n2,91,181\n"))
        assert reports.report.tolist() == ["1", "2"]
        assert reports.unavailable.report.tolist() == ["3"]

    @pytest.mark.parametrize(
        "row", ["1,90.5,8", "1,47,", "1,91,", "1,,181", "1,95,181", "x,91,181"]
    )
    def test_other_rows_are_bad_as_before(self, row, write):
        with pytest.raises(DataFormatError, match="row 2"):
            read_reports(write(f"time,lat,lon\n0,47,8\n{row}\n2,47,8\n"))

    def test_a_table_of_nothing_else_is_refused(self, write):
        with pytest.raises(DataFormatError, match='all rows hold codes for "not available"'):
            read_reports(write("time,lat,lon\n0,91,181\n1,91,181\n"))

    def test_a_position_on_a_plane_knows_no_codes(self, write):
        reports = read_reports(write("time,x,y,lat,lon\n0,91,181,91,181\n"))
        assert reports.measurement.tolist() == [[91.0, 181.0]]

    def test_beside_a_radar_only_the_ships_row_is_set_aside(self, write):
        reports = read_reports(
            write(
                "time,sensor,lat,lon,range_m,azimuth_deg\n0,ais,47,8,,\n1,radar,,,500,10\n"
                "2,ais,91,181,,\n3,radar,,,520,10\n"
            )
        )
        assert reports.report.tolist() == ["1", "2", "4"]
        assert reports.unavailable.sensors == ("ais",)

    def test_they_are_written_as_they_came(self, write):
        reports = read_reports(write("time,lat,lon,name\n2,47,8,a\n1,91,181,b\n0,47.001,8,c\n"))
        written = reports_frame(reports)
        assert written["name"].to_list() == ["a", "b", "c"]
        again = read_reports(written)
        assert again.report.tolist() == reports.report.tolist()
        assert again.unavailable.report.tolist() == ["2"]


def test_says_that_times_of_the_day_have_no_day(tmp_path):
    path = tmp_path / "reports.csv"
    path.write_text("time,x,y\n23:59:59,1,2\n00:00:01,3,4\n")
    reports = read_reports(path)
    assert reports.time.tolist() == [86399.0, 86401.0]
    assert reports.notes == ("time: times of the day, read as seconds from midnight",)
