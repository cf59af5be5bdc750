"""Formats of those who follow cells and particles: what goes out comes back the same."""

import json
import struct
import xml.etree.ElementTree as ET
from io import BytesIO
from pathlib import Path

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.errors import DataFormatError, InvalidInputError
from trackweave.formats.format import Output
from trackweave.formats.reading import load
from trackweave.formats.registry import format_named

# Two cells; the first is not seen in the third frame.
TRACKS = pl.DataFrame(
    {
        "time": [0.0, 1.0, 3.0, 1.0, 2.0, 3.0],
        "track": [1, 1, 1, 2, 2, 2],
        "status": ["confirmed"] * 6,
        "x": [20.0, 21.0, 23.0, 60.0, 61.0, 62.0],
        "y": [30.0, 30.0, 31.0, 40.0, 40.0, 41.0],
    }
)


def files_of(name: str, tracks: pl.DataFrame = TRACKS) -> dict[str, bytes]:
    return dict(format_named(name, writes=True).writer(Output(tracks)))


def in_folder(files: dict[str, bytes], folder: Path) -> Path:
    for name, data in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    return folder / next(iter(files)).partition("/")[0]


def states(table: pl.DataFrame, name: str = "track") -> set[tuple[float, float, float, int]]:
    """Return positions and whose they are, by the order in which each comes first."""
    rows = table.sort("time", "x").select("time", "x", "y", name).rows()
    numbers: dict[object, int] = {}
    return {(*row[:3], numbers.setdefault(row[3], len(numbers))) for row in rows}


def test_trackmate_comes_back_the_same(tmp_path):
    path = in_folder(files_of("trackmate"), tmp_path)
    assert path.name == "tracks.trackmate.xml"
    assert states(load(path).columns, "target") == states(TRACKS)


def test_ctc_paints_each_label_in_each_of_its_frames(tmp_path):
    files = files_of("ctc")
    assert files["tracks.ctc/res_track.txt"] == b"1 0 1 0\n2 3 3 1\n3 1 3 0\n"
    assert sum(name.endswith(".tif") for name in files) == 4
    first = np.frombuffer(files["tracks.ctc/mask000.tif"][8:], "<u2", 68 * 47).reshape(47, 68)
    assert first[30, 20] == 1
    assert set(np.unique(first)) == {0, 1}


def labels_of(files: dict[str, bytes], frame: int) -> np.ndarray:
    """Return an image of labels as a reader of TIFF finds it."""
    tifffile = pytest.importorskip("tifffile")
    return np.asarray(tifffile.imread(BytesIO(files[f"tracks.ctc/mask{frame:03d}.tif"])))


@pytest.mark.parametrize("apart", [0.0, 0.3, 1.5, 3.0])
@pytest.mark.parametrize("n_tracks", [2, 5, 100])
def test_ctc_leaves_each_track_a_pixel_of_its_own_however_near_others_are(n_tracks, apart):
    angle = np.linspace(0.0, 2 * np.pi, n_tracks, endpoint=False)
    rows = pl.DataFrame(
        {
            "time": np.zeros(n_tracks),
            "track": np.arange(1, n_tracks + 1),
            "x": 20.0 + apart * np.cos(angle),
            "y": 20.0 + apart * np.sin(angle),
        }
    )
    image = labels_of(files_of("ctc", rows), 0)
    assert set(np.unique(image)) == set(range(n_tracks + 1))


def test_ctc_gives_what_two_discs_share_to_the_nearer():
    rows = pl.DataFrame({"time": [0.0] * 2, "track": [1, 2], "x": [20.0, 24.0], "y": [20.0] * 2})
    image = labels_of(files_of("ctc", rows), 0)
    assert (image[:, :22] != 2).all()
    assert (image[:, 23:] != 1).all()
    assert (image == 1).sum() + (image == 2).sum() > 81


def test_ctc_paints_each_label_in_one_piece():
    from scipy.ndimage import label

    rng = np.random.default_rng(3)
    for count in (2, 3, 10):
        rows = pl.DataFrame(
            {
                "time": np.repeat(np.arange(30.0), count),
                "track": np.tile(np.arange(1, count + 1), 30),
                "x": 20.0 + 3.0 * rng.standard_normal(30 * count),
                "y": 20.0 + 3.0 * rng.standard_normal(30 * count),
            }
        ).sort("track", "time")
        files = files_of("ctc", rows)
        for frame in range(30):
            image = labels_of(files, frame)
            pieces = [label(image == number)[1] for number in range(1, count + 1)]
            assert pieces == [1] * count


def test_ctc_is_read_by_an_independent_reader_of_images(tmp_path):
    pytest.importorskip("tifffile")
    table = load(in_folder(files_of("ctc"), tmp_path)).columns
    found = table.with_columns(pl.col("target").replace({2: 1, 3: 2}))
    assert states(found, "target") == states(TRACKS)


@pytest.mark.parametrize(("octet", "value"), [(36, 1), (62, 0), (45, 255)])
def test_ctc_refuses_an_image_of_which_an_octet_is_wrong(tmp_path, octet, value):
    # Of an image of 4 by 3 pixels each of these made the reader of images raise another error.
    pytest.importorskip("tifffile")
    pixels, tags = bytes([1, 0] * 12), ((256, 4, 4), (257, 4, 3), (258, 3, 16), (259, 3, 1))
    tags += ((262, 3, 1), (273, 4, 8), (277, 3, 1), (278, 4, 3), (279, 4, 24))
    image = struct.pack("<2sHI", b"II", 42, 32) + pixels + struct.pack("<H", 9)
    image += b"".join(struct.pack("<HHII", tag, kind, 1, told) for tag, kind, told in tags)
    image = bytearray(image + bytes(4))
    (tmp_path / "mask000.tif").write_bytes(image)
    assert load(tmp_path).columns["pixels"].to_list() == [12]
    image[octet] = value
    (tmp_path / "mask000.tif").write_bytes(image)
    with pytest.raises(DataFormatError, match=r"mask000\.tif: no label image \("):
        load(tmp_path)


def test_geff_has_a_node_for_each_state_and_an_edge_for_each_step(tmp_path):
    files = files_of("geff")
    told = json.loads(files["tracks.geff/.zattrs"])["geff"]
    assert [axis["name"] for axis in told["axes"]] == ["t", "z", "y", "x"]
    edges = np.frombuffer(files["tracks.geff/edges/ids/0.0"], "<u8").reshape(-1, 2)
    assert edges.tolist() == [[0, 1], [1, 2], [3, 4], [4, 5]]


def test_geff_is_valid_by_its_own_library(tmp_path):
    geff = pytest.importorskip("geff")
    path = in_folder(files_of("geff"), tmp_path)
    geff.validate_structure(path)
    graph, _ = geff.read(path, backend="networkx")
    assert (graph.number_of_nodes(), graph.number_of_edges()) == (6, 4)
    assert graph.nodes[2]["x"] == 23.0


def test_geff_comes_back_the_same(tmp_path):
    pytest.importorskip("zarr")
    path = in_folder(files_of("geff"), tmp_path)
    assert states(load(path).columns, "target") == states(TRACKS)


@pytest.mark.parametrize("name", ["trackmate", "ctc", "geff"])
def test_no_tracks_are_a_file_too(name):
    assert files_of(name, TRACKS.clear())


def test_what_is_no_pixel_cannot_be_painted():
    with pytest.raises(InvalidInputError, match="below 0"):
        files_of("ctc", TRACKS.with_columns(pl.col("x") - 100))
    with pytest.raises(InvalidInputError, match="too large"):
        files_of("ctc", TRACKS.with_columns(pl.col("x") * 1e6))


def test_a_folder_that_is_none_is_refused(tmp_path):
    with pytest.raises(
        InvalidInputError, match=r"that is no recording; .* the format ctc or geff "
    ):
        load(tmp_path)


def test_napari_takes_a_row_for_each_state_of_each_track():
    frames = pl.DataFrame({"frame": range(9), "x": np.arange(9.0), "y": [1.0, 0.0, 1.0] * 3})
    data, properties, graph = tw.track(frames).to_napari()
    assert data.shape[1] == 4
    assert (data[:, 0] == 1).all()
    assert data[:, 1].tolist() == list(range(9))
    assert np.abs(data[:, 3] - np.arange(9)).max() < 1.5  # x is the last axis of an image
    assert len(properties["time"]) == len(data)
    assert graph == {}


# The first cell divides: a mother with a gap, two daughters, one of whom has a gap too.
FAMILY = pl.DataFrame(
    {
        "time": [0.0, 2.0, 3.0, 5.0, 3.0, 4.0, 0.0],
        "track": [7, 7, 8, 8, 9, 9, 4],
        "parent": [None, None, 7, 7, 7, 7, None],
        "x": [20.0, 21.0, 26.0, 28.0, 15.0, 14.0, 60.0],
        "y": [30.0, 30.0, 31.0, 31.0, 30.0, 30.0, 20.0],
    }
)


def test_ctc_names_the_mother_of_a_track():
    # Frames count the times there are: 0, 2, 3, 4, 5.
    text = files_of("ctc", FAMILY)["tracks.ctc/res_track.txt"].decode()
    assert text.splitlines() == ["1 0 0 0", "2 0 1 0", "3 2 2 2", "4 4 4 3", "5 2 3 2"]


def test_trackmate_has_a_track_for_a_family_and_branches():
    (content,) = files_of("trackmate", FAMILY).values()
    root = ET.fromstring(content)
    tracks = {
        each.get("TRACK_ID"): {
            (edge.get("SPOT_SOURCE_ID"), edge.get("SPOT_TARGET_ID")) for edge in each.iter("Edge")
        }
        for each in root.iter("Track")
    }
    # Spots count the states by track, then time: 0 is of track 4, 1 and 2 of the mother.
    family = {("1", "2"), ("2", "3"), ("3", "4"), ("2", "5"), ("5", "6")}
    assert tracks == {"4": set(), "7": family}


def test_geff_joins_daughters_with_their_mother(tmp_path):
    geff = pytest.importorskip("geff")
    path = in_folder(files_of("geff", FAMILY), tmp_path)
    geff.validate_structure(path)
    graph, _ = geff.read(path, backend="networkx")
    assert sorted(graph.edges) == [(1, 2), (2, 3), (2, 5), (3, 4), (5, 6)]
    assert {graph.nodes[node]["lineage_id"] for node in (1, 6)} == {7}


# As in tracks.csv: the mother is foretold for two scans more, while her daughters are there.
FORETOLD = pl.DataFrame(
    {
        "time": [0.0, 1.0, 2.0, 3.0, 2.0, 3.0, 2.0, 3.0],
        "track": [1, 1, 1, 1, 2, 2, 3, 3],
        "parent": [None] * 4 + [1] * 4,
        "last_update": [0.0, 1.0, 1.0, 1.0, 2.0, 3.0, 2.0, 3.0],
        "x": [20.0, 20.0, 20.0, 20.0, 24.0, 28.0, 16.0, 12.0],
        "y": [20.0] * 8,
    }
)


def test_a_mother_foretold_beside_her_daughters_ends_where_she_divides(tmp_path):
    text = files_of("ctc", FORETOLD)["tracks.ctc/res_track.txt"].decode()
    assert text.splitlines() == ["1 0 1 0", "2 2 3 1", "3 2 3 1"]
    (content,) = files_of("trackmate", FORETOLD).values()
    edges = ET.fromstring(content).iter("Edge")
    found = {(e.get("SPOT_SOURCE_ID"), e.get("SPOT_TARGET_ID")) for e in edges}
    assert found == {("0", "1"), ("1", "2"), ("2", "3"), ("1", "4"), ("4", "5")}
    edges = np.frombuffer(files_of("geff", FORETOLD)["tracks.geff/edges/ids/0.0"], "<u8")
    assert edges.reshape(-1, 2).tolist() == [[0, 1], [1, 2], [2, 3], [1, 4], [4, 5]]


def test_a_mother_who_goes_on_is_her_own_child_beside_the_others():
    # As yeast does, and where nothing tells that she was not seen any more.
    buds = FORETOLD.drop("last_update")
    text = files_of("ctc", buds)["tracks.ctc/res_track.txt"].decode()
    assert text.splitlines() == ["1 0 1 0", "2 2 3 1", "3 2 3 1", "4 2 3 1"]
    edges = np.frombuffer(files_of("geff", buds)["tracks.geff/edges/ids/0.0"], "<u8")
    assert sorted(edges.reshape(-1, 2).tolist()) == [
        [0, 1], [1, 2], [1, 4], [1, 6], [2, 3], [4, 5], [6, 7],
    ]  # fmt: skip


@pytest.mark.parametrize("name", ["ctc", "trackmate", "geff"])
def test_a_mother_that_is_not_there_or_comes_later_is_none(name):
    odd = FAMILY.with_columns(parent=pl.Series([8, 8, 99, 99, 9, 9, None]))
    assert files_of(name, odd)
