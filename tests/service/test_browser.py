"""Both pages in a real browser, where there is one."""

import asyncio
import importlib
import shutil
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from cli.run_directory import write_run
from service.serving import Service
from trackweave.cli.edge import Voice
from trackweave.cli.plot import run_plot

CHROMIUM = shutil.which("chromium")
playwright = pytest.importorskip("playwright.sync_api")
pytestmark = [
    pytest.mark.skipif(CHROMIUM is None, reason="no chromium"),
    # The browser's driver closes its pipes when it is gone itself.
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
]
HOSTILE = "<img src=x onerror=hit()>"
REVERSING = "\u202e</script>"


class Watched:
    """A page of the browser, with what it complained of and what it asked for."""

    def __init__(self, context: Any) -> None:
        self.page = context.new_page()
        self.complaints: list[str] = []
        self.requests: list[str] = []
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("console", self._said)
        self.page.on("request", lambda request: self.requests.append(request.url))

    def _said(self, message: Any) -> None:
        # Drivers of graphics tell of their speed.
        if message.type == "error":
            self.complaints.append(message.text)

    def open(self, address: str) -> None:
        self.page.goto(address)
        self.wait("globalThis.trackweave?.map.instant.n > 0")

    def wait(self, condition: str) -> None:
        # Playwright's own waiting evaluates text in the page, which the page's policy forbids.
        for _ in range(600):
            if self.value(f"Boolean({condition})"):
                return
            self.page.wait_for_timeout(100)
        pytest.fail(f"never so: {condition}")

    def value(self, expression: str) -> Any:
        return self.page.evaluate(expression)


@pytest.fixture
def watched() -> Iterator[Watched]:
    with playwright.sync_playwright() as play:
        browser = play.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield Watched(browser.new_context(viewport={"width": 1200, "height": 800}))
        browser.close()


def picture(tmp_path: Path, **changes: Any) -> str:
    directory = write_run(tmp_path / "run", **changes)
    reports = (tmp_path / "reports.csv").read_text().splitlines()
    named = [f"{line},{HOSTILE if k else 'identity'}" for k, line in enumerate(reports)]
    (tmp_path / "reports.csv").write_text("\n".join(named) + "\n")
    out = tmp_path / "picture.html"
    run_plot(Voice(quiet=True), directory, out=out, reports=tmp_path / "reports.csv")
    return out.as_uri()


def test_a_picture_opens_as_a_file_and_asks_for_nothing(watched: Watched, tmp_path: Path) -> None:
    address = picture(tmp_path)
    watched.open(address)
    assert [url for url in watched.requests if not url.startswith("data:")] == [address]
    assert watched.complaints == []
    assert watched.value("trackweave.map.instant.n") == 2
    assert watched.value("trackweave.store.reports.n") == 12
    assert "2" in watched.page.locator(".list .hint").inner_text()


def test_a_picture_opens_where_most_tracks_are(watched: Watched, tmp_path: Path) -> None:
    directory = write_run(tmp_path / "run")
    for name in ("tracks.csv", "history.csv"):
        lines = (directory / name).read_text().splitlines()
        gone = [line for line in lines if line.startswith(("4,2,", "5,2,"))]
        (directory / name).write_text("\n".join(x for x in lines if x not in gone) + "\n")
    run_plot(Voice(quiet=True), directory, out=tmp_path / "picture.html")
    watched.open((tmp_path / "picture.html").as_uri())
    assert watched.value("trackweave.map.instant.n") == 2
    assert 2 <= watched.value("trackweave.map.time") < 4
    watched.page.keyboard.press("End")
    watched.wait("trackweave.map.instant.n === 1")


def test_time_goes_by_slider_and_keys(watched: Watched, tmp_path: Path) -> None:
    watched.open(picture(tmp_path))
    watched.page.keyboard.press("Home")
    watched.wait("trackweave.map.time === 0")
    assert watched.value("trackweave.map.instant.x[0]") == 0
    watched.page.keyboard.press("Space")
    watched.wait("trackweave.map.time > 0.1")
    watched.page.keyboard.press("End")
    watched.wait("trackweave.map.time === 5")
    assert watched.page.locator(".clock").inner_text() == "5.0 s"


def test_hovering_and_clicking_name_the_track_as_text(watched: Watched, tmp_path: Path) -> None:
    watched.open(picture(tmp_path))
    box = watched.page.locator(".map").bounding_box()
    at = watched.value("[trackweave.map.places.px[0], trackweave.map.places.py[0]]")
    watched.page.mouse.move(box["x"] + at[0] + 1, box["y"] + at[1] + 1)
    watched.wait("!document.querySelector('.tip').hidden")
    assert watched.page.locator(".tip strong").inner_text() == HOSTILE
    watched.page.mouse.click(box["x"] + at[0] + 1, box["y"] + at[1] + 1)
    watched.wait("!document.querySelector('.details').hidden")
    assert watched.page.locator(".details h2").inner_text() == HOSTILE
    watched.page.keyboard.press("Escape")
    watched.wait("document.querySelector('.details').hidden")
    assert watched.complaints == []  # of a function hit that nobody made
    assert watched.value("document.querySelectorAll('#page img:not(.sample)').length") == 0


def test_the_map_moves_by_wheel_drag_and_keys_and_comes_back(
    watched: Watched, tmp_path: Path
) -> None:
    watched.open(picture(tmp_path, geodetic=True))
    scale = watched.value("trackweave.map.view.scale")
    watched.page.mouse.move(400, 400)
    watched.page.mouse.wheel(0, -200)
    watched.wait(f"trackweave.map.view.scale > {1.2 * scale}")
    x = watched.value("trackweave.map.view.x")
    watched.page.mouse.down()
    watched.page.mouse.move(500, 400, steps=3)
    watched.page.mouse.up()
    assert watched.value("trackweave.map.view.x") < x
    watched.page.keyboard.press("0")
    assert abs(watched.value("trackweave.map.view.scale") / scale - 1) < 1e-6
    assert watched.complaints == []


def test_themes_and_colourings_change_by_keys(watched: Watched, tmp_path: Path) -> None:
    watched.open(picture(tmp_path))
    theme = watched.value("document.documentElement.dataset.theme")
    watched.page.keyboard.press("t")
    assert watched.value("document.documentElement.dataset.theme") != theme
    watched.page.keyboard.press("k")
    assert watched.value("trackweave.options.colour") == "status"
    watched.page.keyboard.press("?")
    assert watched.page.locator("dialog.help").is_visible()


def test_names_are_rid_of_what_does_not_show(watched: Watched, tmp_path: Path) -> None:
    watched.open(picture(tmp_path))
    watched.page.keyboard.press("Home")
    made = watched.value(
        """() => { const { list, map } = trackweave;
        map.instant.courses[0].label = "\\u202eab\\u200d\\n" + "x".repeat(99);
        list.refresh();
        return [...document.querySelectorAll(".row bdi")].map((name) => name.textContent); }"""
    )
    assert "·ab··" + "x" * 12 + "…" in made


@pytest.fixture
def aircraft(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[str, Any]]:
    """Serve aircraft from a thread of its own; yields the address and the desk."""
    pytest.importorskip("starlette")
    pytest.importorskip("uvicorn")
    pytest.importorskip("websockets")
    monkeypatch.setattr(sys, "path", [str(Path(__file__).parents[2] / "benchmarks"), *sys.path])
    desks = importlib.import_module("page_desk")
    desk = desks.AircraftDesk(40)
    desk.names[0] = f"{HOSTILE}{REVERSING}"
    found: dict[str, Any] = {}
    ready = threading.Event()

    async def serve() -> None:
        server = await desks.served(desk)
        found.update(url=server.url, loop=asyncio.get_running_loop(), end=asyncio.Event())
        ready.set()
        flying = asyncio.create_task(desk.fly())
        await found["end"].wait()
        flying.cancel()
        await server.stop()

    thread = threading.Thread(target=lambda: asyncio.run(serve()))
    thread.start()
    ready.wait(60)
    yield found["url"], desk
    found["loop"].call_soon_threadsafe(found["end"].set)
    thread.join(30)


@pytest.mark.slow
def test_the_live_page_follows_its_service(watched: Watched, aircraft: tuple[str, Any]) -> None:
    url, _ = aircraft
    watched.open(url)
    watched.wait("trackweave.map.instant.n === 40 && trackweave.map.rings")
    before = watched.value("trackweave.store.latest")
    watched.wait(f"trackweave.store.latest > {before}")
    watched.wait("trackweave.store.sensors.length === 2 && trackweave.store.curves.length > 0")
    watched.value("trackweave.map.select(trackweave.store.courses.get('1'))")
    watched.wait("trackweave.details.fetched.facts !== null")
    assert HOSTILE[:20] in watched.page.locator(".details h2").inner_text()
    assert "\u202e" not in watched.page.locator("body").inner_text()
    watched.page.keyboard.press("r")
    watched.wait("trackweave.store.reports.n > 0")
    assert watched.complaints == []
    assert all(address.startswith((url, "data:")) for address in watched.requests)


@pytest.mark.slow
def test_whoever_has_the_token_logs_in_by_the_form(watched: Watched, tmp_path: Path) -> None:
    token = "t" * 40
    (tmp_path / "token").write_text(token)
    (tmp_path / "token").chmod(0o600)
    service = Service(tmp_path / "data", "--token-file", str(tmp_path / "token"))
    try:
        page = watched.page
        page.goto(f"http://127.0.0.1:{service.port}/login")
        page.fill("#token", token)
        page.locator("button").click()
        page.wait_for_function("document.title !== 'trackweave: log in'")
        assert page.url == f"http://127.0.0.1:{service.port}/"
        assert "another origin" not in page.content()
    finally:
        service.kill()
