"""With nothing told, a feed alone is enough: its radar says where it is, its plots the rest."""

from collections.abc import Iterable

import numpy as np
import polars as pl
import pytest

from run.turning_radar import on_a_plane, radar
from service.asterix import PERIOD, PLACE, traffic
from service.recordings import positions
from trackweave.config import load_configuration
from trackweave.errors import InvalidInputError
from trackweave.formats.asterix.decoding import AsterixDecoder
from trackweave.service.engine import Engine
from trackweave.service.inputs.outbox import completed
from trackweave.service.learning import is_enough, learned, waiting_for
from trackweave.service.records import Kind, packed_reports

Payloads = list[bytes]


def payloads_of(messages: Iterable[bytes]) -> Payloads:
    """Return what an input hands on of a feed."""
    decoder, found = AsterixDecoder(), []
    for message in messages:
        table = decoder.feed(message)
        if table is not None:
            found.append(packed_reports(completed(table), "udp", decoder.facts))
    return found


def engine_of(payloads: Payloads) -> Engine:
    engine = Engine()
    for payload in payloads:
        engine.take(engine.sequence + 1, Kind.REPORTS, payload)
    return engine


@pytest.mark.slow
def test_a_radars_place_and_turn_come_from_its_own_feed() -> None:
    engine = engine_of(payloads_of(traffic()))
    found = learned(load_configuration(None), engine.heard, engine.facts)
    assert found is not None
    (name,) = found.spec.configuration["sensors"]
    sensor = found.spec.configuration["sensors"][name]
    assert found.spec.frame is not None
    here = found.spec.frame.to_geodetic(np.array([sensor["position"][:2]]))
    assert np.allclose([here[0][0], here[1][0]], PLACE[:2], atol=1e-4)
    assert sensor["measurement"] == "range-azimuth"
    assert sensor["rotation"] == "clockwise"
    assert sensor["scan_period"] == pytest.approx(PERIOD, rel=1e-3)
    engine.take(engine.sequence + 1, Kind.CONFIGURE, found.spec.payload())
    tracks = engine.tracks()
    assert 17 <= int(np.sum(tracks.status == 1)) <= 23


def test_too_little_is_waited_on() -> None:
    engine = engine_of(payloads_of(traffic())[:60])
    assert learned(load_configuration(None), engine.heard, engine.facts) is None


def test_keys_that_are_left_out_are_named_while_reports_are_waited_for() -> None:
    _, told = positions()
    engine = engine_of(payloads_of(traffic())[:60])
    (name,) = engine.heard[0].table["sensor"].unique().to_list()
    own = {"sigma": {"range_m": 60.0, "azimuth_deg": 0.08}, "scan_period": 5.0}
    own |= {"detection_probability": 0.9, "clutter_per_scan": 1.0}
    configuration = load_configuration(
        {"motion": told["motion"], "lifecycle": told["lifecycle"], "sensors": {name: own}}
    )
    said = waiting_for(configuration, engine.heard)
    assert said.endswith(
        f": sensors.{name}.clutter_density (clutter_per_scan says it only with a field_of_view)"
    )
    assert said.startswith(f"{sum(each.table.height for each in engine.heard)} reports of ")
    own["field_of_view"] = {"max_range_m": 100_000.0}
    configuration = load_configuration({**configuration.values, "sensors": {name: own}})
    assert "complete" in waiting_for(configuration, engine.heard)


def test_of_many_who_name_themselves_some_have_to_be_heard_often() -> None:
    time = np.sort(np.random.default_rng(1).uniform(0.0, 60.0, 300))
    seldom = pl.DataFrame({"time": time, "sensor": "udp", "x": 1e3 * time, "y": 5.0 * time})
    seldom = seldom.with_columns(identity=pl.Series(np.arange(300) % 150).cast(pl.String))
    often = seldom.with_columns(identity=pl.Series(np.arange(300) % 20).cast(pl.String))
    configuration, said = load_configuration(None), {}
    for name, frame in (("seldom", seldom), ("often", often)):
        heard = engine_of([packed_reports(frame, "udp", engine_facts())]).heard
        assert is_enough(heard, engine_facts()) is (name == "often")
        said[name] = waiting_for(configuration, heard)
    assert "of identities that were heard 6 times each" in said["seldom"]
    assert "identities" not in said["often"]


def test_nothing_told_is_all_named_in_one_sentence() -> None:
    said = waiting_for(load_configuration(None), ())
    assert said.startswith("no report yet; 200 over 30 s")
    assert "motion.process_noise" in said
    assert said.endswith("more keys")


def test_a_complete_configuration_waits_for_the_first_report_alone() -> None:
    _, configuration = positions()
    said = waiting_for(load_configuration(configuration), ())
    assert said.startswith("no report yet; the configuration is complete")


def test_a_complete_configuration_needs_one_report() -> None:
    frame, configuration = positions()
    engine = engine_of([packed_reports(frame[:1], "test", engine_facts())])
    found = learned(load_configuration(configuration), engine.heard, engine.facts)
    assert found is not None
    # Sensors that were told and not heard yet are known too.
    assert set(found.spec.configuration["sensors"]) == set(configuration["sensors"])


@pytest.mark.slow
@pytest.mark.parametrize("is_told", [True, False])
def test_positions_of_a_radar_whose_place_is_told_are_ranges_and_azimuths(is_told: bool) -> None:
    frame = on_a_plane(radar(), 40e3, 10e3).drop("target").with_columns(sensor=pl.lit("radar"))
    told = {"position": [40e3, 10e3], **({"measurement": "range-azimuth"} if is_told else {})}
    engine = engine_of([packed_reports(frame, "test", engine_facts())])
    configuration = load_configuration({"sensors": {"radar": told}})
    found = learned(configuration, engine.heard, engine.facts)
    assert found is not None
    sensor = found.spec.configuration["sensors"]["radar"]
    assert sensor["measurement"] == "range-azimuth"
    assert sensor["sigma"]["range_m"] == pytest.approx(60, rel=0.15)
    engine.take(engine.sequence + 1, Kind.CONFIGURE, found.spec.payload())
    assert engine.tracks().track.size == 12


@pytest.mark.parametrize(
    "row", [{"bearing_deg": 3.0}, {"range_m": 900.0, "azimuth_deg": 3.0}, {"x": 1.0}]
)
def test_nobody_waits_for_what_a_sensor_lacks_that_is_hardly_heard(row: dict[str, float]) -> None:
    frame, configuration = positions()
    one = pl.DataFrame({"time": [1.0], "sensor": ["evil"], **{k: [v] for k, v in row.items()}})
    heard = [packed_reports(part, "test", engine_facts()) for part in (one, frame[:600])]
    engine = engine_of(heard)
    found = learned(load_configuration(configuration), engine.heard, engine.facts)
    assert found is not None
    assert set(found.spec.configuration["sensors"]) == set(configuration["sensors"])
    if "x" not in row:
        assert "left out, as hardly heard: sensor evil; " in found.notes[0]


@pytest.mark.slow
def test_what_only_a_person_knows_is_asked_for() -> None:
    quiet = [message for message in traffic() if message[0] == 48]
    engine = engine_of(payloads_of(quiet))
    others = [message.replace(b"\x19\x0b", b"\x19\x0c", 1) for message in quiet]
    for payload in payloads_of(others):
        engine.take(engine.sequence + 1, Kind.REPORTS, payload)
    with pytest.raises(InvalidInputError, match=r"sensors\..*position"):
        learned(load_configuration(None), engine.heard, engine.facts)


def engine_facts():  # type: ignore[no-untyped-def]
    from trackweave.domain.facts import Facts

    return Facts()
