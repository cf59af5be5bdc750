"""A run in one page that needs no server and no network."""

import base64
import gzip
import hashlib
import html
import json
from typing import Any

from trackweave.io.run_files import RunFiles
from trackweave.plotting.scene import ScanSeries, Scene
from trackweave.service.picture.bundle import bundled, file_of_page
from trackweave.service.picture.content import content_of_run

__all__ = ["page_of_run"]

_PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="dark light">
<meta name="generator" content="trackweave">
<title>{title}</title>
<link rel="icon" href="data:,">
<style>{style}</style>
</head>
<body>
<div id="page" class="page"><p class="waiting">This page needs JavaScript.</p></div>
<script type="application/octet-stream" id="run">{data}</script>
<script type="module">{script}</script>
</body>
</html>
"""


def page_of_run(run: RunFiles, scene: Scene, scans: ScanSeries, title: str) -> bytes:
    """Return a run as a page of HTML, the same bytes for the same run.

    Everything lies in the page; its policy forbids it to fetch anything. What strangers named is
    in it compressed and in base 64, and shown as text alone.

    Parameters
    ----------
    run
        The run's files.
    scene
        What is to be seen of them.
    scans
        What each scan left behind.
    title
        The page's heading.

    Returns
    -------
    The page, in UTF-8.
    """
    content = content_of_run(run, scene, scans)
    script, style = bundled("picture.js"), file_of_page("page.css")
    policy = (
        f"default-src 'none'; script-src {_hash_of(script)}; style-src {_hash_of(style)}; "
        "img-src data:; base-uri 'none'; form-action 'none'"
    )
    page = _PAGE.format(
        policy=policy,
        title=html.escape(f"{_shown(title)} – trackweave"),
        style=style,
        data=_packed({"title": title, **content}),
        script=script,
    )
    return page.encode("utf-8")


def _hash_of(text: str) -> str:
    digest = hashlib.sha256(text.encode("utf-8")).digest()
    return f"'sha256-{base64.b64encode(digest).decode('ascii')}'"


def _shown(text: str) -> str:
    """Return text without what does not show, and what turns the direction of writing."""
    return "".join(letter if letter.isprintable() else "·" for letter in text)


def _packed(content: dict[str, Any]) -> str:
    text = json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    # Names of files may hold bytes that are no text.
    raw = gzip.compress(text.encode("utf-8", "replace"), compresslevel=9, mtime=0)
    return base64.b64encode(raw).decode("ascii")
