"""Every public name shows how it is used, and what it shows is so."""

import doctest

import numpy as np
import pytest

import trackweave

NAMES = [name for name in trackweave.__all__ if name != "__version__"]
OPTIONS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


@pytest.mark.parametrize("name", NAMES)
def test_every_public_name_has_an_example_that_runs(name: str) -> None:
    value = getattr(trackweave, name)
    assert "\nExamples\n" in (value.__doc__ or "").replace("    ", "")
    told: list[str] = []
    runner = doctest.DocTestRunner(optionflags=OPTIONS)
    with np.printoptions(precision=8, suppress=False):
        for case in doctest.DocTestFinder().find(value, name, globs={}):
            runner.run(case, out=told.append)
    assert "".join(told) == ""
    assert runner.summarize(verbose=False).attempted > 0
