"""A search that fails, which workers can import."""

from typing import NoReturn

from trackweave.solvers import Annealing


class Unfit(Annealing):
    __slots__ = ()

    def _go_on(self, view: object, search: object, evaluations: int) -> NoReturn:
        message = "unfit"
        raise ArithmeticError(message)
