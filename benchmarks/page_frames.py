"""What the live page takes of the browser's main thread for each frame, with thousands of tracks.

Headless Chromium shows the page of a service whose aircraft are told of once a turn of 4 s, a
sector at a time: at rest, while the map is dragged and zoomed without end (so that each frame is
another view), and with a chosen track. CPU of the main thread as Chromium's own trace counts it,
for each frame's script (drawing, panels, everything), and for all that the thread did, messages
and Chromium's own work too.
"""

import argparse
import asyncio
import json
from pathlib import Path
from typing import Any

import numpy as np
from page_desk import AircraftDesk, served
from text_tables import command, heading, table

CHROMIUM = "/usr/bin/chromium"
SETTLE_S, MEASURE_S = 12.0, 15.0
# A map that is dragged in circles and zoomed in and out.
STIR = """() => {
  const { map } = globalThis.trackweave;
  let k = 0;
  globalThis.stirring = setInterval(() => {
    k += 1;
    map.moved = true;
    map.view.pan(9 * Math.cos(k / 20), 9 * Math.sin(k / 20));
    map.view.zoom(k % 120 < 60 ? 1.012 : 1 / 1.012);
    map.redraw();
  }, 16);
}"""
CHOOSE = """() => {
  const page = globalThis.trackweave;
  clearInterval(globalThis.stirring);
  page.map.fit();
  page.map.select(page.map.instant.courses[100]);
}"""
TRACED = ["devtools.timeline", "disabled-by-default-devtools.timeline"]
STATES = [("at rest", "() => {}"), ("dragged and zoomed", STIR), ("one chosen", CHOOSE)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--tracks", type=int, default=5000)
    parser.add_argument("--reports", action="store_true", help="with reports drawn")
    parser.add_argument("--picture", type=Path, help="where to write a picture of the page")
    arguments = parser.parse_args()
    rows = asyncio.run(_measured(arguments))
    print(
        heading(f"{arguments.tracks:,} tracks: CPU of the main thread for a frame's script [ms]")
    )
    titles = ["", "frames", "mean", "median", "95 %", "greatest", "thread in all [% of a core]"]
    print(table(titles, rows))
    print(command("page_frames.py"))


async def _measured(arguments: argparse.Namespace) -> list[list[Any]]:
    from playwright.async_api import async_playwright

    desk = AircraftDesk(arguments.tracks)
    server = await served(desk)
    flying = asyncio.create_task(desk.fly())
    try:
        async with async_playwright() as play:
            browser = await play.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
            page = await browser.new_page(viewport={"width": 1600, "height": 900})
            await page.goto(server.url)
            await asyncio.sleep(SETTLE_S)
            if arguments.reports:
                await page.evaluate("() => globalThis.trackweave.panel.set('reports', true)")
            rows = [await _state(page, name, script) for name, script in STATES]
            if arguments.picture is not None:
                await page.screenshot(path=arguments.picture)
            await browser.close()
    finally:
        flying.cancel()
        await server.stop()
    return rows


async def _state(page: Any, name: str, script: str) -> list[Any]:
    """Bring the page into a state and measure it."""
    await page.evaluate(script)
    await asyncio.sleep(2.0)
    browser = page.context.browser
    await browser.start_tracing(page=page, categories=TRACED)
    await asyncio.sleep(MEASURE_S)
    events = json.loads(await browser.stop_tracing())["traceEvents"]
    frames = [each for each in events if each["name"] == "FireAnimationFrame" and "tdur" in each]
    spent = np.array([each["tdur"] for each in frames]) / 1e3
    threads = {(each["pid"], each["tid"]) for each in frames}
    tasks = [
        each["tdur"]
        for each in events
        if each["name"] == "RunTask" and "tdur" in each and (each["pid"], each["tid"]) in threads
    ]
    return [
        name, len(frames), float(spent.mean()), float(np.median(spent)),
        float(np.quantile(spent, 0.95)), float(spent.max()), sum(tasks) / 1e4 / MEASURE_S,
    ]  # fmt: skip


if __name__ == "__main__":
    main()
