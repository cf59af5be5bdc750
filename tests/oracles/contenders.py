"""Every solver, in the shapes that all tests of solvers try."""

from dataclasses import replace

from trackweave.solvers import (
    Annealing,
    AntSystem,
    Auto,
    Dual,
    Exact,
    Genetic,
    Greedy,
    Islands,
    ListGenetic,
    MBest,
    Solver,
    TabuSearch,
)

SMALL = {"population": 10, "generations": 12}
LETTER = Genetic(
    **SMALL, seeded=False, improvement=False, decompose=False, elite=0, selection="rank"
)
SOLVERS: dict[str, Solver] = {
    "auto": Auto(),
    "auto with little to spend": Auto(evaluations=50, branches=1),
    "greedy": Greedy(),
    "exact": Exact(),
    "dual": Dual(),
    "dual without enumeration": Dual(visits=0),
    "genetic": Genetic(**SMALL),
    "genetic, association list": Genetic(**SMALL, genotype="association-list"),
    "genetic to the letter": LETTER,
    "genetic to the letter, lone reports kept": replace(LETTER, settle=False),
    "association list, unseeded": replace(LETTER, genotype="association-list"),
    "m-best": MBest(hypotheses=20),
    "m-best by partitioning": MBest(hypotheses=3, visits=1, solves=4),
    "list genetic": ListGenetic(**SMALL),
    "list genetic to the letter": ListGenetic(
        **SMALL, seeded=False, improvement=False, decompose=False
    ),
    "ant system": AntSystem(ants=8, cycles=12),
    "ant system, whole": AntSystem(ants=8, cycles=12, decompose=False),
    "ant system, seeded": AntSystem(ants=8, cycles=12, seeded=True),
    "annealing": Annealing(evaluations=6000, moves_per_item=300),
    "annealing, unseeded": Annealing(
        evaluations=6000, links=1, seeded=False, improvement=False, decompose=False
    ),
    "islands of one method": Islands((Genetic(**SMALL),), threads=1, epochs=8),
    "islands on threads": Islands(
        (
            Annealing(evaluations=2000),
            ListGenetic(**SMALL),
            TabuSearch(),
            Genetic(**SMALL),
            AntSystem(ants=8),
        ),
        islands=5,
        threads=3,
        epoch=2,
        neighbours=2,
        epochs=5,
    ),
    "islands to the letter": Islands(
        (LETTER, replace(LETTER, genotype="association-list")), islands=2, epoch=3, epochs=6
    ),
    "tabu search": TabuSearch(evaluations=3000),
    "tabu search, unseeded": TabuSearch(
        evaluations=3000,
        links=3,
        moves_per_item=40,
        seeded=False,
        improvement=False,
        decompose=False,
    ),
}
