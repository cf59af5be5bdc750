"""What every decoder keeps to, whatever comes in whatever pieces."""

import numpy as np
import polars as pl
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from polars.testing import assert_frame_equal

from formats.samples import SAMPLES
from trackweave.domain.facts import Skips
from trackweave.errors import DataFormatError
from trackweave.formats.registry import format_named, formats, recognised
from trackweave.io.reports import reports_in
from trackweave.io.tables import RawTable

cases = pytest.mark.parametrize("case", SAMPLES)


def decoded(name: str, pieces: list[bytes]) -> tuple[pl.DataFrame, Skips]:
    """Return what a format's decoder makes of bytes in pieces."""
    decoder = format_named(name).decoder()
    frames = [*(decoder.feed(piece) for piece in pieces), decoder.finish()]
    found = [frame for frame in frames if frame is not None]
    return pl.concat(found, how="diagonal_relaxed") if found else pl.DataFrame(), decoder.skips


def cut(data: bytes, places: list[int]) -> list[bytes]:
    ends = sorted(place % (len(data) + 1) for place in places)
    return [data[a:b] for a, b in zip([0, *ends], [*ends, len(data)], strict=True)]


def as_lists(found: tuple[pl.DataFrame, Skips]) -> tuple[pl.DataFrame, list[tuple[int, str]]]:
    frame, skips = found
    return frame.select(sorted(frame.columns)), sorted((s.offset, s.what) for s in skips.listed)


def test_addresses_of_aircraft_are_in_small_letters():
    frame, _ = decoded("sbs", [SAMPLES["sbs"][1]])
    assert frame["identity"].to_list() == ["4ca2d6", "400f01"]


def test_every_decoder_has_a_sample():
    ours = {each.name for each in formats().values() if each.decoder is not None}
    assert ours == {name for name, *_ in SAMPLES.values()}


@cases
def test_what_is_there_is_found_and_what_is_wrong_is_skipped_where_it_is(case):
    name, data, n_reports, n_skipped = SAMPLES[case]
    frame, skips = decoded(name, [data])
    assert (len(frame), skips.count) == (n_reports, n_skipped), skips.listed
    assert all(0 <= skip.offset < len(data) for skip in skips.listed)


@cases
def test_the_content_tells_the_format(case):
    name, data, *_ = SAMPLES[case]
    found = recognised(data, "a file without a name that tells")
    assert found is not None
    assert found.name == name


@cases
def test_its_reports_can_be_tracked(case):
    name, data, *_ = SAMPLES[case]
    frame, _ = decoded(name, [data])
    timed = frame.filter(pl.col("time").is_not_null())
    table = RawTable("x", timed, np.arange(1, len(timed) + 1))
    # Of a sample's ships some are too far from the others for one plane.
    assert len(reports_in(table, on_bad_row="skip")) > 0


@pytest.mark.slow
@cases
@settings(max_examples=60)
@given(places=st.lists(st.integers(0, 1 << 20), max_size=12))
def test_pieces_make_no_difference(case, places):
    name, data, *_ = SAMPLES[case]
    frame, listed = as_lists(decoded(name, [data]))
    again, listed_again = as_lists(decoded(name, cut(data, places)))
    assert_frame_equal(frame, again)
    assert listed == listed_again


@cases
def test_one_byte_at_a_time_makes_no_difference(case):
    name, data, *_ = SAMPLES[case]
    frame, listed = as_lists(decoded(name, [data]))
    again, listed_again = as_lists(decoded(name, [bytes([byte]) for byte in data]))
    assert_frame_equal(frame, again)
    assert listed == listed_again


@pytest.mark.slow
@cases
@settings(max_examples=150)
@given(
    changes=st.lists(st.tuples(st.integers(0, 1 << 20), st.binary(max_size=4)), max_size=6),
    length=st.integers(0, 1 << 20),
    places=st.lists(st.integers(0, 1 << 20), max_size=4),
)
def test_damage_is_skipped_and_raises_nothing(case, changes, length, places):
    name, data, *_ = SAMPLES[case]
    for place, new in changes:
        place %= len(data)
        data = data[:place] + new + data[place + 1 :]
    data = data[: length % (2 * len(data))]
    try:
        frame, listed = as_lists(decoded(name, [data]))
        again, listed_again = as_lists(decoded(name, cut(data, places)))
    except DataFormatError as err:
        assert "\n" not in str(err)
        return
    if len(frame):
        assert_frame_equal(frame, again)
        assert frame["time"].dtype in (pl.Float64, pl.Datetime("us", "UTC"))
    assert listed == listed_again
