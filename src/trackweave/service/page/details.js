/** What is known of the chosen track. */

import { Strip } from "./charts.js";
import { el, iconButton, nameOf } from "./dom.js";
import { symbolSample, THEMES } from "./looks.js";
import { STATUSES } from "./store.js";
import { clockTime, counted, degrees, digits, lasting, percent, plain } from "./words.js";

/** A card of a track with its facts and their course over time. */
export class Details {
  constructor(map, { close, follow, fetchTrack }) {
    this.map = map;
    this.fetchTrack = fetchTrack;
    this.fetched = { id: null, facts: null, at: 0 };
    this.title = el("h2", {});
    this.facts = el("dl", {});
    this.follow = iconButton("target", "Keep it in the middle (c)", follow);
    this.strips = {
      speed: new Strip("Speed"),
      height: new Strip("Height", { zero: false }),
      existence: new Strip("Probability that it is there", { most: 1, text: percent }),
      innovations: new Strip("Innovations, normalised and squared (95 % below 6)", { most: 20 }),
    };
    this.element = el(
      "section", { class: "details", hidden: true },
      el("header", {}, this.title, this.follow, iconButton("close", "Close (Esc)", close)),
      this.facts,
      ...Object.values(this.strips).map((strip) => strip.element),
    );
  }

  /** Show the chosen track as it is at the map's moment. */
  refresh(now) {
    const course = this.map.selected;
    this.element.hidden = !course;
    if (!course) return;
    this.#fetch(course, now);
    const row = Math.max(course.rowAt(this.map.time), 0);
    const { palette, options } = this.map;
    const status = course.status[row];
    const sample = symbolSample(status, palette.colours[palette.of(course, row)], options.theme);
    this.title.replaceChildren(sample, nameOf(plain(course.label, 30)));
    const ended = this.map.time >= course.ended;
    this.facts.replaceChildren(
      ...this.#lines(course, row, ended).flatMap(([name, value]) => [el("dt", { text: name }), el("dd", {}, nameOf(value))]),
    );
    this.#curves(course);
  }

  /** Ask the service for what its stream does not tell: innovations. */
  #fetch(course, now) {
    if (!this.fetchTrack) return;
    if (this.fetched.id === course.id && now - this.fetched.at < 4) return;
    if (this.fetched.id !== course.id) this.fetched.facts = null;
    this.fetched.id = course.id;
    this.fetched.at = now;
    this.fetchTrack(course.id).then(
      (facts) => {
        if (this.fetched.id === course.id) this.fetched.facts = facts;
      },
      () => {},
    );
  }

  #lines(course, row, ended) {
    const { units, store, time } = this.map;
    const facts = course.facts ?? {};
    const [x, y] = store.plane.data(course.x[row], course.y[row]);
    const lines = [["Status", ended ? "ended" : STATUSES[course.status[row]]]];
    if (course.identity) lines.push(["Number", course.id]);
    lines.push(["Speed", units.speed(course.speed(row))]);
    if (course.speed(row) > 1e-9) lines.push(["Course", `${digits(course.heading(row))}°`]);
    if (Number.isFinite(course.height[row])) lines.push(["Height", units.height(course.height[row])]);
    if (store.plane.geographic) lines.push(["Place", `${degrees(y, "NS")}, ${degrees(x, "EW")}`]);
    else lines.push(["Place", `x ${units.distance(x)}, y ${units.distance(y)}`]);
    const spread = Math.sqrt((course.xx[row] + course.yy[row]) / 2);
    if (Number.isFinite(spread)) lines.push(["Known to", `± ${units.distance(spread)}`]);
    if (Number.isFinite(course.existence[row])) lines.push(["Is there", percent(course.existence[row])]);
    if (Number.isFinite(facts.visible)) lines.push(["In sight", percent(facts.visible)]);
    if (facts.hits !== undefined) lines.push(["Reports", counted(facts.hits)]);
    if (facts.sensors?.length) lines.push(["Sensors", facts.sensors.map((name) => plain(name, 20)).join(", ")]);
    lines.push(["First row", `${clockTime(course.time[0], store.calendar)} (${lasting(time - course.time[0])})`]);
    const end = ended ? clockTime(course.time[course.n - 1], store.calendar) : `${lasting(time - course.time[row])} ago`;
    lines.push(["Last row", end]);
    return lines;
  }

  #curves(course) {
    const { map } = this;
    const theme = THEMES[map.options.theme];
    const { speed, height, existence, innovations } = this.strips;
    speed.text = map.units.speed;
    height.text = map.units.height;
    const points = (value) => Array.from({ length: course.n }, (_, row) => [course.time[row], value(row)]);
    const [from, to] = [course.time[0], Math.max(course.time[course.n - 1], map.time)];
    const draw = (strip, found, dots = false) => {
      strip.element.hidden = !found.some(([, value]) => Number.isFinite(value));
      if (!strip.element.hidden) strip.draw([{ colour: theme.tracks[0], points: found, dots }], from, to, map.time, theme);
    };
    draw(speed, points((row) => course.speed(row)));
    draw(height, points((row) => course.height[row]));
    draw(existence, points((row) => course.existence[row]));
    const seen = this.fetched.id === course.id ? this.fetched.facts?.innovations ?? [] : [];
    draw(innovations, seen.map(([time, , value]) => [time, value]), true);
  }
}
