"""Which columns are positions."""

import numpy as np
import polars as pl
import pytest

from trackweave.domain.frames import LocalFrame
from trackweave.errors import DataFormatError, InvalidInputError
from trackweave.io.checks import RowChecks
from trackweave.io.frames_in import from_native
from trackweave.io.positions import read_positions, require_origin


def positions(frame=None, **columns):
    checks = RowChecks(from_native(pl.DataFrame(columns)))
    found = read_positions(checks, frame)
    checks.finish("fail")
    return found


def test_takes_x_and_y_as_they_are():
    found = positions(x=[1.0], y=[2.0])
    assert found.values.tolist() == [[1.0, 2.0]]
    assert found.frame is None


def test_a_filled_z_makes_three_dimensions_and_an_empty_one_two():
    assert positions(x=[1.0], y=[2.0], z=[3.0]).values.tolist() == [[1.0, 2.0, 3.0]]
    assert positions(x=[1.0], y=[2.0], z=[None]).values.tolist() == [[1.0, 2.0]]


def test_refuses_a_z_that_is_missing_in_some_rows():
    with pytest.raises(DataFormatError, match="row 2, column z: "):
        positions(x=[1.0, 2.0], y=[2.0, 3.0], z=[3.0, None])


def test_lays_latitudes_and_longitudes_on_a_plane_about_their_median():
    found = positions(lat=[47.0, 47.00004, 60.0], lon=[8.0, 8.00004, 8.1])
    assert found.frame == LocalFrame(47.0, 8.0)
    np.testing.assert_allclose(found.values[0], [0.0, 0.0], atol=1e-6)
    np.testing.assert_allclose(found.values[1], [3.04, 4.45], atol=0.01)


def test_the_plane_does_not_break_at_the_date_line():
    found = positions(lat=[-17.0] * 4, lon=[179.9, -179.9, 179.8, -179.8])
    assert abs(found.frame.longitude_deg) == 180.0
    assert np.abs(found.values).max() < 30_000


def test_altitude_is_the_third_dimension_when_every_row_has_one():
    assert positions(lat=[47.0], lon=[8.0], alt_m=[900.0]).values[0, 2] == 900.0
    mixed = positions(lat=[47.0] * 2, lon=[8.0] * 2, alt_m=[900.0, None])
    assert mixed.values.shape == (2, 2)
    assert mixed.columns == ("lat", "lon")


def test_with_both_kinds_a_given_plane_decides():
    both = {"x": [1.0], "y": [2.0], "lat": [47.0], "lon": [8.0]}
    assert positions(**both).values.tolist() == [[1.0, 2.0]]
    assert positions(LocalFrame(47.0, 8.0), **both).frame == LocalFrame(47.0, 8.0)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"lat": [90.5], "lon": [0.0]}, "row 1, column lat: 90.5; expected a number from -90 to"),
        ({"lat": [0.0], "lon": [361.0]}, "row 1, column lon: 361.0; expected a number from -180"),
        (
            {"x": [1e12], "y": [0.0]},
            "row 1, column x: 1000000000000.0; expected a number from -1e",
        ),
        ({"x": [float("nan")], "y": [0.0]}, "row 1, column x: nan; expected a finite number"),
        (
            {"lat": [0.0] * 3, "lon": [0.0, 0.0, 90.0]},
            "row 3, column lon: 90.0; expected a position within 30 degrees",
        ),
        (
            {"lat": [0.0] * 2 + [-70.0], "lon": [0.0] * 3},
            "row 3, column lat: -70.0; expected a position within 30 degrees",
        ),
        ({"x": [1.0]}, "column y: missing; expected position columns x,y"),
        ({"lon": [1.0]}, "column lat: missing; expected position columns x,y"),
        ({"X": [1.0], "Y": [1.0]}, "columns x and y: missing; expected position columns x,y"),
        ({"bearing_deg": [1.0]}, "columns x and y: missing; expected position columns x,y"),
    ],
)
def test_says_what_is_wrong_with_positions(columns, message):
    with pytest.raises(DataFormatError) as caught:
        positions(**columns)
    assert str(caught.value).startswith(f"table, {message}")


def test_latitudes_under_another_name_are_told_by_which_to_call_them():
    with pytest.raises(DataFormatError) as caught:
        positions(**{"time": [1.0], "Lat (deg)": [52.0], "Long (deg)": [4.0]})
    assert "--from 'csv?lat=Lat (deg)&lon=Long (deg)' tells" in str(caught.value)


def test_ranges_under_another_name_are_told_by_which_to_call_them():
    with pytest.raises(DataFormatError, match=r"range_m=NAME&azimuth_deg=NAME"):
        positions(**{"Range (m)": [1.0], "Azimuth": [2.0]})


@pytest.mark.parametrize("origin", [(91.0, 0.0), (0.0, float("nan")), (1.0,), "ab", None, 3.0])
def test_refuses_an_origin_that_is_no_position(origin):
    with pytest.raises(InvalidInputError, match="frame_origin"):
        require_origin(origin)


def test_a_world_wide_recording_is_told_how_to_be_tracked():
    rng = np.random.default_rng(2)
    around = {"lat": rng.uniform(-60, 60, 90), "lon": rng.uniform(-180, 180, 90)}
    here = {"lat": np.full(20, 54.31), "lon": np.full(20, 12.11)}
    with pytest.raises(DataFormatError) as caught:
        positions(**{name: [*around[name], *here[name]] for name in around})
    told = str(caught.value)
    assert "of 110 rows lie farther off: a world-wide recording is tracked part by part" in told
    assert "[frame] origin = [latitude, longitude], such as [54.3, 12.1] where most" in told
