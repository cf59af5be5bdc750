/** A whole run at once: columns of whole numbers, each the step from the one before it. */

import { Reports, Store } from "./store.js";

const UNKNOWN_HEIGHT = -1e6;

/** Return a store of all that a run's columns hold, with `truth` beside it. */
export function loadRun(run) {
  const store = new Store({ keep: Infinity, geographic: run.geographic, down: run.down });
  store.calendar = run.calendar;
  store.first = run.from;
  store.latest = run.to;
  store.sensors = run.sensors;
  const { plane } = store;
  if (run.geographic) plane.middle = run.middle;
  const courses = loadTracks(store, run);
  loadReports(store, run, courses);
  store.truth = loadTruth(run, plane);
  return store;
}

/** Return numbers, each the sum of the steps up to it, times a unit. */
function summed(steps, unit, begin = 0, end = steps.length) {
  const values = new Float64Array(end - begin);
  let sum = 0;
  for (let k = begin; k < end; k++) {
    sum += steps[k];
    values[k - begin] = sum * unit;
  }
  return values;
}

function loadTracks(store, run) {
  const { plane } = store;
  const { rows } = run;
  let begin = 0;
  return run.tracks.map(({ id, identity, n, ended, gaps, hits }) => {
    const course = store.course(id);
    course.identity = identity ?? "";
    course.label = course.identity || id;
    course.facts = { hits };
    course.grow(n);
    const end = begin + n;
    const take = (name, unit) => summed(rows[name], unit, begin, end);
    const time = take("time", run.unit_s);
    const [x, y] = [take("x", run.unit), take("y", run.unit)];
    const [vx, vy] = [take("vx", 0.01), take("vy", 0.01)];
    const height = rows.height ? take("height", 1) : null;
    const [sx, sy, rho] = [take("sx", 1), take("sy", 1), take("rho", 0.01)];
    const existence = rows.existence ? take("existence", 0.001) : null;
    for (let k = 0; k < n; k++) {
      const [spreadX, spreadY] = [Math.exp(sx[k] / 50), Math.exp(sy[k] / 50)];
      course.push(run.from + time[k], rows.status[begin + k], [
        plane.worldX(x[k]), plane.worldY(y[k]), vx[k], vy[k], height && height[k] > UNKNOWN_HEIGHT ? height[k] : NaN,
        spreadX * spreadX, rho[k] * spreadX * spreadY, spreadY * spreadY,
        existence ? existence[k] : NaN,
      ]);
    }
    course.gaps = gaps.map((gap) => gap.map((time) => run.from + time * run.unit_s));
    course.ended = ended === null ? Infinity : run.from + ended * run.unit_s;
    if (height) store.hasHeights = true;
    begin = end;
    return course;
  });
}

function loadReports(store, run, courses) {
  const { reports } = run;
  if (!reports) return;
  const { plane } = store;
  const time = summed(reports.time, run.unit_s);
  const [x, y] = [summed(reports.x, run.unit), summed(reports.y, run.unit)];
  store.reports = new Reports(Math.max(time.length, 1));
  run.sensors.forEach((sensor) => store.sensorCode(sensor.name));
  for (let k = 0; k < time.length; k++) {
    const course = reports.track[k] < 0 ? null : courses[reports.track[k]] ?? null;
    store.reports.push(run.from + time[k], plane.worldX(x[k]), plane.worldY(y[k]), reports.sensor[k], course);
  }
}

function loadTruth(run, plane) {
  return run.truth.map((target) => ({
    time: summed(target.time, run.unit_s).map((time) => run.from + time),
    x: summed(target.x, run.unit).map((x) => plane.worldX(x)),
    y: summed(target.y, run.unit).map((y) => plane.worldY(y)),
  }));
}
