/**
 * What is known: the tracks and what became of them, sensors, reports and the service's state.
 *
 * It takes the stream's messages as they come, or the columns of a whole run at once. Nothing here
 * draws, and nothing reads a clock but through the argument `now`.
 */

import { Plane } from "./geometry.js";

export const STATUSES = ["tentative", "confirmed", "coasting"];
export const [TENTATIVE, CONFIRMED, COASTING] = [0, 1, 2];
const MOST_ROWS = 256;
const MOST_REPORTS = 60000;
const CURVE_S = 600;
const FORGET_S = 10;
// The longest time for which a track is drawn beyond what is known of it.
const LONGEST_AHEAD_S = 12;
const COLUMNS = ["x", "y", "vx", "vy", "height", "xx", "xy", "yy", "existence"];

/** The rows of one track, in order of time, as columns that grow. */
export class Course {
  constructor(id, number, room = 8) {
    this.id = id;
    this.number = number; // which in order of appearance: colours go by it
    this.label = id;
    this.identity = "";
    this.facts = {};
    this.n = 0;
    this.row = 0; // where the last question ended, for the next lies near
    this.ended = Infinity;
    this.gaps = []; // spans for which it was lost
    this.period = 4;
    this.confirmed = Infinity; // when it first was more than tentative
    this.corner = 0; // where its label stands
    this.grow(room);
  }

  grow(room) {
    const wider = (old, kind) => {
      const column = new kind(room);
      if (old) column.set(old.subarray(0, Math.min(this.n, room)));
      return column;
    };
    this.time = wider(this.time, Float64Array);
    this.status = wider(this.status, Uint8Array);
    for (const name of COLUMNS) {
      this[name] = wider(this[name], name === "x" || name === "y" ? Float64Array : Float32Array);
    }
  }

  push(time, status, values) {
    if (this.n === this.time.length) {
      if (this.n >= MOST_ROWS) this.thin();
      else this.grow(2 * this.n);
    }
    const row = this.n++;
    this.time[row] = time;
    this.status[row] = status;
    if (status !== TENTATIVE && this.confirmed === Infinity) this.confirmed = time;
    COLUMNS.forEach((name, k) => (this[name][row] = values[k]));
    if (row) this.period += 0.1 * (Math.min(time - this.time[row - 1], 60) - this.period);
  }

  /** Leave out every second row of the older half. */
  thin() {
    const half = this.n >> 1;
    let kept = 0;
    for (let row = 0; row < this.n; row++) {
      if (row && row < half && row % 2) continue;
      this.time[kept] = this.time[row];
      this.status[kept] = this.status[row];
      for (const name of COLUMNS) this[name][kept] = this[name][row];
      kept++;
    }
    this.n = kept;
    this.row = 0;
  }

  /** Return the last row that is not after a time, −1 where there is none. */
  rowAt(time) {
    let row = Math.min(this.row, this.n - 1);
    if (row >= 0 && this.time[row] <= time && (row + 1 >= this.n || this.time[row + 1] > time)) {
      return row;
    }
    let [low, high] = [0, this.n];
    while (low < high) {
      row = (low + high) >> 1;
      if (this.time[row] <= time) low = row + 1;
      else high = row;
    }
    this.row = Math.max(low - 1, 0);
    return low - 1;
  }

  /** Take note that the track is back after it had ended. */
  resume(time) {
    if (this.ended < time) this.gaps.push([this.ended, time]);
    this.ended = Infinity;
  }

  /** Return whether the track lives at a time. */
  lives(time) {
    if (!this.n || this.time[0] > time || time >= this.ended) return false;
    return !this.gaps.some(([from, to]) => from <= time && time < to);
  }

  speed(row) {
    return Math.hypot(this.vx[row], this.vy[row]);
  }

  /** Return the course over ground [degrees clockwise from north]. */
  heading(row) {
    return (Math.atan2(this.vx[row], this.vy[row]) * (180 / Math.PI) + 360) % 360;
  }
}

/** Reports of the last while, oldest first, in a ring. */
export class Reports {
  constructor(room = MOST_REPORTS) {
    this.room = room;
    this.n = 0;
    this.next = 0;
    this.time = new Float64Array(room);
    this.x = new Float64Array(room);
    this.y = new Float64Array(room);
    this.sensor = new Uint16Array(room);
    this.course = new Array(room).fill(null);
  }

  push(time, x, y, sensor, course) {
    const at = this.next;
    this.time[at] = time;
    this.x[at] = x;
    this.y[at] = y;
    this.sensor[at] = sensor;
    this.course[at] = course;
    this.next = (at + 1) % this.room;
    this.n = Math.min(this.n + 1, this.room);
  }

  /** Call with the place of each report of a span of time. */
  each(from, to, visit) {
    for (let k = 0; k < this.n; k++) {
      const at = (this.next - 1 - k + 2 * this.room) % this.room;
      if (this.time[at] > to) continue;
      if (this.time[at] < from) return;
      visit(at);
    }
  }
}

/** All that is known. */
export class Store {
  constructor({ keep = 3600, geographic = null, down = false } = {}) {
    this.keep = keep;
    this.down = down;
    this.plane = geographic === null ? null : new Plane({ geographic, down });
    this.calendar = false;
    this.courses = new Map();
    this.count = 0;
    this.first = NaN;
    this.latest = NaN;
    this.heard = 0; // when the latest message came, by the page's own clock [s]
    this.sensors = [];
    this.sensorCodes = new Map();
    this.sensorNames = [];
    this.reports = new Reports();
    this.status = {};
    this.curves = []; // [time, values] of the service's state or of the run's scans
    this.version = 0;
    this.hasHeights = false;
    this.forgot = -Infinity;
  }

  /** Take a message of the stream that came at a moment of the page's clock [s]. */
  take(message, now = 0) {
    const takers = {
      tracks: () => this.#tracks(message, now),
      sensors: () => this.#sensors(message),
      status: () => this.#status(message),
      reports: () => this.#reports(message),
    };
    const taker = takers[message?.type];
    if (!taker) return false;
    taker();
    this.version += 1;
    return true;
  }

  /** Return the moment that the data has reached by now, somewhat beyond its latest message. */
  timeAt(now) {
    return this.latest + Math.max(0, Math.min(now - this.heard, LONGEST_AHEAD_S));
  }

  sensorCode(name) {
    let code = this.sensorCodes.get(name);
    if (code === undefined) {
      code = Math.min(this.sensorNames.length, 65535);
      this.sensorCodes.set(name, code);
      this.sensorNames.push(name);
    }
    return code;
  }

  course(id) {
    let course = this.courses.get(id);
    if (!course) {
      course = new Course(id, this.count++);
      this.courses.set(id, course);
    }
    return course;
  }

  #begin(geographic, time) {
    if (!this.plane) this.plane = new Plane({ geographic, down: this.down });
    if (Number.isNaN(this.first) && Number.isFinite(time)) {
      this.first = time;
      this.calendar = time > 1e8;
    }
  }

  #tracks(message, now) {
    const changed = message.changed ?? [];
    const geographic = message.geographic ?? (changed.length ? changed[0].longitude !== undefined : undefined);
    if (geographic !== undefined) this.#begin(geographic, message.time);
    if (message.full) {
      // Who is not in a full picture is gone.
      const here = new Set(changed.map((track) => String(track.track)));
      for (const course of this.courses.values()) {
        if (!here.has(course.id) && course.ended === Infinity) course.ended = message.time;
      }
    }
    for (const track of changed) this.#row(track);
    for (const id of message.ended ?? []) {
      const course = this.courses.get(String(id));
      if (course) course.ended = Math.min(course.ended, message.time);
    }
    if (Number.isFinite(message.time)) {
      this.latest = Number.isNaN(this.latest) ? message.time : Math.max(this.latest, message.time);
      this.heard = now;
    }
    this.#forget();
  }

  #row(track) {
    const plane = this.plane;
    const course = this.course(String(track.track));
    const [across, up] = plane.geographic ? [track.longitude, track.latitude] : [track.x, track.y];
    if (!Number.isFinite(across + up)) return;
    const time = Number.isFinite(track.time) ? track.time : this.latest;
    const height = track.height_m ?? track.z ?? NaN;
    if (Number.isFinite(height)) this.hasHeights = true;
    course.identity = track.identity ? String(track.identity) : course.identity;
    course.label = course.identity || course.id;
    course.resume(time);
    course.facts = track;
    const last = course.n - 1;
    if (last >= 0 && time <= course.time[last]) course.n = Math.max(course.rowAt(time - 1e-9) + 1, 0);
    const [xx, xy, yy] = track.covariance ?? [NaN, NaN, NaN];
    course.push(time, Math.max(STATUSES.indexOf(track.status), 0), [
      plane.worldX(across), plane.worldY(up), track.vx ?? 0, track.vy ?? 0, height, xx, xy, yy,
      track.existence ?? NaN,
    ]);
  }

  #sensors(message) {
    this.sensors = message.sensors ?? [];
  }

  #status(message) {
    this.status = message;
    const time = message.time ?? this.latest;
    if (!Number.isFinite(time)) return;
    this.curves.push([time, message]);
    while (this.curves.length && this.curves[0][0] < time - CURVE_S) this.curves.shift();
  }

  #reports(message) {
    const rows = message.rows ?? [];
    if (!this.plane) return;
    for (const [x, y, sensor, track] of rows) {
      if (!Number.isFinite(x + y)) continue;
      const course = track === null || track === undefined ? null : this.course(String(track));
      const code = this.sensorCode(String(sensor));
      this.reports.push(message.time, this.plane.worldX(x), this.plane.worldY(y), code, course);
    }
  }

  /** Forget tracks that ended before what is kept. */
  #forget() {
    if (this.latest - this.forgot < FORGET_S) return;
    this.forgot = this.latest;
    for (const [id, course] of this.courses) {
      if (course.ended < this.latest - this.keep) this.courses.delete(id);
    }
  }

  /** Return all places of the world that tracks, sensors and reports have been at. */
  *places(time = Infinity) {
    for (const course of this.courses.values()) {
      for (let row = 0; row < course.n && course.time[row] <= time; row++) {
        yield [course.x[row], course.y[row]];
      }
    }
    for (const sensor of this.sensors) {
      const place = this.sensorPlace(sensor);
      if (place) yield place;
    }
  }

  /** Return where a sensor stands in the world, null where nobody said. */
  sensorPlace(sensor) {
    if (!this.plane) return null;
    const told = this.plane.geographic ? [sensor.longitude, sensor.latitude] : [sensor.x, sensor.y];
    const [x, y] = Number.isFinite(told[0]) ? told : sensor.place ?? told;
    if (!Number.isFinite(x) || !Number.isFinite(y)) return null;
    return [this.plane.worldX(x), this.plane.worldY(y)];
  }
}

/** The tracks that live at one moment, and where they are then, as columns. */
export class Instant {
  constructor() {
    this.n = 0;
    this.time = NaN;
    this.courses = [];
    this.rows = new Int32Array(64);
    this.x = new Float64Array(64);
    this.y = new Float64Array(64);
  }

  /** Fill it with the tracks of a moment, each moved on along its velocity since its row. */
  fill(store, time) {
    if (this.rows.length < store.courses.size) {
      const room = 2 * store.courses.size;
      this.rows = new Int32Array(room);
      this.x = new Float64Array(room);
      this.y = new Float64Array(room);
    }
    const { plane } = store;
    let n = 0;
    for (const course of store.courses.values()) {
      if (!course.lives(time)) continue;
      const row = course.rowAt(time);
      const ahead = Math.min(time - course.time[row], 1.5 * course.period, LONGEST_AHEAD_S);
      const perMetre = plane.perMetre(course.y[row]) * ahead;
      this.courses[n] = course;
      this.rows[n] = row;
      this.x[n] = course.x[row] + course.vx[row] * perMetre;
      this.y[n] = course.y[row] + course.vy[row] * perMetre * plane.up;
      n++;
    }
    this.courses.length = n;
    this.n = n;
    this.time = time;
  }
}
