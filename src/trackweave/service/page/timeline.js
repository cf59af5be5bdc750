/** The slider over time, with how many tracks there were, and what plays it. */

import { el, icon, sized } from "./dom.js";
import { THEMES } from "./looks.js";
import { calendarDay, clockTime } from "./words.js";

const SPEEDS = [1, 2, 5, 10, 30, 60, 120, 300];
const BARS = 240;

/** The line at the page's foot. It moves `time.shown`; `live` follows what comes in. */
export class Timeline {
  constructor(map, { live, seconds }) {
    this.map = map;
    this.following = live;
    this.live = live;
    this.playing = false;
    this.rate = live ? 10 : SPEEDS.find((speed) => seconds / speed < 45) ?? 300;
    this.shown = NaN;
    this.counts = null;
    this.play = el("button", { type: "button", class: "icon play", onclick: () => this.toggle() });
    this.text = el("output", { class: "clock" });
    this.day = el("span", { class: "day" });
    this.speed = el("button", { type: "button", class: "link", title: "How fast it plays ([ and ])", onclick: () => this.faster(1, true) });
    this.follow = el("button", { type: "button", class: "live", onclick: () => this.#followLive() }, icon("live"), "Live");
    this.canvas = el("canvas", { class: "bars" });
    this.range = el("input", { type: "range", min: 0, max: 1000, step: "any", "aria-label": "Time", oninput: () => this.#slid() });
    this.element = el(
      "footer", { class: "timeline" },
      this.play, el("div", { class: "when" }, this.text, this.day),
      el("div", { class: "slider" }, this.canvas, this.range),
      this.speed, this.follow,
    );
    this.follow.hidden = !live;
    this.#mark();
  }

  get from() {
    const { store } = this.map;
    return this.live ? Math.max(store.first, store.latest - store.keep) : store.first;
  }

  get to() {
    return this.map.store.latest;
  }

  toggle() {
    if (!this.playing && !this.following && this.shown >= this.to - 1e-6) this.shown = this.from;
    if (this.following) this.following = false;
    else this.playing = !this.playing;
    this.#mark();
  }

  /** Play faster or slower. */
  faster(by, round = false) {
    const at = SPEEDS.indexOf(this.rate) + by;
    this.rate = SPEEDS[round ? at % SPEEDS.length : Math.max(0, Math.min(SPEEDS.length - 1, at))];
    this.#mark();
  }

  /** Go to a moment and stay there. */
  go(time) {
    this.following = false;
    this.shown = Math.max(this.from, Math.min(this.to, time));
    this.#mark();
  }

  #followLive() {
    this.following = true;
    this.playing = false;
    this.#mark();
  }

  #slid() {
    this.playing = false;
    const share = Number(this.range.value) / 1000;
    this.go(this.from + share * (this.to - this.from));
    if (this.live && share > 0.9985) this.#followLive();
  }

  /** Move on by what passed since the last frame [s]; return whether time runs smoothly. */
  advance(passed, now) {
    const { store } = this.map;
    if (this.following) {
      this.shown = store.timeAt(now);
      return true;
    }
    if (!this.playing) return false;
    this.shown = Math.min(this.shown + passed * this.rate, this.to);
    if (this.shown >= this.to) {
      if (this.live) this.#followLive();
      else this.playing = false;
      this.#mark();
    }
    return true;
  }

  #mark() {
    const runs = this.playing || this.following;
    this.play.replaceChildren(icon(runs ? "pause" : "play"));
    this.play.setAttribute("aria-label", runs ? "Pause (space)" : "Play (space)");
    this.play.title = runs ? "Pause (space)" : "Play (space)";
    this.speed.textContent = `${this.rate}×`;
    this.speed.setAttribute("aria-label", `Plays ${this.rate} times as fast as it was`);
    this.speed.hidden = this.following;
    this.follow.classList.toggle("on", this.following);
    this.follow.setAttribute("aria-pressed", String(this.following));
  }

  /** Write the time and put the slider where it is. */
  refresh() {
    const { store } = this.map;
    const [from, to] = [this.from, this.to];
    this.text.textContent = clockTime(this.shown, store.calendar);
    this.day.textContent = calendarDay(this.shown, store.calendar);
    if (Number.isFinite(to - from)) this.range.value = String(Math.min(1, (this.shown - from) / Math.max(to - from, 1e-9)) * 1000);
    this.range.setAttribute("aria-valuetext", this.text.textContent);
  }

  /** Return a moment, as late as can be, at which as many tracks are there as ever. */
  busiest() {
    const changes = [];
    for (const { confirmed, ended } of this.map.store.courses.values()) {
      if (confirmed === Infinity) continue;
      changes.push([confirmed, 1]);
      if (ended < this.to) changes.push([ended, -1]);
    }
    changes.sort((one, other) => one[0] - other[0] || other[1] - one[1]);
    let [count, most, moment] = [0, 0, this.to];
    changes.forEach(([time, change], k) => {
      count += change;
      const next = changes[k + 1] ? changes[k + 1][0] : this.to;
      if (count >= most) [most, moment] = [count, k + 1 < changes.length ? (time + next) / 2 : next];
    });
    return moment;
  }

  /** Count how many tracks there were when: costly, so only now and then. */
  count() {
    const changes = new Float64Array(BARS + 2);
    const span = Math.max(this.to - this.from, 1e-9);
    const bar = (time) => Math.max(0, Math.min(BARS, Math.floor(((time - this.from) / span) * BARS)));
    for (const course of this.map.store.courses.values()) {
      if (course.confirmed === Infinity) continue;
      changes[bar(course.confirmed)] += 1;
      changes[bar(Math.min(course.ended, this.to)) + 1] -= 1;
    }
    let sum = 0;
    this.counts = changes.map((change) => (sum += change));
    this.drawBars();
  }

  drawBars() {
    if (!this.counts) return;
    const ctx = sized(this.canvas);
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    const most = Math.max(1, ...this.counts);
    ctx.clearRect(0, 0, width, height);
    const shape = new Path2D();
    shape.moveTo(0, height);
    for (let k = 0; k <= BARS; k++) shape.lineTo((k / BARS) * width, height - 2 - (this.counts[k] / most) * (height - 8));
    shape.lineTo(width, height);
    shape.closePath();
    ctx.fillStyle = THEMES[this.map.options.theme].tracks[0];
    ctx.globalAlpha = 0.2;
    ctx.fill(shape);
    // What lies behind is stronger.
    const share = (this.shown - this.from) / Math.max(this.to - this.from, 1e-9);
    ctx.save();
    ctx.clip(shape);
    ctx.globalAlpha = 0.3;
    ctx.fillRect(0, 0, share * width, height);
    ctx.restore();
    ctx.globalAlpha = 1;
  }
}
