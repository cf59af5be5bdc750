"""The options of ``serve`` and ``replay``."""

from pathlib import Path
from typing import Annotated

import typer

from trackweave.cli.edge import carry_out, done_by, with_status
from trackweave.cli.options import JsonOption, OutOption, QuietOption, required
from trackweave.cli.signals import end_at_once

__all__ = ["replay", "serve"]


@with_status
def serve(
    demo: Annotated[
        bool, typer.Option("--demo", help="Feed itself with simulated radars and boats.")
    ] = False,
    config: Annotated[
        Path | None,
        typer.Option(
            "--config",
            "-c",
            help="tracker.toml; what it leaves out is estimated from what is heard.",
        ),
    ] = None,
    learned: Annotated[
        Path | None,
        typer.Option(help="What `init --learn` wrote; it counts where --config is silent."),
    ] = None,
    listen: Annotated[
        list[str],
        typer.Option(
            help="Where reports come from, one or several: udp://HOST:PORT?format=…, tcp://, "
            "ws://, stdin:?format=…, replay:FILE?speed=10."
        ),
    ] = [],  # noqa: B006 typer makes a new list of it
    publish: Annotated[
        list[str],
        typer.Option(help="Where tracks go: udp://HOST:PORT?format=cot, tcp://, …"),
    ] = [],  # noqa: B006
    page: Annotated[
        str, typer.Option(help="Where the page and POST /reports are; port 0 for a free one.")
    ] = "127.0.0.1:8700",
    data: Annotated[
        Path | None,
        typer.Option(
            help="Directory of journal, snapshots and tracks; trackweave-service unless given."
        ),
    ] = None,
    token_file: Annotated[
        Path | None, typer.Option(help="File of tokens: every request needs one of them.")
    ] = None,
    certificate: Annotated[Path | None, typer.Option(help="TLS certificate in PEM.")] = None,
    key: Annotated[Path | None, typer.Option(help="Its key in PEM.")] = None,
    origin: Annotated[
        list[str], typer.Option(help="Another origin of the page, as behind a proxy.")
    ] = [],  # noqa: B006
    proxy: Annotated[
        list[str], typer.Option(help="Address or network of a proxy that is believed.")
    ] = [],  # noqa: B006
    tiles: Annotated[
        str | None, typer.Option(help="URL of map tiles with {z}, {x} and {y}.")
    ] = None,
    attribution: Annotated[str | None, typer.Option(help="What to say of their makers.")] = None,
    open_inputs: Annotated[
        bool,
        typer.Option("--open-inputs", help="Let other machines reach --listen, unchecked."),
    ] = False,
    keep_gb: Annotated[
        float | None, typer.Option(min=0.001, help="Journal kept at most [GB]; else all of it.")
    ] = None,
    keep_hours: Annotated[
        float | None, typer.Option(min=0.01, help="Journal kept for so long [h]; else for ever.")
    ] = None,
    engine: Annotated[
        str | None,
        typer.Option(
            help="Track regions of the plane on workers, two for each: local, ray, or ray://HOST."
        ),
    ] = None,
    workers: Annotated[
        int | None, typer.Option(help="Regions at most; as many as there are processors here.")
    ] = None,
    quiet: QuietOption = False,
) -> None:
    """Run the live service: reports in over the network, tracks out, a page with a live map.

    `serve --demo` shows moving tracks within ten seconds. SIGTERM ends it within two seconds,
    SIGHUP reads --config again. What POST /reports has acknowledged is on the disk.
    """
    from trackweave.cli.serve import run_serve

    access = {
        "token_file": token_file, "certificate": certificate, "key": key, "origin": origin,
        "proxy": proxy, "tiles": tiles, "attribution": attribution, "open_inputs": open_inputs,
    }  # fmt: skip
    carry_out(
        run_serve, json=False, quiet=quiet, data=data, page=page, demo=demo, config=config,
        learned=learned, listen=listen, publish=publish, access=access,
        keep=(keep_gb, keep_hours), engine=engine, workers=workers, seed=1,
    )  # fmt: skip
    end_at_once()


@done_by("serve.run_replay")
def replay(
    directory: Annotated[Path, required("DIR", "The --data of a service that does not run.")],
    out: OutOption,
    json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Make the tracks files of a service again, from its journal alone.

    The same bytes as the service's own, whatever was killed in between.
    """
