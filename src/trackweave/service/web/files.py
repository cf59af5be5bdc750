"""The page's files: read once, so that no path from outside ever reaches the file system."""

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.resources import files
from importlib.resources.abc import Traversable

from starlette.requests import Request
from starlette.responses import Response

from trackweave.service.web.answers import refusal
from trackweave.service.web.settings import WebSettings, origin_of

__all__ = ["Asset", "PageFiles", "page_assets", "policy"]

_TYPES = {
    "html": "text/html; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
    "mjs": "text/javascript; charset=utf-8",
    "css": "text/css; charset=utf-8",
    "json": "application/json",
    "geojson": "application/geo+json",
    "txt": "text/plain; charset=utf-8",
    "md": "text/plain; charset=utf-8",
    "svg": "image/svg+xml",
    "png": "image/png",
    "ico": "image/x-icon",
    "webp": "image/webp",
    "woff2": "font/woff2",
    "bin": "application/octet-stream",
    "webmanifest": "application/manifest+json",
}


@dataclass(frozen=True, slots=True)
class Asset:
    """A file of the page.

    Parameters
    ----------
    data
        What it holds.
    kind
        Its media type.
    tag
        Its entity tag, of what it holds.
    """

    data: bytes
    kind: str
    tag: str


def page_assets(folder: Traversable | None = None) -> dict[str, Asset]:
    """Return the page's files by the paths at which browsers ask for them.

    Parameters
    ----------
    folder
        Where they lie; None for the package's.

    Returns
    -------
    Files of known kinds; ``/`` is ``index.html``. None at all where there is no folder.
    """
    folder = files("trackweave.service") / "page" if folder is None else folder
    found = dict(_assets(folder, "")) if folder.is_dir() else {}
    return found | {"/": found["/index.html"]} if "/index.html" in found else found


def policy(settings: WebSettings) -> str:
    """Return what the page may do: fetch from its own origin, and that of the tiles."""
    tiles = origin_of(settings.tiles) if settings.tiles else None
    images = f"'self' data: blob: {tiles}" if tiles else "'self' data: blob:"
    return (
        f"default-src 'none'; script-src 'self'; style-src 'self'; img-src {images}; "
        "connect-src 'self'; font-src 'self'; worker-src 'self'; manifest-src 'self'; "
        "base-uri 'none'; form-action 'self'; frame-ancestors 'none'"
    )


class PageFiles:
    """Serves the page's files.

    Parameters
    ----------
    assets
        Files by their paths.
    settings
        What the page may fetch.
    """

    def __init__(self, assets: Mapping[str, Asset], settings: WebSettings) -> None:
        self._assets, self._policy = assets, policy(settings)

    async def __call__(self, request: Request) -> Response:
        """Answer with a file, where one has exactly that path."""
        asset = self._assets.get(request.scope["path"])
        if asset is None:
            return refusal(404, "nothing here")
        headers = {
            "content-security-policy": self._policy,
            "content-type": asset.kind,
            "cache-control": "no-cache",
            "etag": asset.tag,
        }
        if asset.tag in request.headers.get("if-none-match", ""):
            return Response(status_code=304, headers=headers)
        return Response(asset.data, headers=headers)


def _assets(folder: Traversable, before: str) -> Iterator[tuple[str, Asset]]:
    for entry in folder.iterdir():
        path = f"{before}/{entry.name}"
        kind = _TYPES.get(entry.name.rpartition(".")[2])
        if entry.is_dir() and not entry.name.startswith(("_", ".")):
            yield from _assets(entry, path)
        elif entry.is_file() and kind is not None and not entry.name.startswith("."):
            data = entry.read_bytes()
            yield path, Asset(data, kind, f'"{hashlib.sha256(data).hexdigest()[:20]}"')
