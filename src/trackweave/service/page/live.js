/** The page of a live service: its stream, its sensors, its tracks. */

import { Page } from "./app.js";
import { decodeLand } from "./coast.js";
import { firstOptions, recall } from "./options.js";
import { Store } from "./store.js";
import { Tiles } from "./tiles.js";
import { UNITS } from "./words.js";

const FIRST_WAIT_MS = 500;
const LONGEST_WAIT_MS = 15000;
const SILENT_MS = 10000;

class Stream {
  constructor(page, wanted) {
    this.page = page;
    this.wanted = wanted;
    this.wait = FIRST_WAIT_MS;
    this.reports = wanted();
    this.heard = performance.now();
    this.connect();
    setInterval(() => this.#watch(), 1000);
  }

  connect() {
    const address = new URL("stream", location.href);
    address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
    address.hash = "";
    address.search = this.reports ? "?reports=1" : "";
    this.page.say("connecting …");
    const socket = new WebSocket(address);
    this.socket = socket;
    socket.onmessage = (event) => this.#message(event.data);
    socket.onopen = () => {
      this.wait = FIRST_WAIT_MS;
      this.heard = performance.now();
      this.page.say("");
    };
    socket.onclose = () => {
      if (socket !== this.socket) return;
      this.page.say(`no connection; again in ${Math.ceil(this.wait / 1000)} s`);
      setTimeout(() => socket === this.socket && this.connect(), this.wait);
      this.wait = Math.min(2 * this.wait, LONGEST_WAIT_MS);
    };
  }

  #message(data) {
    this.heard = performance.now();
    let message = null;
    try {
      message = JSON.parse(data);
    } catch {
      return; // not for us: what follows may be
    }
    if (!this.page.store.plane && message.type === "reports") return;
    const began = this.page.store.plane === null;
    this.page.store.take(message, performance.now() / 1000);
    if (began && this.page.store.plane) this.page.begin();
    if (message.type === "sensors") this.page.placed();
  }

  #watch() {
    if (this.wanted() !== this.reports) {
      this.reports = this.wanted();
      const old = this.socket;
      this.socket = null;
      old.close();
      this.connect();
    } else if (this.socket?.readyState === WebSocket.OPEN) {
      const silent = performance.now() - this.heard;
      this.page.say(silent > SILENT_MS ? `nothing new for ${Math.round(silent / 1000)} s` : "");
    }
  }
}

class LivePage extends Page {
  /** Take up what only the first picture tells: whether places are on the Earth. */
  begin() {
    const { geographic } = this.store.plane;
    const { units } = recall({ ...this.options, units: geographic ? "nautical" : "metric" });
    if (units in UNITS) this.panel.set("units", units);
    if (this.store.hasHeights) this.panel.set("colour", "height");
    if (geographic && !this.map.rings) {
      fetch("coast.bin")
        .then((answer) => (answer.ok ? answer.arrayBuffer() : Promise.reject(answer.status)))
        .then((buffer) => {
          this.map.rings = decodeLand(new Uint8Array(buffer), this.store.plane);
          this.map.redraw("scenery");
        })
        .catch(() => this.say("the coastline did not come"));
    }
    this.apply();
  }

  /** Draw sensors anew; circles about many of them would hide everything else. */
  placed() {
    if (this.store.sensors.length > 1 && !this.unringed) this.panel.set("rings", false);
    this.unringed = true;
    this.map.redraw("scenery");
  }

  /** Take what the service's configuration says of the page. */
  settle({ tiles, attribution }) {
    if (tiles) this.map.tiles = new Tiles(tiles, attribution, () => this.map.redraw("scenery"));
  }
}

async function fetched(path) {
  const answer = await fetch(path, { headers: { Accept: "application/json" } });
  if (!answer.ok) throw new Error(String(answer.status));
  return answer.json();
}

const options = recall(firstOptions({ geographic: false, live: true }));
const page = new LivePage(document.getElementById("page"), { store: new Store(), options, title: "trackweave", fetchTrack: (id) => fetched(`tracks/${encodeURIComponent(id)}`) });
page.stream = new Stream(page, () => options.reports);
fetched("page.json").then((settings) => page.settle(settings), () => {});
globalThis.trackweave = page;
