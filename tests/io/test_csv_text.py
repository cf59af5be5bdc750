"""The two parsers of CSV: what they refuse, and that they agree."""

import csv
import io

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from trackweave.errors import DataFormatError
from trackweave.io.csv_text import parse_csv, parse_csv_carefully


def refusal(data: bytes) -> str:
    with pytest.raises(DataFormatError) as caught:
        parse_csv(data, "r.csv")
    return str(caught.value)


def test_reads_cells_as_text_and_empty_ones_as_null():
    table = parse_csv(b"time,x\n1,\n2,a b\n", "r.csv")
    assert table.columns.rows() == [("1", None), ("2", "a b")]


def test_reads_quoted_cells_with_commas_line_breaks_and_quotation_marks():
    table = parse_csv(b'"a","b"\n"1,5","x\ny"\n"say ""hi""",\n', "r.csv")
    assert table.columns.rows() == [("1,5", "x\ny"), ('say "hi"', None)]


@pytest.mark.parametrize("line_end", [b"\n", b"\r\n", b"\r"])
def test_takes_every_kind_of_line_end(line_end):
    data = line_end.join([b"a,b", b"1,2", b"3,4", b""])
    assert parse_csv(data, "r.csv").columns.rows() == [("1", "2"), ("3", "4")]


def test_passes_over_blank_lines_and_does_not_count_them():
    table = parse_csv(b"\na,b\n\n1,2\n   \n3,4\n\n\n", "r.csv")
    assert table.columns.rows() == [("1", "2"), ("3", "4")]
    assert table.row.tolist() == [1, 2]


def test_takes_a_byte_order_mark_off():
    assert parse_csv(b"\xef\xbb\xbfa,b\n1,2\n", "r.csv").columns.columns == ["a", "b"]


def test_takes_blanks_off_names():
    assert parse_csv(b"a , b\n1,2\n", "r.csv").columns.columns == ["a", "b"]


def test_takes_one_column_without_a_name():
    assert parse_csv(b",a\n0,1\n", "r.csv").columns.columns == ["", "a"]


def test_keeps_more_rows_than_a_chunk_in_order():
    n = 70_000
    data = b'a,b\n"0",x\n' + b"".join(b"%d,x\n" % k for k in range(1, n))
    table = parse_csv(data, "r.csv")
    assert table.columns["a"].to_list() == [str(k) for k in range(n)]


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "r.csv: no header, the file is empty; expected columns' names"),
        (b"\n \n", "r.csv: no header, the file is empty; expected columns' names"),
        (b",,\n1,2,3\n", "r.csv: no names in the header; expected columns' names"),
        (b"a,b,a\n1,2,3\n", "r.csv, column a: twice in the header; expected each name once"),
        (b"a,b,a", "r.csv, column a: twice in the header; expected each name once"),
        (
            b"a,,\n1,2,3\n",
            "r.csv, column (without a name): twice in the header; expected each name once",
        ),
        (
            b"time|x|y\n1|2|3\n",
            "r.csv, header: one column 'time|x|y'; expected columns separated by commas",
        ),
        (
            b"time;x;y\n1;2;1.234,5\n",
            "r.csv, header: one column 'time;x;y'; expected columns separated by commas",
        ),
        (
            b'a,b\n1,2\n3,"4\n5,6\n',
            "r.csv, row 2: a quotation mark that is never closed; expected a closing one",
        ),
        (
            b'a,b\n1,"2"3\n',
            "r.csv, row 1: text after a closing quotation mark; expected a comma there, and "
            'quotation marks inside a cell doubled ("")',
        ),
        (
            b'a,b\n1,"' + b"2" * 200_000,
            "r.csv, row 1: a cell of more than 131072 characters; expected shorter ones; is a "
            "quotation mark never closed?",
        ),
        (
            b"a,b\n1,2\n3,\xff4\n",
            "r.csv, row 2: byte 0xff, which is not UTF-8; expected UTF-8",
        ),
        (b"a\xff,b\n1,2\n", "r.csv, header: byte 0xff, which is not UTF-8; expected UTF-8"),
        (b"a,b\n1,\0\n", "r.csv, row 1: a NUL byte; expected text in UTF-8"),
        ("a,b\n1,2\n".encode("utf-16"), "r.csv: UTF-16 text; expected UTF-8"),
    ],
)
def test_says_what_is_wrong_with_the_text(data, message):
    assert refusal(data) == message


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"a,b\n1,2\n3\n", "r.csv, row 2: 1 cell; expected 2 as in the header"),
        (b"a,b\n1,2\n\n3,4,5\n", "r.csv, row 2: 3 cells; expected 2 as in the header"),
        (b"a,b\n1,2,3\n4,5\n", "r.csv, row 1: 3 cells; expected 2 as in the header"),
    ],
)
def test_says_which_rows_have_the_wrong_length(data, message):
    (bad,) = parse_csv(data, "r.csv").skipped
    assert bad.message("r.csv") == message


def test_sets_rows_of_the_wrong_length_aside():
    table = parse_csv(b"a,b\n1\n1,2\n1,2,3\n4,5\n", "r.csv")
    assert table.row.tolist() == [2, 4]
    assert [bad.row for bad in table.skipped] == [1, 3]


cells = st.text(alphabet="ab1 ,.\n\r\t\";'é", max_size=4)


@given(
    rows=st.integers(1, 4).flatmap(
        lambda n: st.lists(st.lists(cells, min_size=n, max_size=n), max_size=6)
    ),
    style=st.sampled_from([("\r\n", csv.QUOTE_MINIMAL), ("\n", csv.QUOTE_ALL)]),
)
def test_reads_back_what_pythons_own_writer_writes(rows, style):
    n = len(rows[0]) if rows else 2
    buffer = io.StringIO(newline="")
    writer = csv.writer(buffer, lineterminator=style[0], quoting=style[1])
    writer.writerows([[f"c{k}" for k in range(n)], *rows])
    table = parse_csv(buffer.getvalue().encode(), "r.csv")
    # A single blank cell is a blank line.
    wanted = [row for row in rows if n > 1 or row[0].strip()]
    assert table.columns.rows() == [tuple(cell or None for cell in row) for row in wanted]


@pytest.mark.slow
@settings(max_examples=1500)
@given(
    data=st.lists(
        st.sampled_from(
            [b"a", b"b1", b",", b",", b"\n", b"\n", b"\r\n", b"\r", b" ", b'"', b'"a"']
        ),
        max_size=40,
    ).map(b"".join)
)
def test_the_fast_parser_agrees_with_the_careful_one(data):
    def outcome(parse):
        try:
            table = parse(data.strip(b"\r\n"), "r.csv")
        except DataFormatError as err:
            return str(err)
        return table.columns.columns, table.columns.rows(), table.row.tolist()

    assert outcome(parse_csv) == outcome(parse_csv_carefully)


@pytest.mark.parametrize("mark", [";", "\t"])
def test_semicolons_and_tabs_may_part_columns_and_commas_be_decimal_points(mark: str) -> None:
    rows = [["time", "x", "name"], ["0,5", "-1,25e3", "a"], ["1", "2.5", "b c"]]
    table = parse_csv("\n".join(mark.join(row) for row in rows).encode(), "r.csv")
    assert table.columns.rows() == [("0.5", "-1.25e3", "a"), ("1", "2.5", "b c")]
    (note,) = table.notes
    assert note.endswith("part columns, and commas are taken for decimal points")
    without = parse_csv("\n".join(mark.join(row) for row in rows[::2]).encode(), "r.csv")
    assert without.notes == ()
    # A comma that is none leaves the text as it came.
    with pytest.raises(DataFormatError, match="one column"):
        parse_csv(f"time{mark}x{mark}name\n0,5{mark}1{mark}a, b\n".encode(), "r.csv")
