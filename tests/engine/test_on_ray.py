"""What only Ray shows: engines that join one another, and its quiet."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

from oracles import errands
from trackweave.engine import EngineError, engine_of

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
