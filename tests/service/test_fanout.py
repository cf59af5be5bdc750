"""One message for many, none of whom makes another wait."""

import asyncio
import json
from typing import Any

import polars as pl

from oracles.serving import FRAME, tracks_table
from trackweave.service.desk import Picture
from trackweave.service.fanout import MOST_WAITING, Fanout


def heard(fanout: Fanout, count: int, act: Any = None) -> list[dict[str, Any]]:
    async def carry_out() -> list[dict[str, Any]]:
        listener = fanout.subscribe()
        found = [json.loads(await anext(listener))]
        if act is not None:
            act()
        found += [json.loads(await anext(listener)) for _ in range(count - 1)]
        listener.close()
        listener.close()
        assert [text async for text in listener] == []
        return found

    return asyncio.run(carry_out())


def test_who_comes_later_hears_the_last_of_everything_but_deltas() -> None:
    fanout = Fanout(lambda: Picture(7.0, tracks_table(2), FRAME))
    fanout.send({"type": "status", "load": 1})
    fanout.send({"type": "status", "load": 2})
    fanout.send({"type": "sensors", "sensors": []})
    fanout.tracks(6.0, tracks_table(1))
    found = heard(fanout, 3)
    assert (found[0]["time"], found[0]["full"], found[0]["geographic"]) == (7.0, True, True)
    assert found[1:] == [{"type": "status", "load": 2}, {"type": "sensors", "sensors": []}]
    assert len(fanout) == 0


def test_who_falls_behind_hears_a_full_picture_in_place_of_what_was_missed() -> None:
    fanout = Fanout(lambda: Picture(9.0, pl.DataFrame(), None))

    def publish() -> None:
        for k in range(3):
            fanout.send({"type": "long", "number": k, "text": "x" * (MOST_WAITING // 2)})
        fanout.send({"type": "dropped while behind"})

    found = heard(fanout, 3, publish)
    assert fanout.resynchronised == 1
    assert found[1]["full"]
    assert [each["type"] for each in found] == ["tracks", "tracks", "long"]
    assert found[2]["number"] == 2


def test_the_full_picture_is_made_once_until_tracks_change() -> None:
    asked = []
    fanout = Fanout(lambda: asked.append(1) or Picture(1.0, tracks_table(1), FRAME))
    assert fanout.full() is fanout.full()
    fanout.tracks(2.0, tracks_table(1))
    fanout.full()
    assert len(asked) == 2


def test_all_iterations_end_when_the_fanout_closes() -> None:
    async def carry_out() -> int:
        fanout = Fanout(lambda: Picture(None, pl.DataFrame(), None))
        listeners = [fanout.subscribe() for _ in range(3)]
        for each in listeners:
            await anext(each)
        waiting = [asyncio.ensure_future(anext(each, "end")) for each in listeners]
        await asyncio.sleep(0)
        fanout.close()
        assert await asyncio.gather(*waiting) == ["end"] * 3
        return len(fanout)

    assert asyncio.run(carry_out()) == 0
