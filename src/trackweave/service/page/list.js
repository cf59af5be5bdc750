/** The list of tracks: searched, sorted, and only the rows in sight are made. */

import { el, nameOf } from "./dom.js";
import { symbolSample } from "./looks.js";
import { STATUSES } from "./store.js";
import { counted, plain } from "./words.js";

const ROW_PIXELS = 30;

/** Return what sorts as the name does, numbers in it by their size. */
function sortKey(course) {
  if (course.keyed !== course.label) {
    course.key = course.label.slice(0, 60).toLowerCase().replace(/\d+/g, (number) => number.padStart(12, "0"));
    course.keyed = course.label;
  }
  return course.key;
}

/** A table of the tracks that live at the map's moment. */
export class TrackList {
  constructor(map, choose) {
    this.map = map;
    this.choose = choose;
    this.sort = { key: "label", falling: false };
    this.rows = [];
    this.search = el("input", {
      type: "search", placeholder: "Search by name, number or status   /", "aria-label": "Search tracks",
      oninput: () => this.refresh(), onkeydown: (event) => this.#typed(event),
    });
    this.heading = el("div", { class: "columns", role: "row" });
    this.body = el("div", { class: "rows", role: "rowgroup" });
    this.scroll = el("div", { class: "scroll", tabindex: "0", role: "table", "aria-label": "Tracks", onscroll: () => this.#paint(), onkeydown: (event) => this.#walk(event) }, this.body);
    this.none = el("p", { class: "hint" });
    this.element = el("section", { class: "list" }, this.search, this.heading, this.scroll, this.none);
    this.samples = new Map();
  }

  columns() {
    const { units, store } = this.map;
    const columns = [
      { key: "label", name: "Track", text: (course) => plain(course.label, 18), value: sortKey },
      { key: "speed", name: "Speed", text: (course, row) => units.speed(course.speed(row)), value: (course, row) => course.speed(row) },
    ];
    if (store.hasHeights) {
      const text = (course, row) => (Number.isFinite(course.height[row]) ? units.height(course.height[row]) : "–");
      columns.push({ key: "height", name: "Height", text, value: (course, row) => course.height[row] });
    } else {
      const text = (course, row) => (course.speed(row) > 1e-9 ? `${String(Math.round(course.heading(row)) % 360).padStart(3, "0")}°` : "–");
      columns.push({ key: "heading", name: "Course", text, value: (course, row) => course.heading(row) });
    }
    columns.push({ key: "age", name: "Shown", text: (course) => shortSpan(this.map.time - course.time[0]), value: (course) => -course.time[0] });
    return columns;
  }

  /** Look again who is there, and in which order. */
  refresh() {
    const wanted = this.search.value.trim().toLowerCase();
    const { instant } = this.map;
    const columns = this.columns();
    const column = columns.find(({ key }) => key === this.sort.key) ?? columns[0];
    this.rows = [];
    for (let k = 0; k < instant.n; k++) {
      const [course, row] = [instant.courses[k], instant.rows[k]];
      if (wanted && !matches(course, row, wanted)) continue;
      this.rows.push([column.value(course, row), course, row]);
    }
    const sign = this.sort.falling ? -1 : 1;
    const order = column.key === "label" ? byText : byNumber;
    this.rows.sort((one, other) => sign * order(one[0], other[0]));
    this.none.textContent = this.rows.length
      ? `${counted(this.rows.length)} of ${counted(instant.n)} tracks`
      : wanted ? "No track here has that in its name." : "No tracks at this moment.";
    this.#head(columns);
    this.#paint(columns);
  }

  #head(columns) {
    const signature = columns.map(({ name }) => name).join() + this.sort.key + this.sort.falling;
    if (signature === this.headed) return;
    this.headed = signature;
    this.heading.replaceChildren(
      ...columns.map(({ key, name }) => {
        const active = this.sort.key === key;
        const sort = !active ? "none" : this.sort.falling ? "descending" : "ascending";
        const onclick = () => {
          this.sort = { key, falling: active ? !this.sort.falling : key !== "label" };
          this.refresh();
        };
        const arrow = active ? (this.sort.falling ? " ↓" : " ↑") : "";
        return el("span", { role: "columnheader", class: key, "aria-sort": sort }, el("button", { type: "button", onclick, text: name + arrow }));
      }),
    );
  }

  #paint(columns = this.columns()) {
    const { scrollTop, clientHeight } = this.scroll;
    const first = Math.max(0, Math.floor(scrollTop / ROW_PIXELS) - 4);
    const last = Math.min(this.rows.length, first + Math.ceil(clientHeight / ROW_PIXELS) + 9);
    this.body.style.height = `${this.rows.length * ROW_PIXELS}px`;
    const made = [];
    for (let k = first; k < last; k++) made.push(this.#row(k, columns));
    this.body.replaceChildren(...made);
  }

  #row(k, columns) {
    const [, course, row] = this.rows[k];
    const chosen = course === this.map.selected;
    const line = el("div", {
      class: chosen ? "row chosen" : "row", role: "row", "aria-selected": String(chosen),
      onclick: () => this.choose(course),
    });
    line.style.transform = `translateY(${k * ROW_PIXELS}px)`;
    columns.forEach(({ key, text }, at) => {
      const cell = el("span", { role: "cell", class: key });
      if (!at) cell.append(this.#sample(course, row));
      cell.append(at ? text(course, row) : nameOf(text(course, row)));
      line.append(cell);
    });
    return line;
  }

  #sample(course, row) {
    const { palette, options } = this.map;
    const colour = palette.colours[palette.of(course, row)];
    const status = course.status[row];
    const key = `${status}${colour}${options.theme}`;
    if (!this.samples.has(key)) this.samples.set(key, symbolSample(status, colour, options.theme).toDataURL());
    return el("img", { src: this.samples.get(key), alt: STATUSES[status], title: STATUSES[status], class: "sample" });
  }

  #typed(event) {
    if (event.key === "Enter" && this.rows.length) this.choose(this.rows[0][1]);
    if (event.key === "Escape") {
      this.search.value = "";
      this.search.blur();
      this.refresh();
    }
    if (event.key === "ArrowDown") this.scroll.focus();
    event.stopPropagation();
  }

  #walk(event) {
    const step = { ArrowDown: 1, ArrowUp: -1, PageDown: 12, PageUp: -12 }[event.key];
    if (!step) return;
    event.preventDefault();
    event.stopPropagation();
    this.step(step);
  }

  /** Choose the track so many rows further down. */
  step(by) {
    if (!this.rows.length) return;
    const at = this.rows.findIndex(([, course]) => course === this.map.selected);
    const next = at < 0 ? 0 : Math.max(0, Math.min(this.rows.length - 1, at + by));
    this.choose(this.rows[next][1]);
    const top = next * ROW_PIXELS;
    const { scrollTop, clientHeight } = this.scroll;
    if (top < scrollTop || top > scrollTop + clientHeight - ROW_PIXELS) {
      this.scroll.scrollTop = top - clientHeight / 2;
    }
    this.#paint();
  }
}

function byText(one, other) {
  return one < other ? -1 : one > other ? 1 : 0;
}

function byNumber(one, other) {
  if (Number.isNaN(one) || Number.isNaN(other)) return Number.isNaN(one) - Number.isNaN(other);
  return one - other;
}

function matches(course, row, wanted) {
  return (
    course.id.toLowerCase().includes(wanted) ||
    course.label.toLowerCase().includes(wanted) ||
    STATUSES[course.status[row]].startsWith(wanted)
  );
}

function shortSpan(seconds) {
  const whole = Math.max(0, Math.floor(seconds));
  return whole < 3600
    ? `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`
    : `${(whole / 3600).toFixed(1)} h`;
}
