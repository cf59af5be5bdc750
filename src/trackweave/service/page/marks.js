/** The tracks of one moment: ellipses, vectors, symbols, labels, and what is chosen. */

import { ellipseOf } from "./geometry.js";
import { Outlines } from "./outlines.js";
import { COASTING, CONFIRMED, TENTATIVE } from "./store.js";
import { plain } from "./words.js";

const AHEAD_S = [1, 2, 5, 10, 20, 30, 60, 120, 300, 600];
const VECTOR_PIXELS = 34;
const MOVING_PIXELS = 2.5; // a vector shorter than this is no movement to be seen
const MOST_LABELS = 260;
const MOST_TRIED = 500;
const MOST_ELLIPSES = 700;
const CELL = 9;
const WIDE_PIXELS = 110;

/** Draw the tracks of a moment. Leaves their places on the screen in `scene.places`. */
export function drawMarks(ctx, scene) {
  const places = locate(scene);
  const size = places.shown > 2500 ? 8 : places.shown > 800 ? 10.5 : 14;
  const pen = scene.glyphs?.available ? scene.glyphs : new Outlines(ctx);
  if (scene.options.ellipses) drawEllipses(ctx, scene, places);
  scene.ahead = vectorTime(scene, places);
  pen.begin(places.shown, scene.palette, size);
  if (scene.options.vectors) addVectors(pen, scene, places, size);
  addSymbols(pen, scene, places);
  pen.end(scene.view, size);
  drawChosenMark(ctx, scene, places, size);
  if (scene.options.labels !== "none") drawLabels(ctx, scene, places, size);
}

/** Find where tracks are on the screen; n of them, those outside marked by NaN. */
function locate(scene) {
  const { view, instant } = scene;
  const places = scene.places ?? { px: new Float32Array(0), py: new Float32Array(0) };
  if (places.px.length < instant.n) {
    places.px = new Float32Array(2 * instant.n);
    places.py = new Float32Array(2 * instant.n);
  }
  let shown = 0;
  for (let k = 0; k < instant.n; k++) {
    const px = view.screenX(instant.x[k]);
    const py = view.screenY(instant.y[k]);
    const inside = px > -30 && py > -30 && px < view.width + 30 && py < view.height + 30;
    places.px[k] = inside ? px : NaN;
    places.py[k] = py;
    shown += inside ? 1 : 0;
  }
  places.shown = shown;
  scene.places = places;
  return places;
}

/** Return how far ahead vectors point [s]: so that most are of a length that shows. */
function vectorTime({ view, store, instant, ahead }, places) {
  const speeds = [];
  const stride = Math.max(1, Math.floor(instant.n / 200));
  for (let k = 0; k < instant.n; k += stride) {
    if (Number.isNaN(places.px[k])) continue;
    const pixels = view.scale * store.plane.perMetre(instant.y[k]);
    const speed = instant.courses[k].speed(instant.rows[k]) * pixels;
    if (speed > 0) speeds.push(speed);
  }
  if (!speeds.length) return ahead ?? AHEAD_S[0];
  speeds.sort((one, other) => one - other);
  const pixels = places.shown > 150 ? 0.6 * VECTOR_PIXELS : VECTOR_PIXELS;
  const wanted = pixels / speeds[Math.floor(0.7 * (speeds.length - 1))];
  // What was chosen before stays until it is clearly off.
  if (ahead && wanted > 0.45 * ahead && wanted < 2.2 * ahead) return ahead;
  return AHEAD_S.reduce((best, time) =>
    Math.abs(Math.log(time / wanted)) < Math.abs(Math.log(best / wanted)) ? time : best,
  );
}

function addVectors(pen, { view, store, instant, palette, ahead }, places, size) {
  const most = 0.35 * view.width;
  const { up } = store.plane;
  for (let k = 0; k < instant.n; k++) {
    const px = places.px[k];
    if (Number.isNaN(px)) continue;
    const [course, row] = [instant.courses[k], instant.rows[k]];
    if (course.status[row] === TENTATIVE) continue;
    const pixels = view.scale * store.plane.perMetre(instant.y[k]) * ahead;
    const dx = course.vx[row] * pixels;
    const dy = -course.vy[row] * pixels * up;
    const long = dx * dx + dy * dy;
    if (long < 0.5 * size * size || !(long < most * most)) continue;
    pen.line(palette.of(course, row), px, places.py[k], px + dx, places.py[k] + dy);
  }
}

function addSymbols(pen, { view, store, instant, palette, ahead }, places) {
  const { up } = store.plane;
  // The surest lie on top.
  for (const wanted of [TENTATIVE, COASTING, CONFIRMED]) {
    for (let k = 0; k < instant.n; k++) {
      const [course, row] = [instant.courses[k], instant.rows[k]];
      if (course.status[row] !== wanted || Number.isNaN(places.px[k])) continue;
      const [vx, vy] = [course.vx[row], course.vy[row] * up];
      const pixels = ahead * view.scale * store.plane.perMetre(instant.y[k]);
      const moves = (vx * vx + vy * vy) * pixels * pixels > MOVING_PIXELS * MOVING_PIXELS;
      pen.symbol(wanted, palette.of(course, row), places.px[k], places.py[k], Math.atan2(vx, vy), moves);
    }
  }
}

/** Draw where each object is with a probability of 95 %, of those whose ellipse shows. */
function drawEllipses(ctx, { view, store, instant, palette, theme }, places) {
  const paths = palette.colours.map(() => null);
  const wide = new Path2D();
  let drawn = 0;
  for (let k = 0; k < instant.n && drawn < MOST_ELLIPSES; k++) {
    if (Number.isNaN(places.px[k])) continue;
    const [course, row] = [instant.courses[k], instant.rows[k]];
    const [long, short, angle] = ellipseOf(course.xx[row], course.xy[row], course.yy[row]);
    const pixels = 2.4477 * view.scale * store.plane.perMetre(instant.y[k]);
    if (!(long * pixels > 5) || long * pixels > 2 * view.width) continue;
    // One that covers half the map would hide what lies beneath it.
    const path = long * pixels > WIDE_PIXELS ? wide : (paths[palette.of(course, row)] ??= new Path2D());
    const turned = -angle * store.plane.up;
    const [px, py, a] = [places.px[k], places.py[k], long * pixels];
    path.moveTo(px + a * Math.cos(turned), py + a * Math.sin(turned));
    path.ellipse(px, py, a, Math.max(short * pixels, 1), turned, 0, 2 * Math.PI);
    drawn++;
  }
  paths.forEach((path, number) => {
    if (!path) return;
    ctx.strokeStyle = ctx.fillStyle = palette.colours[number];
    ctx.lineWidth = 1;
    ctx.globalAlpha = 0.1;
    ctx.fill(path);
    ctx.globalAlpha = 0.55;
    ctx.stroke(path);
  });
  ctx.globalAlpha = 0.5;
  ctx.strokeStyle = theme.soft;
  ctx.setLineDash([3, 5]);
  ctx.stroke(wide);
  ctx.setLineDash([]);
  ctx.globalAlpha = 1;
}

/** Frame what is chosen, and ring what the pointer is on. */
function drawChosenMark(ctx, { instant, theme, selected, hovered }, places, size) {
  for (let k = 0; k < instant.n; k++) {
    const course = instant.courses[k];
    if ((course !== selected && course !== hovered) || Number.isNaN(places.px[k])) continue;
    const [px, py] = [places.px[k], places.py[k]];
    ctx.strokeStyle = theme.select;
    ctx.lineWidth = 1.6;
    ctx.beginPath();
    if (course === selected) {
      const [half, arm] = [size + 1, 6];
      for (const [sx, sy] of [[-1, -1], [1, -1], [1, 1], [-1, 1]]) {
        ctx.moveTo(px + sx * half, py + sy * (half - arm));
        ctx.lineTo(px + sx * half, py + sy * half);
        ctx.lineTo(px + sx * (half - arm), py + sy * half);
      }
    } else {
      ctx.arc(px, py, size, 0, 2 * Math.PI);
    }
    ctx.stroke();
  }
}

/** Write names beside the tracks, as many as find room; the chosen one's always. */
function drawLabels(ctx, scene, places, size) {
  const { view, instant, selected, hovered, options } = scene;
  const across = Math.ceil(view.width / CELL) + 2;
  const taken = new Uint8Array(across * (Math.ceil(view.height / CELL) + 2));
  for (let k = 0; k < instant.n; k++) {
    const [px, py] = [places.px[k], places.py[k]];
    if (!(px >= 0 && py >= 0 && px < view.width && py < view.height)) continue;
    taken[Math.floor(py / CELL) * across + Math.floor(px / CELL)] = 1;
  }
  ctx.textBaseline = "middle";
  ctx.lineWidth = 1;
  const write = (k, whole) => {
    const course = instant.courses[k];
    const lines = labelLines(scene, course, instant.rows[k], whole);
    return writeLabel(ctx, scene, { course, lines, px: places.px[k], py: places.py[k], taken, across, size });
  };
  for (const course of [selected, hovered]) {
    const k = course ? instant.courses.indexOf(course) : -1;
    if (k >= 0 && !Number.isNaN(places.px[k])) write(k, true);
  }
  // The oldest come first; where there are very many, most would find no room.
  let [written, tried] = [0, 0];
  for (let k = 0; k < instant.n && written < MOST_LABELS && tried < MOST_TRIED; k++) {
    const [course, row] = [instant.courses[k], instant.rows[k]];
    if (Number.isNaN(places.px[k]) || course.status[row] === TENTATIVE || course === selected || course === hovered) continue;
    tried++;
    if (write(k, options.labels === "full")) written++;
  }
  ctx.textBaseline = "alphabetic";
}

function labelLines({ units, store }, course, row, whole) {
  if (!course.title) course.title = plain(course.label, 14);
  if (course.titled !== course.label) {
    course.title = plain(course.label, 14);
    course.titled = course.label;
  }
  const lines = [course.title];
  if (whole) {
    const height = course.height[row];
    lines.push(units.speed(course.speed(row)) + (store.hasHeights && Number.isFinite(height) ? `  ${units.height(height)}` : ""));
  }
  return lines;
}

/** Find room for a label about its symbol and write it there; return whether there was any. */
function writeLabel(ctx, scene, label) {
  const { view, theme, palette, instant, selected, hovered } = scene;
  const { course, lines, px, py, taken, across, size } = label;
  const width = 6.4 * Math.max(...lines.map((line) => line.length)) + 6;
  const height = 13 * lines.length + 2;
  const [near, away] = [0.6 * size + 4, 0.4 * size + 2];
  const corners = [
    [near, -away - height], [near, away], [-near - width, -away - height], [-near - width, away],
  ];
  const first = course === selected || course === hovered;
  for (let k = 0; k < 4; k++) {
    const corner = (course.corner + k) % 4;
    const [left, top] = [px + corners[corner][0], py + corners[corner][1]];
    if (left < 0 || top < 0 || left + width > view.width || top + height > view.height) continue;
    if (!claim(taken, across, left, top, width, height, first)) continue;
    course.corner = corner;
    ctx.fillStyle = theme.plate;
    ctx.fillRect(left, top, width, height);
    if (first) {
      ctx.strokeStyle = theme.soft;
      ctx.strokeRect(left - 0.5, top - 0.5, width + 1, height + 1);
    }
    lines.forEach((line, at) => {
      ctx.fillStyle = at || course.status[course.rowAt(instant.time)] === COASTING ? theme.soft : theme.ink;
      ctx.font = at ? "10.5px ui-monospace, monospace" : "600 11px ui-monospace, monospace";
      ctx.fillText(line, left + 3, top + 8 + 13 * at);
    });
    ctx.fillStyle = palette.colours[palette.of(course, course.rowAt(instant.time))];
    ctx.fillRect(corners[corner][0] > 0 ? left : left + width - 1.5, top, 1.5, height);
    return true;
  }
  return false;
}

function claim(taken, across, left, top, width, height, force) {
  const [x0, x1] = [Math.floor(left / CELL), Math.floor((left + width) / CELL)];
  const [y0, y1] = [Math.floor(top / CELL), Math.floor((top + height) / CELL)];
  for (let y = y0; y <= y1 && !force; y++) {
    for (let x = x0; x <= x1; x++) if (taken[y * across + x]) return false;
  }
  for (let y = y0; y <= y1; y++) taken.fill(1, y * across + x0, y * across + x1 + 1);
  return true;
}

/** Return the track nearest to a place of the screen, null where none is near. */
export function trackAt({ instant, places }, x, y, reach) {
  let [best, nearest] = [null, reach * reach];
  for (let k = 0; k < instant.n && places; k++) {
    const apart = (places.px[k] - x) ** 2 + (places.py[k] - y) ** 2;
    if (apart < nearest) [best, nearest] = [instant.courses[k], apart];
  }
  return best;
}
