"""What a fusion runs with, and where each value came from."""

from typing import Any

import pytest

from trackweave.errors import InvalidInputError
from trackweave.fusion.statistic import Statistic
from trackweave.run.fusion_settings import FusionSettings, settle_fusion
from trackweave.solvers import Auto, Exact, ListGenetic


def settled(given: dict[str, Any] | None = None, preset: str | None = None) -> FusionSettings:
    return settle_fusion(given or {}, preset=preset, process_noise=0.3)


def test_defaults_are_those_of_the_library_but_for_errors_that_filters_make() -> None:
    settings = settled()
    associator = settings.associator(["A", "B"])
    assert associator.statistic == Statistic(correlation="effective")
    assert isinstance(associator.search, Auto)
    assert associator.process_noise == 0.3
    assert settings.sources["process_noise"] == "estimated"
    assert settings.sources["statistic.kind"] == "default"
    assert settings.values["method"] == "fast-covariance-intersection"


def test_without_covariances_to_tell_it_the_process_noise_is_the_default() -> None:
    settings = settle_fusion({}, preset=None, process_noise=None)
    assert settings.values["process_noise"] == 1.0
    assert settings.sources["process_noise"] == "default"


def test_what_is_given_goes_before_the_preset() -> None:
    given = {"statistic": {"false_rejection": 0.05}, "method": None, "search": {"method": None}}
    settings = settled(given, "huo-2008")
    associator = settings.associator(["A", "B", "C"])
    assert associator.complete
    assert associator.confirm == "3/4"
    assert associator.statistic == Statistic("chain", "full", false_rejection=0.05)
    assert isinstance(associator.search, ListGenetic)
    assert not associator.search.seeded
    assert settings.values["method"] == "convex"
    assert settings.sources["statistic.false_rejection"] == "given"
    assert settings.sources["search.population"] == "preset"


def test_another_search_than_the_presets_has_none_of_its_options() -> None:
    settings = settled({"search": {"method": "exact"}}, "huo-2008")
    assert isinstance(settings.associator([]).search, Exact)
    assert settings.values["search"] == {"method": "exact"}
    assert [key for key in settings.sources if key.startswith("search.")] == ["search.method"]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"mehtod": "convex"}, "config, mehtod: unknown key; did you mean method"),
        (
            {"statistic": {"knd": "chain"}},
            r"config, statistic\.knd: unknown key; did you mean kin",
        ),
        ({"statistic": 3}, "config, statistic: 3; expected a table"),
        ({"method": "mean"}, "method: 'mean'; expected one of convex"),
        ({"statistic": {"false_rejection": 2.0}}, r"false_rejection: 2\.0"),
        ({"complete": "yes"}, "config, complete: 'yes'; expected true or false"),
        ({"confirm": "4/3"}, "needed, of"),
        ({"bias": ["tilt"]}, "estimate"),
        ({"process_noise": -1.0}, r"process_noise: -1\.0"),
        ({"search": {"method": "exhaustive"}}, r"search\.method: .exhaustive. is not known"),
        ({"search": {"method": "exact", "population": 3}}, "population"),
        ({"complete": True}, "expected 'chain' for complete"),
    ],
)
def test_refuses_what_it_cannot_use(given: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        settled(given)


def test_refuses_presets_of_another_kind() -> None:
    with pytest.raises(InvalidInputError, match='"hillis-1997" is one for tracking'):
        settled(preset="hillis-1997")
    with pytest.raises(InvalidInputError, match="did you mean huo-2008"):
        settled(preset="huo-2007")
