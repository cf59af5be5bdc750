"""Every public name shows how it is used, and what it shows is so."""

import doctest
import inspect
import re

import numpy as np
import pytest

import trackweave
import trackweave.metrics
import trackweave.simulation

NAMES = [name for name in trackweave.__all__ if name != "__version__"]
PACKAGES = (trackweave.simulation, trackweave.metrics)
OPTIONS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


def has_examples(value: object) -> bool:
    return "\nExamples\n" in (value.__doc__ or "").replace("    ", "")


def run_examples(name: str, value: object) -> None:
    """Run the examples of a name, of which there are some, and see that they are so."""
    told: list[str] = []
    runner = doctest.DocTestRunner(optionflags=OPTIONS)
    with np.printoptions(precision=8, suppress=False):
        for case in doctest.DocTestFinder().find(value, name, globs={}):
            runner.run(case, out=told.append)
    assert "".join(told) == ""
    assert runner.summarize(verbose=False).attempted > 0


@pytest.mark.parametrize("name", NAMES)
def test_every_public_name_has_an_example_that_runs(name: str) -> None:
    value = getattr(trackweave, name)
    assert has_examples(value)
    run_examples(name, value)


@pytest.mark.parametrize(
    ("package", "name"),
    [(package, name) for package in PACKAGES for name in package.__all__],
    ids=lambda value: getattr(value, "__name__", value),
)
def test_a_name_of_a_public_package_has_one_or_is_returned_in_one(package, name) -> None:
    value = getattr(package, name)
    if has_examples(value):
        run_examples(name, value)
        return
    functions = [each for each in vars(package).values() if inspect.isfunction(each)]
    assert any(
        has_examples(function)
        and re.search(rf"\b{name}\b", str(inspect.signature(function).return_annotation))
        for function in functions
    )
