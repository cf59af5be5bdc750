"""The commands ``serve`` and ``replay``."""

import logging
import sys
import tempfile
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trackweave.cli.edge import Voice
from trackweave.errors import InvalidInputError

if TYPE_CHECKING:
    from trackweave.service.inputs.source import Source
    from trackweave.service.web.settings import Tls, WebSettings

__all__ = ["run_replay", "run_serve"]

_LIBRARIES = ("starlette", "uvicorn", "websockets")


def run_serve(
    voice: Voice,
    data: Path | None,
    page: str,
    *,
    demo: bool,
    config: Path | None,
    learned: Path | None,
    listen: Sequence[str],
    publish: Sequence[str],
    access: dict[str, Any],
    keep: tuple[float | None, float | None],
    engine: str | None,
    workers: int | None,
    seed: int,
) -> None:
    """Serve until SIGTERM or an interrupt."""
    try:
        from trackweave.service.running import Plan, run_service
    except ImportError as err:
        if err.name is None or err.name.partition(".")[0] not in _LIBRARIES:
            raise
        raise InvalidInputError(
            f"serve needs {err.name}; pip install 'trackweave[service]', or '.[service]' in a "
            "checkout"
        ) from err
    from trackweave.engine import require_engine
    from trackweave.service.inputs.source import source_of
    from trackweave.service.journal import Retention
    from trackweave.service.publish import target_of

    if engine is not None:
        require_engine(engine, workers)
    elif workers is not None:
        raise InvalidInputError(f"--workers {workers}; expected --engine as well")
    host, port = _address(page)
    web, tls = _access(access)
    for note in web.tokens.notes if web.tokens else ():
        voice.say(f"note: {note}")
    urls, passing = list(listen), None
    _log_to_stderr(quiet=voice.quiet)
    with ExitStack() as stack:
        plan_config: Any = config
        if demo:
            from trackweave.service.demonstration import demonstration

            if config is not None or learned is not None:
                name = "--learned" if config is None else "--config"
                raise InvalidInputError(f"--demo and {name}; expected one of them")
            passing = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="trackweave-")))
            url, plan_config = demonstration(passing, seed)
            urls.append(url)
            data = passing / "service" if data is None else data
        sources = [source_of(url) for url in urls]
        missing = [each for each in sources if each.path and not Path(each.path).exists()]
        if missing:
            raise InvalidInputError(
                f"--listen {missing[0].url!r:.100}: no such file; expected a recording"
            )
        _require_own_machine(sources, open_inputs=access["open_inputs"])
        plan = Plan(
            folder=data or Path("trackweave-service"),
            config=plan_config,
            learned=learned,
            sources=sources,
            targets=[target_of(url) for url in publish],
            host=host,
            port=port,
            web=web,
            tls=tls,
            retention=Retention(
                None if keep[0] is None else int(keep[0] * 1e9),
                None if keep[1] is None else keep[1] * 3600.0,
            ),
            passing=passing,
            engine=engine,
            workers=workers,
        )
        run_service(plan, voice.say)


def run_replay(voice: Voice, directory: Path, out: Path) -> dict[str, Any]:
    """Repeat a service's run from its journal; return what it held."""
    from trackweave.service.repeating import repeated

    if not (directory / "journal").is_dir():
        raise InvalidInputError(f"{directory}: no journal in it; expected the --data of a service")
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise InvalidInputError(f"{out}: there already; expected a new or empty directory")
    found = repeated(directory, out)
    if found.first > 1:
        voice.say(
            f"{directory}: records before {found.first} were forgotten; tracks begin with it"
        )
    counts = found.engine.counts
    result = {
        "first_record": found.first,
        "last_record": found.last,
        "reports": counts.reports,
        "scans": counts.scans,
        "late_reports": counts.late,
        "tracks_files": found.parts,
        "out": str(out),
    }
    voice.results("Replayed", result)
    return result


def _address(page: str) -> tuple[str, int]:
    host, colon, port = page.rpartition(":")
    if not colon or not port.isdecimal() or int(port) > 65_535:
        raise InvalidInputError(f"--page {page!r:.80}: expected HOST:PORT, such as 127.0.0.1:8700")
    return host.removeprefix("[").removesuffix("]"), int(port)


def _access(told: dict[str, Any]) -> "tuple[WebSettings, Tls | None]":
    from trackweave.service.web.settings import Tls, WebSettings
    from trackweave.service.web.tokens import read_tokens

    certificate, key = told["certificate"], told["key"]
    if (certificate is None) != (key is None):
        raise InvalidInputError("--certificate and --key: one of them; expected both or none")
    tls = None if certificate is None else Tls(certificate, key)
    tokens = None if told["token_file"] is None else read_tokens(told["token_file"])
    origins = tuple(told["origin"])
    web = WebSettings(
        tokens=tokens,
        origins=origins,
        proxies=tuple(told["proxy"]),
        is_encrypted=tls is not None or any(each.startswith("https:") for each in origins),
        tiles=told["tiles"],
        attribution=told["attribution"],
    )
    return web, tls


def _require_own_machine(sources: "Sequence[Source]", *, open_inputs: bool) -> None:
    """Refuse inputs that anybody can reach, unless the user says that this is meant."""
    from trackweave.service.addresses import is_loopback

    for source in sources:
        is_open = source.port and not source.connect and not is_loopback(source.host)
        if is_open and not open_inputs:
            raise InvalidInputError(
                f"--listen {source.url!r:.100}: reached from other machines, and nobody checks "
                "who sends there; expected an address of this machine, such as 127.0.0.1, or "
                "--open-inputs where the network is trusted"
            )


def _log_to_stderr(*, quiet: bool) -> None:
    from trackweave.service.log import LogLine

    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(LogLine())
    logger = logging.getLogger("trackweave")
    logger.addHandler(handler)
    logger.setLevel(logging.ERROR if quiet else logging.INFO)
