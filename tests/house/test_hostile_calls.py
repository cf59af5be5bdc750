"""Whatever public functions and constructors are given, only our own errors come out."""

import inspect

import pytest

import trackweave
from oracles.hostile import Call, constructors, functions, numpy_twins, outcome, same
from trackweave.errors import InvalidInputError

CALLS = {call.name: call for call in [*constructors(), *functions()]}
# Made by the library, or told apart from the others elsewhere.
NOT_CALLED = {
    "Amendment", "Answer", "Association", "BoxFrame", "BoxTrack", "Certificate", "Evaluation",
    "FoundObjects",
    "FusedPicture", "FusionResult", "HeldScan", "Hint", "Hypothesis", "LocalTracks",
    "Measurement", "MeasurementKind", "MotionModel", "Ranking", "Registration", "ReportTable",
    "Reported", "Status", "StudyResult", "TrackingResult", "TruthTable", "TuningResult",
    "__version__", "study", "track", "tune",
}  # fmt: skip


@pytest.fixture(params=CALLS.values(), ids=CALLS.keys())
def call(request: pytest.FixtureRequest) -> Call:
    return request.param


def test_everything_public_is_called_or_named_as_an_exception() -> None:
    called = {name.partition(".")[0].removesuffix("()") for name in CALLS}
    errors = {
        name
        for name in trackweave.__all__
        if inspect.isclass(value := getattr(trackweave, name)) and issubclass(value, Exception)
    }
    assert set(trackweave.__all__) - called - errors <= NOT_CALLED


def test_only_our_own_errors_come_out(call: Call) -> None:
    foreign = [
        f"{argument} = {label}: {error!r}"
        for argument, label, arguments in call.with_one_replaced()
        if (error := outcome(call.call, arguments)) is not None
    ]
    assert foreign == []


def test_numpy_numbers_lists_and_tuples_are_taken_as_what_they_stand_for(call: Call) -> None:
    wanted = call.call(**call.arguments)
    for argument, value in call.arguments.items():
        for twin in numpy_twins(value):
            found = call.call(**{**call.arguments, argument: twin})
            if hasattr(type(wanted), "__dataclass_fields__"):
                assert same(found, wanted), f"{argument} = {twin!r}"


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: trackweave.Sensor("a", sigma="5"),
            "sigma: '5'; expected a finite number or a sequence, each entry a finite number",
        ),
        (
            lambda: trackweave.FieldOfView(azimuth_deg=90),
            r"azimuth_deg: 90; expected \(a finite number, a finite number\)",
        ),
        (lambda: trackweave.Window(depth=2.5), "depth: 2.5; expected a whole number"),
        (
            lambda: trackweave.BiasModel(prior={1: 2.0}),
            "prior: {1: 2.0}; expected a mapping from names, each to a finite number",
        ),
        (
            lambda: trackweave.TrackFuser("A"),
            "associator: 'A'; expected a TrackAssociator",
        ),
        (
            lambda: trackweave.Sensor("a", scan_period=True),
            "scan_period: True; expected a number > 0 in seconds or None",
        ),
    ],
)
def test_a_message_names_what_came_and_what_was_expected(make, message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        make()
