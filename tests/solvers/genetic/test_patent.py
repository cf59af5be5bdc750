"""What US patent 6,055,523 says, column by column."""

import itertools

import numpy as np
import pytest

from oracles.decoding import Decoder
from trackweave.association.problem import AssignmentProblem
from trackweave.solvers.genetic._operators import crossover, move

# The drawings: D0,0 D0,1 D0,2 stand in one scan, D1,0 and D1,1 half-way between them in the next,
# D2,0 and D2,1 straight above those.
PLACES = [[0.0, 1.0, 2.0], [0.5, 1.5], [0.5, 1.5]]
FIGURES = {
    # As printed this repeats D1,0; its second must be D1,1, as in the drawing.
    "1": ("00 10 01 11 02", {("00", "10"), ("01", "11"), ("02",)}),
    "2": ("00 10 02 11 01", {("00", "10"), ("02", "11"), ("01",)}),
    "3": ("01 10 02 11 00", {("01", "10"), ("02", "11"), ("00",)}),
    "4": ("01 10 20 02 11 21 00", {("01", "10", "20"), ("02", "11", "21"), ("00",)}),
}


def detections(n_scans: int) -> tuple[list[str], Decoder]:
    """Return the names of the drawings' detections, and what decodes their permutations.

    To follow a detection costs the squared distance less one; each chain over the scans has a
    node. New tracks cost nothing and lone reports are tracks, as in the document.
    """
    names = [f"{scan}{j}" for scan in range(n_scans) for j in range(len(PLACES[scan]))]
    parent, item, cost = [], [], []

    def grow(above: int, scan: int, so_far: float, at: float) -> None:
        for later in range(scan, n_scans):
            for j, place in enumerate(PLACES[later]):
                parent.append(above)
                item.append(names.index(f"{later}{j}"))
                cost.append(so_far + ((place - at) ** 2 - 1.0 if above >= 0 else 0.0))
                grow(len(parent) - 1, later + 1, cost[-1], place)

    grow(-1, 0, 0.0, 0.0)
    instant = [int(name[0]) for name in names]
    must = [False] * len(names)
    problem = AssignmentProblem(parent, item, cost, cost, must, instant)
    return names, Decoder.of(problem, settle=False)


def decode(string: list[str], n_scans: int) -> set[tuple[str, ...]]:
    names, decoder = detections(n_scans)
    _, tracks = decoder.decode([names.index(name) for name in string])
    return {tuple(names[item] for item in track) for track in tracks}


@pytest.mark.parametrize("figure", FIGURES)
def test_strings_decode_to_their_drawings(figure: str) -> None:
    string, drawing = FIGURES[figure]
    assert decode(string.split(), n_scans=3 if figure == "4" else 2) == drawing


def test_the_mapping_of_strings_is_not_one_to_one() -> None:
    assert decode(["00", "10", "02", "11", "01"], 2) == decode(["02", "00", "11", "10", "01"], 2)


def test_never_moves_backwards_or_is_in_two_places_at_once() -> None:
    names, decoder = detections(2)
    for order in itertools.permutations(range(len(names))):
        _, tracks = decoder.decode(order)
        assert sorted(item for track in tracks for item in track) == [0, 1, 2, 3, 4]
        for track in tracks:
            scans = [int(names[item][0]) for item in track]
            assert scans == sorted(set(scans))


def test_a_track_is_not_extended_into_its_past() -> None:
    # 00 and 01 are near enough to 10, but come after it in the string and before it in time.
    assert decode(["10", "00", "01", "02", "11"], 2) == {("10",), ("00",), ("01", "11"), ("02",)}


def cross(first: list[int], second: list[int], cut: int) -> list[int]:
    child = np.zeros(len(first), dtype=np.int64)
    seen = np.ones(max(first) + 1, dtype=np.bool_)
    crossover(np.array(first), np.array(second), cut, seen, child)
    return child.tolist()


def test_crossover_does_the_documents_example() -> None:
    first, second = [1, 2, 3, 4, 5, 6], [3, 4, 1, 2, 6, 5]
    assert cross(first, second, 3) == [1, 2, 3, 4, 6, 5]
    assert cross(second, first, 3) == [3, 4, 1, 2, 5, 6]


def test_crossover_keeps_the_beginning_and_the_others_order() -> None:
    rng = np.random.default_rng(0)
    for _ in range(100):
        size = int(rng.integers(2, 9))
        first, second = rng.permutation(size).tolist(), rng.permutation(size).tolist()
        cut = int(rng.integers(1, size))
        rest = [gene for gene in second if gene not in first[:cut]]
        assert cross(first, second, cut) == first[:cut] + rest


@pytest.mark.parametrize(
    ("source", "target", "moved"),
    [
        (1, 4, [1, 3, 4, 5, 2, 6]),
        (4, 1, [1, 5, 2, 3, 4, 6]),
        (0, 5, [2, 3, 4, 5, 6, 1]),
        (5, 0, [6, 1, 2, 3, 4, 5]),
        (3, 3, [1, 2, 3, 4, 5, 6]),
    ],
)
def test_mutation_moves_one_point(source: int, target: int, moved: list[int]) -> None:
    genes = np.arange(1, 7)
    move(genes, source, target)
    assert genes.tolist() == moved
