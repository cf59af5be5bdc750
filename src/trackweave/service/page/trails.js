/** Where tracks came from, and what the sensors reported. */

import { COASTING, TENTATIVE } from "./store.js";

const LEAST_STEP = 2; // pixels between the points of a trail that are drawn

/** Draw the trails of a span of time; those of tracks that have ended are fainter. */
export function drawTrails(ctx, scene) {
  const { view, store, palette, options, time, selected } = scene;
  const many = store.courses.size > 1500;
  const from = options.trail === Infinity ? -Infinity : time - options.trail;
  const paths = new Map();
  for (const course of store.courses.values()) {
    // What never was more than tentative would hide the rest.
    if (course === selected || course.n < 2 || course.confirmed > time) continue;
    const gone = time >= course.ended;
    if (course.time[course.n - 1] < from) continue;
    const last = course.rowAt(time);
    const key = 2 * palette.of(course, last) + (gone ? 1 : 0);
    if (!paths.has(key)) paths.set(key, new Path2D());
    addTrail(paths.get(key), view, course, from, last, many ? 3 * LEAST_STEP : LEAST_STEP);
  }
  ctx.lineJoin = "round";
  for (const [key, path] of paths) {
    ctx.strokeStyle = palette.colours[key >> 1];
    ctx.globalAlpha = key & 1 ? 0.38 : many ? 0.5 : 0.75;
    ctx.lineWidth = many ? 1 : 1.4;
    ctx.stroke(path);
  }
  ctx.globalAlpha = 1;
  if (selected) drawChosen(ctx, scene, from);
}

function addTrail(path, view, course, from, last, least) {
  const { scale } = view;
  const shiftX = view.width / 2 - view.x * scale;
  const shiftY = view.height / 2 + view.y * scale;
  let [drawnX, drawnY, begun, outside] = [0, 0, false, false];
  for (let row = last; row >= 0 && course.time[row] >= from; row--) {
    const x = course.x[row] * scale + shiftX;
    const y = shiftY - course.y[row] * scale;
    if (begun && Math.abs(x - drawnX) + Math.abs(y - drawnY) < least && row) continue;
    const off = x < -50 || y < -50 || x > view.width + 50 || y > view.height + 50;
    if (!begun || (off && outside)) path.moveTo(x, y);
    else path.lineTo(x, y);
    [drawnX, drawnY, begun, outside] = [x, y, true, off];
  }
}

/** Draw the trail of the chosen track, thicker, dashed where it coasts, with its rows as dots. */
function drawChosen(ctx, { view, palette, theme, time, selected }) {
  const last = selected.rowAt(time);
  if (last < 0) return;
  const parts = [new Path2D(), new Path2D()];
  let [px, py] = [NaN, NaN];
  const dots = new Path2D();
  let drawn = [NaN, NaN];
  for (let row = 0; row <= last; row++) {
    const [x, y] = [view.screenX(selected.x[row]), view.screenY(selected.y[row])];
    const part = parts[selected.status[row] === COASTING || selected.status[row] === TENTATIVE ? 1 : 0];
    if (row) {
      part.moveTo(px, py);
      part.lineTo(x, y);
    }
    if (!(Math.hypot(x - drawn[0], y - drawn[1]) < 9)) {
      dots.moveTo(x + 1.7, y);
      dots.arc(x, y, 1.7, 0, 2 * Math.PI);
      drawn = [x, y];
    }
    [px, py] = [x, y];
  }
  ctx.lineJoin = ctx.lineCap = "round";
  const colour = palette.colours[palette.of(selected, last)];
  for (const [stroke, width] of [[theme.halo, 6], [colour, 2.6]]) {
    ctx.strokeStyle = stroke;
    ctx.lineWidth = width;
    ctx.setLineDash([]);
    ctx.stroke(parts[0]);
    ctx.setLineDash(stroke === colour ? [5, 5] : []);
    ctx.stroke(parts[1]);
  }
  ctx.setLineDash([]);
  ctx.lineCap = "butt";
  ctx.fillStyle = theme.ink;
  ctx.fill(dots);
}

/** Draw reports of a span of time: dots are of tracks, crosses of none; returns the chosen one's. */
export function drawReports(ctx, { view, store, theme, options, time, selected }) {
  const from = options.trail === Infinity ? -Infinity : time - options.trail;
  const { reports } = store;
  const dots = new Path2D();
  const crosses = new Path2D();
  const chosen = new Path2D();
  const drawn = new Set();
  const arm = reports.n > 5000 ? 1.6 : 2.2;
  reports.each(from, time, (at) => {
    const px = view.screenX(reports.x[at]);
    const py = view.screenY(reports.y[at]);
    if (px < -5 || py < -5 || px > view.width + 5 || py > view.height + 5) return;
    const course = reports.course[at];
    if (course && course === selected) {
      chosen.moveTo(px + 3, py);
      chosen.arc(px, py, 3, 0, 2 * Math.PI);
      return;
    }
    // One mark for each two pixels is as many as show.
    const cell = ((px >> 1) * 8192 + (py >> 1)) * 2 + (course ? 1 : 0);
    if (drawn.has(cell)) return;
    drawn.add(cell);
    if (course) {
      dots.rect(px - 0.9, py - 0.9, 1.8, 1.8);
      return;
    }
    crosses.moveTo(px - arm, py - arm);
    crosses.lineTo(px + arm, py + arm);
    crosses.moveTo(px - arm, py + arm);
    crosses.lineTo(px + arm, py - arm);
  });
  ctx.fillStyle = theme.echo;
  ctx.globalAlpha = 0.75;
  ctx.fill(dots);
  ctx.strokeStyle = theme.falseAlarm;
  ctx.lineWidth = 1;
  ctx.stroke(crosses);
  ctx.globalAlpha = 1;
  return chosen;
}

/** Draw where targets really were, where that is known. */
export function drawTruth(ctx, { view, theme, truth, time, options }) {
  const from = options.trail === Infinity ? -Infinity : time - options.trail;
  ctx.strokeStyle = theme.truth;
  ctx.lineWidth = 1;
  ctx.setLineDash([2, 4]);
  ctx.beginPath();
  for (const target of truth) {
    let begun = false;
    for (let k = 0; k < target.time.length && target.time[k] <= time; k++) {
      if (target.time[k] < from) continue;
      const [px, py] = [view.screenX(target.x[k]), view.screenY(target.y[k])];
      if (begun) ctx.lineTo(px, py);
      else ctx.moveTo(px, py);
      begun = true;
    }
  }
  ctx.stroke();
  ctx.setLineDash([]);
}
