"""What a fusion runs with, and where each value came from."""

from pathlib import Path
from typing import Any, get_args, get_type_hints

import pytest

from trackweave.config import load_configuration
from trackweave.config.fusion import DEFAULTS, FusionSettings, order_of, settle_fusion
from trackweave.config.schema import json_schema
from trackweave.errors import InvalidInputError
from trackweave.fusion.bias import BIASES
from trackweave.fusion.combine import COMBINATIONS
from trackweave.fusion.statistic import KINDS, Statistic
from trackweave.solvers import Auto, Exact, ListGenetic


def settled(
    given: Any = None, preset: str | None = None, options: dict[str, Any] | None = None
) -> FusionSettings:
    return settle_fusion(order_of(given, options), preset=preset, process_noise=0.3)


def test_a_file_has_the_keys_and_words_of_the_library() -> None:
    known = json_schema()["$defs"]
    fusion, statistic = (known[f"{name}Section"]["properties"] for name in ("Fusion", "Statistic"))
    assert set(fusion) == set(DEFAULTS)
    assert set(statistic) == set(DEFAULTS["statistic"])
    assert set(fusion["method"]["enum"]) == set(COMBINATIONS)
    assert set(statistic["kind"]["enum"]) == set(KINDS)
    for key in ("memory", "correlation"):
        assert set(statistic[key]["enum"]) == set(get_args(get_type_hints(Statistic)[key]))
    assert fusion["bias"]["items"]["enum"] == list(BIASES)
    order_of({"register": True, "bias": list(BIASES)})


def test_options_go_before_the_file_and_that_before_the_preset_key_by_key(
    tmp_path: Path,
) -> None:
    path = tmp_path / "tracker.toml"
    path.write_text(
        "seed = 7\n[fusion]\nconfirm = '4/5'\n[fusion.statistic]\nfalse_rejection = 0.05\n"
        "[fusion.search]\npopulation = 40\n"
    )
    options = {"confirm": "2/3", "statistic": {"correlation": None}, "search": {"method": None}}
    found = settled(path, "huo-2008", options)
    assert order_of(path).seed == 7
    assert found.values["confirm"] == "2/3"
    assert found.values["statistic"]["false_rejection"] == 0.05
    assert found.values["search"]["population"] == 40
    assert found.values["search"]["reproduction"] == 0.2
    told = {key: found.sources[key] for key in (
        "confirm", "statistic.false_rejection", "search.population", "search.reproduction",
        "process_noise", "patience",
    )}  # fmt: skip
    assert list(told.values()) == ["given", "file", "file", "preset", "estimated", "default"]


def test_a_method_said_again_keeps_the_presets_options_and_another_drops_them() -> None:
    again = settled({"search": {"method": "list-genetic", "population": 40}}, "huo-2008")
    assert again.values["search"]["reproduction"] == 0.2
    assert again.values["search"]["population"] == 40
    # What a file says of one method is not said of the one that an option names.
    other = settled({"search": {"population": 40}}, "huo-2008", {"search": {"method": "exact"}})
    assert other.values["search"] == {"method": "exact"}


def test_takes_the_table_or_a_whole_configuration() -> None:
    table = {"statistic": {"false_rejection": 0.05}}
    whole = {"motion": {"max_speed": 30.0}, "fusion": table}
    assert settled(table).values == settled(whole).values
    assert settled(load_configuration(whole)).sources["statistic.false_rejection"] == "file"


def test_a_configuration_for_tracking_may_have_the_table_and_it_is_checked() -> None:
    text = {"fusion": {"statistic": {"knd": "chain"}}}
    with pytest.raises(InvalidInputError, match=r"fusion\.statistic\.knd: unknown key; did you"):
        load_configuration(text)
    with pytest.raises(InvalidInputError, match=r"fusion\.search\.method: .brute. is not known"):
        load_configuration({"fusion": {"search": {"method": "brute"}}})
    with pytest.raises(InvalidInputError, match=r"fusion\.register: 3; expected true or false"):
        load_configuration({"fusion": {"register": 3}})


def test_the_schema_has_the_table_with_ranges_and_options() -> None:
    known = json_schema()["$defs"]
    assert "register" in known["FusionSection"]["properties"]
    rate = known["StatisticSection"]["properties"]["false_rejection"]
    assert (rate["minimum"], rate["maximum"]) == (1e-12, 1 - 1e-12)
    assert "by_size" in known["SolverSection"]["properties"]


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
    settings = settle_fusion(order_of(None), preset=None, process_noise=None)
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
        ({"method": "mean"}, 'config, method: "mean"; expected one of "convex"'),
        ({"statistic": {"false_rejection": 2.0}}, r"false_rejection: 2\.0; expected a number"),
        ({"complete": "yes"}, 'config, complete: "yes"; expected true or false'),
        ({"confirm": "4/3"}, 'confirm: "4/3"; expected text of the form'),
        ({"confirm": "2/4"}, "more than half"),
        ({"bias": ["tilt"]}, "expected some of translation"),
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
