"""Bodies in a process of their own: what breaks it breaks one answer."""

import asyncio
import multiprocessing
import os
import signal
from collections.abc import Iterator
from contextlib import suppress
from io import BytesIO

import polars as pl
import pytest

from trackweave.errors import InvalidInputError
from trackweave.service.web.bodies import MOST_REJECTED, decoded
from trackweave.service.web.decoding import DecodingProcess, _work

LINE = b'{"time": 1, "x": 2, "y": 3}\n'


@pytest.fixture
def decoding() -> Iterator[DecodingProcess]:
    found = DecodingProcess(seconds=60, room=1 << 28)
    yield found
    found.close()


def test_what_another_process_decodes_is_the_same(decoding: DecodingProcess) -> None:
    body = LINE * 3 + b"nonsense\n" + LINE
    here, there = decoded(body, None), asyncio.run(decoding.decode(body, None))
    assert there.table.equals(here.table)
    assert there.row.tolist() == here.row.tolist() == [1, 2, 3, 5]
    assert there.rejected == here.rejected


def test_a_process_that_is_killed_is_followed_by_another(decoding: DecodingProcess) -> None:
    async def carry_out() -> int:
        await decoding.decode(LINE, None)
        os.kill(decoding._process.pid, signal.SIGKILL)
        with suppress(InvalidInputError):
            await decoding.decode(LINE, None)
        return len((await decoding.decode(LINE, None)).table)

    assert asyncio.run(carry_out()) == 1


def test_it_ends_without_a_traceback_where_the_service_was_killed() -> None:
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_work, args=(theirs, 1 << 28))
    process.start()
    theirs.close()
    ours.close()
    process.join(120)
    assert process.exitcode == 0  # 1 after a traceback


def test_a_body_that_takes_too_long_is_given_up() -> None:
    decoding = DecodingProcess(seconds=0.5)

    async def carry_out() -> None:
        await decoding.decode(b"", None)
        with pytest.raises(InvalidInputError, match="to decode; expected less at a time"):
            await decoding.decode(LINE * 1_000_000, "jsonl")

    asyncio.run(carry_out())
    decoding.close()


def test_a_body_that_unpacks_to_more_than_there_is_room_for_is_refused(
    decoding: DecodingProcess,
) -> None:
    packed = BytesIO()
    pl.select(time=pl.repeat(0.0, 50_000_000), x=pl.repeat(1.0, 50_000_000)).write_parquet(packed)
    assert len(packed.getvalue()) < 1 << 20  # 800 MB in the end
    with pytest.raises(InvalidInputError, match="body: "):
        asyncio.run(decoding.decode(packed.getvalue(), "parquet"))
    assert len(asyncio.run(decoding.decode(LINE, None)).table) == 1


def test_a_body_too_many_is_refused_once_the_process_is_closed() -> None:
    decoding = DecodingProcess()
    decoding.close()
    decoding.close()
    with pytest.raises((InvalidInputError, RuntimeError)):
        asyncio.run(decoding.decode(LINE, None))


def test_rejected_reports_are_all_counted_and_the_first_are_listed() -> None:
    found = decoded(b"{}\n" * 5000, "jsonl")
    assert found.rejected_count == 5000
    assert [each.row for each in found.rejected] == list(range(1, MOST_REJECTED + 1))


@pytest.mark.parametrize("told", ["asterix", "ais", "sbs", "opensky", "readsb", "csv", "jsonl"])
def test_no_bytes_do_more_than_be_refused(told: str) -> None:
    import numpy as np

    rng = np.random.default_rng(1)
    for size in (1, 10, 1000, 20_000):
        try:
            decoded(rng.integers(0, 256, size, dtype=np.uint8).tobytes(), told)
        except InvalidInputError as err:
            assert str(err)
