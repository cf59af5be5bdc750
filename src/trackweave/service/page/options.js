/** What people may choose of the map, and where it is kept. */

import { el } from "./dom.js";
import { COLOURINGS } from "./looks.js";
import { UNITS } from "./words.js";

const KEPT = "trackweave-page";
export const TRAILS = [[0, "none"], [60, "1 min"], [300, "5 min"], [1200, "20 min"], [Infinity, "all"]];
const LABELS = [["name", "names"], ["full", "names, speed and height"], ["none", "none"]];
const SWITCHES = [
  ["vectors", "Where they will be (vectors)", "v"],
  ["ellipses", "How well they are known (ellipses)", "e"],
  ["reports", "Reports and false alarms", "r"],
  ["sensors", "Sensors and coverage", "s"],
  ["rings", "Distances from sensors", "d"],
  ["grid", "Grid", "g"],
  ["land", "Land", "m"],
  ["truth", "Truth", "y"],
];

/** Return what is chosen where nobody chose. */
export function firstOptions({ geographic, live, down, colour, sensors = 1 }) {
  const dark = !window.matchMedia?.("(prefers-color-scheme: light)").matches;
  return {
    theme: dark ? "dark" : "light", colour: colour ?? "track",
    units: down ? "pixels" : geographic ? "nautical" : "metric",
    trail: live ? 300 : Infinity, labels: "name", vectors: true, ellipses: true, reports: !live,
    sensors: true, rings: sensors === 1, grid: true, land: true, truth: true,
  };
}

/** Take up what was chosen last time. */
export function recall(options) {
  try {
    const kept = JSON.parse(localStorage.getItem(KEPT) ?? "{}");
    if (["dark", "light"].includes(kept.theme)) options.theme = kept.theme;
    if (kept.units !== "pixels" && kept.units in UNITS && options.units !== "pixels") options.units = kept.units;
  } catch {
    // Pages opened as files may have no storage.
  }
  return options;
}

/** Keep what is chosen for the next time. */
export function keep({ theme, units }) {
  try {
    localStorage.setItem(KEPT, JSON.stringify({ theme, units }));
  } catch {
    // As above: then it is for this time alone.
  }
}

/** The panel in which options are chosen. */
export class OptionsPanel {
  constructor(options, has, changed) {
    this.options = options;
    this.changed = changed;
    this.boxes = new Map();
    const colourings = COLOURINGS.filter((by) => by !== "height" || has.heights);
    const kinds = Object.entries(UNITS).filter(([key]) => (key === "pixels") === (options.units === "pixels"));
    this.element = el(
      "div", { class: "options popover", hidden: true, role: "dialog", "aria-label": "What is shown" },
      this.#choice("colour", "Colour by", colourings.map((by) => [by, by])),
      this.#choice("trail", "Trails", TRAILS),
      this.#choice("labels", "Labels", LABELS),
      this.#choice("units", "Units", kinds.map(([key, { name }]) => [key, name])),
      ...SWITCHES.filter(([key]) => has[key] !== false).map((entry) => this.#switch(...entry)),
    );
  }

  #choice(key, name, values) {
    const select = el("select", {
      onchange: () => this.set(key, values[select.selectedIndex][0]),
    }, ...values.map(([, text]) => el("option", { text })));
    select.selectedIndex = values.findIndex(([value]) => value === this.options[key]);
    this.boxes.set(key, () => (select.selectedIndex = values.findIndex(([value]) => value === this.options[key])));
    return el("label", { class: "choice" }, el("span", { text: name }), select);
  }

  #switch(key, name, letter) {
    const box = el("input", { type: "checkbox", checked: this.options[key], onchange: () => this.set(key, box.checked) });
    this.boxes.set(key, () => (box.checked = this.options[key]));
    return el("label", { class: "switch" }, box, el("span", { text: name }), el("kbd", { text: letter }));
  }

  set(key, value) {
    this.options[key] = value;
    this.boxes.get(key)?.();
    keep(this.options);
    this.changed(key);
  }

  /** Turn what a key stands for on or off; return whether there is any. */
  pressed(letter) {
    const entry = SWITCHES.find(([key, , own]) => own === letter && this.boxes.has(key));
    if (entry) this.set(entry[0], !this.options[entry[0]]);
    return entry !== undefined;
  }
}
