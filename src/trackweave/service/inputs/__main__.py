"""The process of one input: bytes in from the network, tables out to the service."""

import json
import os
import select
import signal
import sys
from collections.abc import Callable

from trackweave.errors import TrackweaveError
from trackweave.formats.format import Decoder
from trackweave.formats.reading import chosen
from trackweave.service.inputs.outbox import SOON, Outbox
from trackweave.service.inputs.recordings import replay
from trackweave.service.inputs.sockets import CHUNK, Feed, listen_tcp, listen_udp, visit_tcp
from trackweave.service.inputs.source import Source, source_of


def main() -> None:
    """Serve the input that the command line names, until its end or that of the service."""
    # Who interrupts the service from the keyboard means the service: it ends its inputs.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    source = source_of(json.loads(sys.argv[1]))
    # What else would be printed, as by a library, is not taken for reports.
    handle = os.dup(1)
    os.dup2(2, 1)
    outbox = Outbox(handle, source.scheme, source.sensor)
    outbox.patient = source.scheme in ("replay", "stdin")
    try:
        _serve(source, outbox)
    except (TrackweaveError, OSError) as err:
        outbox.message = str(err)[:300]
    outbox.close()


def _serve(source: Source, outbox: Outbox) -> None:
    make = _maker(source)
    if source.scheme == "replay":
        replay(source, outbox)
    elif source.scheme == "stdin":
        _read_all(make, outbox)
    elif source.scheme == "ws":
        from trackweave.service.inputs.websocket import listen_ws

        listen_ws(source, make, outbox)
    elif source.scheme == "udp":
        listen_udp(source, make, outbox)
    elif source.connect:
        visit_tcp(source, make, outbox)
    else:
        listen_tcp(source, make, outbox)


def _read_all(make: Callable[[], Decoder], outbox: Outbox) -> None:
    feed = Feed(make, outbox)
    while True:
        if not select.select([0], [], [], SOON)[0]:
            outbox.flush()
            continue
        data = os.read(0, CHUNK)
        if not data:
            break
        feed.take(data)
    feed.end()


def _maker(source: Source) -> Callable[[], Decoder]:
    def make() -> Decoder:
        assert source.told is not None
        found, settings = chosen(source.told)
        assert found.decoder is not None
        return found.decoder(**settings)

    return make


main()
