"""All routes as one ASGI application."""

from collections.abc import Mapping
from importlib.metadata import version

from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import Receive, Scope, Send

from trackweave.service.desk import Desk
from trackweave.service.web.answers import DATA_HEADERS, answer, refusal
from trackweave.service.web.decoding import DecodingProcess
from trackweave.service.web.entrance import Entrance
from trackweave.service.web.files import Asset, PageFiles, page_assets
from trackweave.service.web.guard import Guard
from trackweave.service.web.login import LOGIN_PATHS, Login
from trackweave.service.web.metrics import CONTENT_TYPE, Sample, exposition, of_process, of_sensors
from trackweave.service.web.pictures import Pictures
from trackweave.service.web.posting import Posting
from trackweave.service.web.settings import WebSettings
from trackweave.service.web.stream import Stream
from trackweave.service.web.tally import Tally

__all__ = ["Application", "application"]


class Application:
    """The live service as it is reached over the network.

    Parameters
    ----------
    desk
        Where reports are handed in and pictures are asked for.
    settings
        Who is let in, and how much of anything anybody may have.
    assets
        The page's files by their paths; None for the package's.

    Attributes
    ----------
    settings
        As given.
    tally
        What was counted so far.
    """

    def __init__(
        self,
        desk: Desk,
        settings: WebSettings,
        assets: Mapping[str, Asset] | None = None,
    ) -> None:
        self.settings, self.tally = settings, Tally()
        self._desk = desk
        self._decoding = DecodingProcess()
        self._entrance = Entrance(settings)
        routes = Starlette(
            routes=[*self._routes(), *self._page_routes(assets)],
            exception_handlers={HTTPException: _without_route},
        )
        self._guard = Guard(
            routes, self._entrance, settings, self.tally, open_to_all=LOGIN_PATHS.__contains__
        )

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request."""
        await self._guard(scope, receive, send)

    async def start(self) -> None:
        """Be ready for the first reports, which otherwise wait for what decodes them."""
        await self._decoding.start()

    def close(self) -> None:
        """End what decodes reports."""
        self._decoding.close()

    def _routes(self) -> list[Route | WebSocketRoute]:
        limits = self.settings.limits
        posting = Posting(self._desk, self._decoding, limits, self.tally)
        pictures = Pictures(self._desk)
        stream = Stream(self._desk, self._entrance, limits, self.tally)

        async def post(request: Request) -> Response:
            return await posting(request)

        return [
            Route("/reports", post, methods=["POST"]),
            Route("/reports", _only_posted),
            Route("/tracks", pictures.tracks),
            Route("/tracks/{identifier}", pictures.track),
            Route("/sensors", self._sensors),
            Route("/healthz", self._health),
            Route("/metrics", self._metrics),
            WebSocketRoute("/stream", stream.__call__),
        ]

    def _page_routes(self, assets: Mapping[str, Asset] | None) -> list[Route]:
        login = Login(self._entrance, self.settings)
        files = PageFiles(page_assets() if assets is None else assets, self.settings)

        async def file(request: Request) -> Response:
            return await files(request)

        return [
            Route("/login", login.form, methods=["GET"]),
            Route("/login", login.enter, methods=["POST"]),
            Route("/login.css", login.style),
            Route("/logout", login.leave, methods=["POST"]),
            Route("/logout", _only_posted),
            Route("/page.json", self._page),
            Route("/{path:path}", file),
        ]

    async def _sensors(self, _: Request) -> Response:
        return answer(self._desk.sensors())

    async def _health(self, _: Request) -> Response:
        found = self._desk.health()
        is_well = found.get("status") != "failing" and found.get("listening", True)
        return answer(found, 200 if is_well else 503)

    async def _metrics(self, _: Request) -> Response:
        counted: list[Sample] = [(n, {}, value) for n, value in self._desk.counters().items()]
        samples = [*counted, *of_sensors(self._desk.sensors()), *self.tally, *of_process()]
        return Response(
            exposition(samples), headers={**DATA_HEADERS, "content-type": CONTENT_TYPE}
        )

    async def _page(self, _: Request) -> Response:
        return answer(
            {
                "tiles": self.settings.tiles,
                "attribution": self.settings.attribution,
                "login": self.settings.tokens is not None,
                "version": version("trackweave"),
            }
        )


def application(desk: Desk, settings: WebSettings) -> Application:
    """Return the live service as an ASGI application.

    Parameters
    ----------
    desk
        Where reports are handed in and pictures are asked for.
    settings
        Who is let in, and how much of anything anybody may have.

    Returns
    -------
    What ``server`` lets be reached.
    """
    return Application(desk, settings)


async def _only_posted(_: Request) -> Response:
    # The page's files are at every path: without this, what is asked for there is "nothing here".
    raise HTTPException(405, headers={"Allow": "POST"})


async def _without_route(_: Request, err: Exception) -> Response:
    status = err.status_code if isinstance(err, HTTPException) else 500
    said = {404: "nothing here", 405: "not in this way"}.get(status, "failed")
    headers = dict(err.headers or {}) if isinstance(err, HTTPException) else {}
    return refusal(status, said, **{n.lower().replace("-", "_"): v for n, v in headers.items()})
