/**
 * The map: sheets above one another, each drawn again only when something on it changed.
 *
 * Beneath lies the scenery, then trails and reports, then symbols, then labels and what is chosen.
 */

import { el, sized } from "./dom.js";
import { boxAround, View } from "./geometry.js";
import { watchPointers } from "./gestures.js";
import { Glyphs } from "./glyphs.js";
import { Palette, THEMES } from "./looks.js";
import { drawMarks, trackAt } from "./marks.js";
import { drawScenery } from "./scenery.js";
import { Instant } from "./store.js";
import { drawReports, drawTrails, drawTruth } from "./trails.js";
import { UNITS } from "./words.js";

const SHEETS = ["scenery", "trails", "marks"];
const MOVING_MS = 60; // how often tracks move along between messages
const TRAILS_MS = 900;
const CHEAP_MS = 3;
const MOST_SLIDES = 6;
const RESTS = 7; // a sheet rests so many times as long as drawing it took
const REACH = { mouse: 14, touch: 26 };

/** The map of a store, drawn into an element. */
export class TrackMap {
  constructor(element, store, options) {
    this.element = element;
    this.store = store;
    this.options = options;
    this.view = new View();
    this.instant = new Instant();
    this.rings = null;
    this.tiles = null;
    this.truth = [];
    this.time = NaN;
    this.selected = null;
    this.hovered = null;
    this.places = null;
    this.ahead = undefined;
    this.stale = new Set(SHEETS);
    this.drawnAt = this.trailedAt = -Infinity;
    this.costs = { scenery: 0, marks: 0, trails: 0 }; // milliseconds that drawing took, smoothed
    this.drawn = {}; // how the view was when each sheet was drawn
    this.following = false; // time runs as it does outside
    this.fitted = false;
    this.moved = false; // by hand: then the view is nobody else's to change
    this.fixed = false; // the chosen track stays in the middle
    this.onselect = () => {};
    this.onhover = () => {};
    this.room = { left: 45, right: 60, top: 45, bottom: 75 };
    this.sheets = Object.fromEntries(SHEETS.map((name) => [name, el("canvas", { class: "sheet" })]));
    const symbols = el("canvas", { class: "sheet" });
    this.glyphs = new Glyphs(symbols);
    element.append(this.sheets.scenery, this.sheets.trails, symbols, this.sheets.marks);
    watchPointers(element, this.view, {
      moved: () => {
        this.moved = true;
        this.redraw();
      },
      hover: (x, y) => this.#hover(x, y),
      click: (x, y, touch) => this.select(trackAt(this, x, y, touch ? REACH.touch : REACH.mouse)),
      leave: () => this.#hover(NaN, NaN),
    });
    new ResizeObserver(() => this.#resize()).observe(element);
    this.#resize();
    this.restyle();
  }

  /** Take changed options: theme, colours, units. */
  restyle() {
    this.theme = THEMES[this.options.theme];
    this.palette = new Palette(this.options.theme, this.options.colour, this.#most());
    this.units = UNITS[this.options.units];
    this.redraw();
  }

  redraw(...sheets) {
    for (const sheet of sheets.length ? sheets : SHEETS) this.stale.add(sheet);
  }

  /** Show a moment; what moves along with time is drawn as often as it is cheap. */
  show(time, now) {
    if (time === this.time) return;
    const since = now - this.drawnAt;
    if (this.following && since < MOVING_MS) return;
    if (since > RESTS * this.costs.marks) {
      this.time = time;
      this.redraw("marks");
      if (now - this.trailedAt > Math.max(this.following ? TRAILS_MS : 0, RESTS * this.costs.trails)) this.redraw("trails");
      if (this.fixed && this.selected) this.centre(this.selected);
    }
  }

  /** Draw what is stale; to be called once a frame. */
  draw(now) {
    if (!this.stale.size || this.view.width < 2) return;
    if (!this.fitted && this.store.plane) this.fit();
    if (this.stale.has("scenery")) this.#sheet("scenery", now, (ctx) => drawScenery(ctx, this));
    if (!this.store.plane || Number.isNaN(this.time)) return;
    if (this.stale.has("trails")) this.#sheet("trails", now, (ctx) => this.#drawPast(ctx));
    if (this.stale.has("marks")) {
      this.instant.fill(this.store, this.time);
      this.#sheet("marks", now, (ctx) => drawMarks(ctx, this));
      this.drawnAt = now;
    }
  }

  /** Draw a sheet, or, where that is costly and was done just now, only move what is on it. */
  #sheet(name, now, paint) {
    const drawn = this.drawn[name];
    const { view } = this;
    const moved = drawn && drawn.scale && (drawn.x !== view.x || drawn.y !== view.y || drawn.scale !== view.scale);
    const begun = performance.now();
    // While the view moves, what is costly is drawn anew only now and then, one sheet a frame.
    const waits = drawn?.slid < MOST_SLIDES || this.costly === now;
    if (name !== "marks" && moved && drawn.cost > CHEAP_MS && waits) {
      drawn.slid += 1;
      this.#slide(name, drawn);
      return;
    }
    const ctx = sized(this.sheets[name]);
    ctx.clearRect(0, 0, view.width, view.height);
    paint(ctx);
    this.sheets[name].style.transform = "";
    this.stale.delete(name);
    const cost = performance.now() - begun;
    this.costs[name] += 0.2 * (cost - this.costs[name]);
    this.drawn[name] = { x: view.x, y: view.y, scale: view.scale, slid: 0, cost };
    if (cost > CHEAP_MS) this.costly = now;
    if (name === "trails") this.trailedAt = now;
  }

  /** Move a sheet as the view moved since it was drawn; it stays stale. */
  #slide(name, drawn) {
    const { view } = this;
    const factor = view.scale / drawn.scale;
    const dx = view.width / 2 * (1 - factor) + (drawn.x - view.x) * view.scale;
    const dy = view.height / 2 * (1 - factor) - (drawn.y - view.y) * view.scale;
    this.sheets[name].style.transform = `matrix(${factor}, 0, 0, ${factor}, ${dx}, ${dy})`;
  }

  #drawPast(ctx) {
    if (this.options.truth && this.truth.length) drawTruth(ctx, this);
    const chosen = this.options.reports ? drawReports(ctx, this) : new Path2D();
    if (this.options.trail > 0) drawTrails(ctx, this);
    ctx.strokeStyle = this.theme.ink;
    ctx.lineWidth = 1.1;
    ctx.stroke(chosen);
  }

  /** Show everything that is known. */
  fit() {
    const box = boxAround(this.store.places());
    if (!box) return;
    const perMetre = this.store.plane.perMetre((box[1] + box[3]) / 2);
    const least = this.store.plane.geographic ? 2000 * perMetre : 1e-6;
    const across = Math.max(box[2] - box[0], least);
    const upwards = Math.max(box[3] - box[1], least);
    const [x, y] = [(box[0] + box[2]) / 2, (box[1] + box[3]) / 2];
    this.view.fit([x - across / 2, y - upwards / 2, x + across / 2, y + upwards / 2], this.room);
    this.fitted = true;
    this.redraw();
  }

  /** Bring a track to the middle of what is free of panels. */
  centre(course) {
    const row = course.rowAt(this.time);
    if (row < 0) return;
    this.view.x = course.x[row] + (this.room.right - this.room.left) / 2 / this.view.scale;
    this.view.y = course.y[row] - (this.room.bottom - this.room.top) / 2 / this.view.scale;
    this.view.version += 1;
    this.redraw();
  }

  select(course) {
    if (course === this.selected) return;
    this.selected = course;
    this.redraw("trails", "marks");
    this.onselect(course);
  }

  #hover(x, y) {
    const course = Number.isNaN(x) ? null : trackAt(this, x, y, REACH.mouse);
    this.onhover(course, x, y);
    if (course === this.hovered) return;
    this.hovered = course;
    this.element.classList.toggle("pointing", course !== null);
    this.redraw("marks");
  }

  #resize() {
    const { clientWidth, clientHeight } = this.element;
    if (!clientWidth || !clientHeight) return;
    this.view.resize(clientWidth, clientHeight);
    if (!this.moved) this.fitted = false;
    this.redraw();
  }

  /** Return the value of the topmost colour: a round one above what there is. */
  #most() {
    const { colour } = this.options;
    if (colour !== "speed" && colour !== "height") return undefined;
    const values = [];
    for (const course of this.store.courses.values()) {
      const last = course.n - 1;
      if (last >= 0 && course.status[last]) values.push(colour === "speed" ? course.speed(last) : course.height[last]);
    }
    const known = values.filter(Number.isFinite).sort((one, other) => one - other);
    return Math.max(known[Math.floor(0.98 * (known.length - 1))] ?? 0, 1e-6) || undefined;
  }
}
