/** The whole page: the map, what stands beside it, the keyboard, and the loop that draws. */

import { Details } from "./details.js";
import { el, iconButton, nameOf } from "./dom.js";
import { HELP, watchKeys } from "./keyboard.js";
import { COLOURINGS, symbolSample, THEMES } from "./looks.js";
import { TrackList } from "./list.js";
import { TrackMap } from "./map.js";
import { keep, OptionsPanel, TRAILS } from "./options.js";
import { RunPanel, SensorPanel, ServicePanel } from "./panels.js";
import { STATUSES } from "./store.js";
import { Timeline } from "./timeline.js";
import { counted, lasting, plain, roundStep } from "./words.js";

const PANELS_MS = 450;
const BETWEEN_PANELS_MS = 30;
const BARS_MS = 2000;
const RESTS_OF_PANELS = 40; // panels rest so many times as long as they take

/** The page of a live service, or of a run. */
export class Page {
  constructor(root, { store, options, title, run = null, truth = [], fetchTrack = null }) {
    Object.assign(this, { root, store, options, run, live: run === null });
    this.mapElement = el("div", { class: "map", tabindex: "0", role: "application", "aria-label": "Map of tracks. Arrow keys move it, plus and minus zoom, question mark lists all keys." });
    this.map = new TrackMap(this.mapElement, store, options);
    this.map.truth = truth;
    this.map.onselect = (course) => this.#selected(course);
    this.map.onhover = (course, x, y) => this.#tip(course, x, y);
    this.timeline = new Timeline(this.map, { live: this.live, seconds: store.latest - store.first });
    this.list = new TrackList(this.map, (course) => this.choose(course));
    this.details = new Details(this.map, {
      close: () => this.map.select(null), follow: () => this.hold(), fetchTrack,
    });
    this.sensors = new SensorPanel(this.map, ([x, y]) => this.#centre(x, y));
    this.about = this.live ? new ServicePanel(this.map) : new RunPanel(this.map, run);
    this.spent = []; // milliseconds of script of the last frames
    this.before = this.refreshedAt = -Infinity;
    const duty = (every, act) => ({ every, act, at: -Infinity, cost: 0 });
    this.duties = [
      duty(PANELS_MS, (now) => this.details.refresh(now)),
      duty(PANELS_MS, () => this.#beside()),
      duty(PANELS_MS, () => this.#count()),
      duty(PANELS_MS, () => this.#explain()),
      duty(PANELS_MS, () => this.timeline.drawBars()),
      duty(BARS_MS, () => this.timeline.count()),
    ];
    this.#build(title);
    watchKeys(this);
    this.apply();
    requestAnimationFrame((ms) => this.#frame(ms));
  }

  #build(title) {
    const has = { heights: this.store.hasHeights, truth: this.map.truth.length > 0, land: this.store.plane?.geographic !== false };
    if (this.live) has.heights = true; // they may come yet
    this.panel = new OptionsPanel(this.options, has, (key) => this.apply(key));
    this.counts = el("div", { class: "counts" });
    this.notice = el("span", { class: "notice", role: "status" });
    this.tip = el("div", { class: "tip", hidden: true });
    this.spoken = el("p", { class: "spoken", "aria-live": "polite" });
    this.legend = el("div", { class: "legend", "aria-hidden": "true" });
    this.tabs = ["Tracks", "Sensors", this.live ? "Service" : "Run"].map((name, k) =>
      el("button", { type: "button", role: "tab", text: name, onclick: () => this.tab(k) }),
    );
    this.pages = [this.list.element, this.sensors.element, this.about.element];
    this.side = el("aside", {}, this.details.element, el("nav", { role: "tablist" }, ...this.tabs), ...this.pages);
    this.help = el("dialog", { class: "help" }, el("h2", { text: "Keys" }), el("dl", {}, ...HELP.flatMap(([key, text]) => [el("dt", {}, el("kbd", { text: key })), el("dd", { text })])), el("form", { method: "dialog" }, el("button", { text: "Close" })));
    this.root.replaceChildren(
      el("header", { class: "top" },
        el("h1", {}, nameOf(plain(title, 80))), this.counts, this.notice,
        el("div", { class: "tools" },
          iconButton("layers", "What is shown (o)", () => this.toggleOptions()),
          iconButton("theme", "Dark or light (t)", () => this.toggleTheme()),
          iconButton("help", "Keys (?)", () => this.toggleHelp()),
          iconButton("list", "Panel (p)", () => this.toggleSide()))),
      el("main", {}, this.mapElement, this.panel.element, this.legend, this.tip,
        el("div", { class: "zoom" },
          iconButton("plus", "Closer (+)", () => this.zoom(1.5)),
          iconButton("minus", "Farther (−)", () => this.zoom(1 / 1.5)),
          iconButton("fit", "Everything (0)", () => this.map.fit()))),
      this.side, this.timeline.element, this.help, this.spoken,
    );
    if (window.innerWidth < 760) this.root.classList.add("narrow");
    this.tab(0);
  }

  /** Show one of the pages beside the map. */
  tab(shown) {
    this.shown = shown;
    this.pages.forEach((page, k) => (page.hidden = k !== shown));
    this.tabs.forEach((tab, k) => tab.setAttribute("aria-selected", String(k === shown)));
    this.#hurry();
  }

  /** Take changed options. */
  apply() {
    document.documentElement.dataset.theme = this.options.theme;
    this.map.restyle();
    this.#hurry();
  }

  choose(course) {
    this.map.select(course);
    const k = this.map.instant.courses.indexOf(course);
    if (k < 0) return;
    const [px, py] = [this.map.places?.px[k], this.map.places?.py[k]];
    const { width, height } = this.map.view;
    if (!(px > 40 && py > 40 && px < width - 40 && py < height - 40)) this.map.centre(course);
  }

  /** Keep the chosen track in the middle, or let it go. */
  hold() {
    this.map.fixed = !this.map.fixed && this.map.selected !== null;
    this.details.follow.setAttribute("aria-pressed", String(this.map.fixed));
    if (this.map.fixed) this.map.centre(this.map.selected);
  }

  zoom(factor) {
    this.map.moved = true;
    this.map.view.zoom(factor);
    this.map.redraw();
  }

  toggleTheme() {
    this.options.theme = this.options.theme === "dark" ? "light" : "dark";
    keep(this.options);
    this.apply();
  }

  toggleOptions() {
    this.panel.element.hidden = !this.panel.element.hidden;
  }

  toggleHelp() {
    if (this.help.open) this.help.close();
    else this.help.showModal();
  }

  toggleSide() {
    this.root.classList.toggle("narrow");
  }

  /** Take the next of the ways to colour, of trails or of labels. */
  next(key) {
    const values = { colour: COLOURINGS, trail: TRAILS.map(([value]) => value), labels: ["name", "full", "none"] }[key];
    const own = key === "colour" && !this.store.hasHeights ? values.filter((by) => by !== "height") : values;
    this.panel.set(key, own[(own.indexOf(this.options[key]) + 1) % own.length]);
  }

  /** Say something beside the counts, nothing to be silent. */
  say(text) {
    this.notice.textContent = text;
    if (this.about.connection !== undefined || this.live) this.about.connection = text || "connected";
  }

  #centre(x, y) {
    Object.assign(this.map.view, { x, y });
    this.map.redraw();
  }

  #selected(course) {
    this.map.fixed = false;
    this.details.follow.setAttribute("aria-pressed", "false");
    this.root.classList.toggle("chosen", course !== null);
    if (course && window.innerWidth < 760) this.root.classList.remove("narrow");
    const row = course ? Math.max(course.rowAt(this.map.time), 0) : 0;
    this.spoken.textContent = course ? `Track ${plain(course.label, 30)}, ${STATUSES[course.status[row]]}` : "";
    this.#hurry();
  }

  #tip(course, x, y) {
    this.tip.hidden = !course;
    if (!course) return;
    const { map } = this;
    const row = Math.max(course.rowAt(map.time), 0);
    const said = [`${STATUSES[course.status[row]]}, ${map.units.speed(course.speed(row))}`];
    if (course.speed(row) > 1e-9) said.push(`course ${Math.round(course.heading(row)) % 360}°`);
    if (Number.isFinite(course.height[row])) said.push(map.units.height(course.height[row]));
    said.push(`since ${lasting(map.time - course.time[0])}`);
    this.tip.replaceChildren(el("strong", {}, nameOf(plain(course.label, 30))), ...said.map((text) => el("div", { text })));
    const right = x > map.view.width - 190;
    this.tip.style.transform = `translate(${right ? x - 16 : x + 16}px, ${Math.min(y + 12, map.view.height - 96)}px) ${right ? "translateX(-100%)" : ""}`;
  }

  #frame(ms) {
    const begun = performance.now();
    const now = ms / 1000;
    this.map.following = this.timeline.following;
    if (Number.isNaN(this.timeline.shown) && Number.isFinite(this.store.latest)) {
      this.timeline.shown = this.live ? this.store.latest : this.timeline.busiest();
    }
    this.timeline.advance(Math.min(now - this.before, 0.25), now);
    this.before = now;
    this.map.show(this.timeline.shown, ms);
    this.map.draw(ms);
    this.timeline.refresh();
    this.#refresh(ms);
    this.spent.push(performance.now() - begun);
    if (this.spent.length > 600) this.spent.shift();
    requestAnimationFrame((next) => this.#frame(next));
  }

  /** Bring one panel up to date, if any is due: no frame has to bear them all. */
  #refresh(ms) {
    if (!this.store.plane || ms - this.refreshedAt < BETWEEN_PANELS_MS) return;
    const due = this.duties.find((duty) => ms - duty.at > Math.max(duty.every, RESTS_OF_PANELS * duty.cost));
    if (!due) return;
    const begun = performance.now();
    due.act(ms / 1000);
    due.cost = performance.now() - begun;
    due.at = this.refreshedAt = ms;
  }

  /** Let all panels be brought up to date at once. */
  #hurry() {
    this.refreshedAt = -Infinity;
    for (const duty of this.duties) duty.at = -Infinity;
  }

  #beside() {
    if (!this.root.classList.contains("narrow")) [this.list, this.sensors, this.about][this.shown].refresh();
  }

  #count() {
    const counts = [0, 0, 0];
    const { instant, palette, options } = this.map;
    for (let k = 0; k < instant.n; k++) counts[instant.courses[k].status[instant.rows[k]]]++;
    const signature = counts.join() + options.theme;
    if (signature === this.counted) return;
    this.counted = signature;
    const colour = palette.theme.ink;
    this.counts.replaceChildren(
      ...[1, 2, 0].map((status) => el("span", { title: `${STATUSES[status]} tracks` }, symbolSample(status, colour, options.theme), `${counted(counts[status])} `, el("em", { text: STATUSES[status] }))),
    );
  }

  /** Say how long a stretch of the screen is, how far vectors point, and what colours mean. */
  #explain() {
    const { view, units, palette, ahead, options } = this.map;
    const perMetre = this.store.plane.perMetre(view.y) * view.scale;
    const length = roundStep(120 / perMetre / units.unit) * units.unit;
    const signature = [length, ahead, options.colour, options.theme, options.units, perMetre, palette.most].join();
    if (signature === this.explained) return;
    this.explained = signature;
    const ruler = el("span", { class: "ruler", text: units.ruler(length) });
    ruler.style.width = `${length * perMetre}px`;
    const lines = [ruler];
    if (options.vectors && ahead) lines.push(el("span", { text: `vectors: ${lasting(ahead).replace(".0", "")}` }));
    if (options.colour === "height" || options.colour === "speed") {
      const bar = el("span", { class: "scale" }, ...palette.colours.slice(0, -1).map((colour) => {
        const step = el("i", {});
        step.style.background = colour;
        return step;
      }));
      lines.push(el("span", { class: "ramp" }, `0 `, bar, ` ${units[options.colour](palette.most)}`));
    }
    if (options.colour === "status") {
      lines.push(el("span", { class: "ramp" }, ...STATUSES.flatMap((name, k) => {
        const patch = el("i", { class: "patch" });
        patch.style.background = THEMES[options.theme].status[k];
        return [patch, name];
      })));
    }
    this.legend.replaceChildren(...lines);
  }
}
