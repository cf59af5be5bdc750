/** Panels beside the map: sensors, the service or the run, and the curves of both. */

import { Strip } from "./charts.js";
import { el, nameOf } from "./dom.js";
import { THEMES } from "./looks.js";
import { clockTime, counted, digits, lasting, percent, plain } from "./words.js";

/** The list of sensors: who reports, how often, and who fell silent. */
export class SensorPanel {
  constructor(map, centre) {
    this.map = map;
    this.centre = centre;
    this.element = el("section", { class: "sensors" });
  }

  refresh() {
    const { store, time } = this.map;
    const most = Math.max(...store.sensors.map((sensor) => sensor.reports_per_s ?? 0), 1e-9);
    const cards = store.sensors.map((sensor) => this.#card(sensor, most, store, time));
    this.element.replaceChildren(...(cards.length ? cards : [el("p", { class: "hint", text: "Nothing is said of sensors." })]));
  }

  #card(sensor, most, store, time) {
    const card = el("article", { class: sensor.silent ? "sensor silent" : "sensor" });
    const place = store.sensorPlace(sensor);
    const title = el("h3", {}, nameOf(plain(sensor.name, 30)));
    if (sensor.silent) title.append(el("span", { class: "badge", text: "silent" }));
    if (place) title.append(el("button", { type: "button", class: "link", text: "show", onclick: () => this.centre(place) }));
    card.append(title);
    if (Number.isFinite(sensor.reports_per_s)) {
      const bar = el("span", { class: "bar" }, el("i", {}));
      bar.firstChild.style.width = `${(100 * sensor.reports_per_s) / most}%`;
      card.append(el("p", {}, bar, `${digits(sensor.reports_per_s)} reports/s`));
    }
    const said = [];
    if (sensor.kind) said.push(plain(sensor.kind, 30));
    if (Number.isFinite(sensor.reports)) said.push(`${counted(sensor.reports)} reports`);
    if (Number.isFinite(sensor.last_heard)) {
      const ago = time - sensor.last_heard;
      said.push(`last heard ${clockTime(sensor.last_heard, store.calendar)}${ago >= 1 ? ` (${lasting(ago)} ago)` : ""}`);
    }
    card.append(el("p", { class: "hint", text: said.join(" · ") }));
    return card;
  }
}

/** What the service says of itself, with the last ten minutes. */
export class ServicePanel {
  constructor(map) {
    this.map = map;
    this.facts = el("dl", {});
    const strip = (title, key, options) => [key, new Strip(title, options)];
    this.strips = Object.fromEntries([
      strip("Load", "load", { text: percent }),
      strip("Latency", "latency_s", { text: (value) => `${digits(1000 * value)} ms` }),
      strip("Reports per second", "reports_per_s"),
      strip("Gap to the proven bound", "gap", { text: percent }),
    ]);
    this.element = el("section", { class: "service" }, this.facts, ...Object.values(this.strips).map((each) => each.element));
  }

  refresh() {
    const { store, time, options } = this.map;
    const { status } = store;
    const lines = [
      ["Connection", this.connection ?? "–"],
      ["Set aside", counted(status.set_aside ?? NaN)],
      ["Dropped", counted(status.dropped ?? NaN)],
      ["On disk up to", counted(status.sequence ?? NaN)],
    ];
    this.facts.replaceChildren(...lines.flatMap(([name, value]) => [el("dt", { text: name }), el("dd", { text: value })]));
    const theme = THEMES[options.theme];
    const from = store.curves.length ? store.curves[0][0] : time - 1;
    for (const [key, strip] of Object.entries(this.strips)) {
      const points = store.curves.map(([when, values]) => [when, values[key] ?? NaN]);
      strip.draw([{ colour: theme.tracks[0], points }], from, Math.max(store.latest, from + 1), time, theme);
    }
  }
}

/** What a run says of itself: totals, notes, and its curves over time. */
export class RunPanel {
  constructor(map, run) {
    this.map = map;
    this.run = run;
    this.strips = run.curves.map(({ title, kind }) => new Strip(title, stripOptions(kind)));
    this.element = el(
      "section", { class: "run" },
      el("dl", {}, ...run.facts.flatMap(([name, value]) => [el("dt", { text: plain(name, 60) }), el("dd", {}, nameOf(plain(value, 200)))])),
      ...this.strips.map((strip) => strip.element),
      run.notes.length ? el("h3", { text: "What to know of it" }) : null,
      el("ul", { class: "notes" }, ...run.notes.map((note) => el("li", {}, nameOf(plain(note, 600))))),
    );
  }

  refresh() {
    const { options, time, store } = this.map;
    const theme = THEMES[options.theme];
    this.run.curves.forEach(({ lines }, k) => {
      const drawn = lines.map((line, at) => ({ ...line, colour: lines.length > 1 && line.status !== undefined ? theme.status[line.status] : theme.tracks[at] }));
      this.strips[k].draw(drawn, store.first, store.latest, time, theme);
    });
  }
}

function stripOptions(kind) {
  if (kind === "share") return { text: percent };
  if (kind === "ms") return { text: (value) => `${digits(value)} ms` };
  if (kind === "count") return { text: counted };
  return {};
}
