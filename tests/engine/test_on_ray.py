"""What only Ray shows: engines that join one another, and its quiet."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from oracles import errands
from trackweave.engine import EngineError, engine_of
from trackweave.engine.protocol import Death

needs_ray = pytest.mark.skipif(importlib.util.find_spec("ray") is None, reason="Ray is missing")


def test_a_folder_called_ray_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ray", ModuleType("ray"))
    monkeypatch.delitem(sys.modules, "trackweave.engine.on_ray", raising=False)
    with pytest.raises(EngineError, match=r"pip install 'trackweave\[ray\]'"):
        engine_of("ray")


@needs_ray
@pytest.mark.slow
def test_engines_that_share_a_connection_keep_it_until_the_last_is_closed() -> None:
    first = engine_of("ray", 1)
    second = engine_of("ray", 1)
    first.close()
    second.submit(errands.square, 3)
    assert [each.value for each in second.gather()] == [9]
    second.close()
    import ray

    assert not ray.is_initialized()


@needs_ray
@pytest.mark.slow
def test_deaths_leave_standard_output_to_results(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with engine_of("ray", 1) as engine:
        engine.submit(errands.fall_first, tmp_path, 0, 2)
        engine.submit(errands.late_square, 3, 2.0)
        assert [each.value for each in engine.gather()] == [0, 9]
    assert capfd.readouterr().out == ""


class Refusing:
    """What Ray gives of an actor, without room for anything."""

    def remote(self, *_: object) -> None:
        import ray

        raise ray.exceptions.OutOfDiskError("Local disk is full")


@needs_ray
def test_a_full_object_store_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    import ray

    from trackweave.engine.on_ray import _Placed

    worker = _Placed.__new__(_Placed)
    worker._replies, worker._room = [], SimpleNamespace(serve=Refusing())
    with pytest.raises(EngineError, match=r"no room for a task of 3 MB: .* are full here"):
        worker.send(bytes(3_000_000))
    monkeypatch.setattr(ray, "get", Refusing().remote)
    death = worker.heard(None)
    assert isinstance(death, Death)
    assert death.reason == "had no room for its reply: Ray's object store and its disk are full"


@needs_ray
def test_a_machine_with_another_trackweave_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    import ray

    from trackweave.engine import on_ray

    here = {"node": on_ray._own_version(), "lost": ray.exceptions.NodeDiedError("it is gone")}
    nodes: list[dict[str, Any]] = [
        {"Alive": True, "NodeID": f"{number:056x}", "NodeManagerAddress": name,
         "Resources": {} if name == "head" else {"CPU": 1.0}}
        for number, name in enumerate(("head", "node", "lost", "other"))
    ]  # fmt: skip

    def remote(*, scheduling_strategy: Any, **_: object) -> Any:
        name = nodes[int(scheduling_strategy.node_id, 16)]["NodeManagerAddress"]
        return lambda _: SimpleNamespace(remote=lambda: name)

    def get(name: str, **_: object) -> str:
        found = here[name]
        if isinstance(found, Exception):
            raise found
        return found

    monkeypatch.setattr(ray, "nodes", lambda: nodes)
    monkeypatch.setattr(ray, "remote", remote)
    monkeypatch.setattr(ray, "get", get)
    here["other"] = here["node"]
    on_ray._require_alike("ray://HEAD")
    here["other"] = "0.0.1"
    with pytest.raises(EngineError, match=r"machine other has trackweave 0\.0\.1; expected"):
        on_ray._require_alike("ray://HEAD")
    here["other"] = ray.exceptions.RayError("no module named trackweave\n\nadvice")
    with pytest.raises(EngineError, match=r"no trackweave that starts \(no module named trackwea"):
        on_ray._require_alike("ray://HEAD")


@needs_ray
def test_both_of_two_versions_of_ray_are_told() -> None:
    from trackweave.engine.on_ray import _in_a_line

    err = RuntimeError("Version mismatch: it has:\n    Ray: 2.59.0\nThis has:\n    Ray: 2.60.0")
    assert _in_a_line(err) == "Version mismatch: it has: Ray: 2.59.0 This has: Ray: 2.60.0"
