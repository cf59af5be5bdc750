/** The page of a run: everything that it shows lies in the page itself. */

import { Page } from "./app.js";
import { decodeLand } from "./coast.js";
import { firstOptions, recall } from "./options.js";
import { loadRun } from "./run.js";

async function readRun() {
  const text = document.getElementById("run").textContent.trim();
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).json();
}

async function open() {
  const root = document.getElementById("page");
  if (typeof DecompressionStream === "undefined") {
    root.textContent = "This page needs a browser of 2023 or later.";
    return;
  }
  const run = await readRun();
  const store = loadRun(run);
  const colour = store.hasHeights && store.plane.geographic ? "height" : "track";
  const options = recall(firstOptions({ geographic: run.geographic, live: false, down: run.down, colour, sensors: run.sensors.length }));
  const page = new Page(root, { store, options, title: run.title, run, truth: store.truth });
  if (run.coast) {
    const bytes = Uint8Array.from(atob(run.coast), (letter) => letter.charCodeAt(0));
    page.map.rings = decodeLand(bytes, store.plane);
  }
  page.map.redraw();
  globalThis.trackweave = page;
}

open();
