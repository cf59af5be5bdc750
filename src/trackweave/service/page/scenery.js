/** What lies beneath the tracks: land, a grid with its numbers, sensors and what they see. */

import { drawLand } from "./coast.js";
import { RADIANS } from "./geometry.js";
import { degrees, plain, roundStep } from "./words.js";

/** Draw all of it. `options` says what is wanted; `rings` is the land, null for none. */
export function drawScenery(ctx, scene) {
  const { view, store, theme, options, rings, tiles } = scene;
  ctx.fillStyle = theme.sea;
  ctx.fillRect(0, 0, view.width, view.height);
  if (!store.plane) return;
  if (tiles) tiles.draw(ctx, view);
  else if (rings && options.land) drawLand(ctx, view, rings, theme);
  if (options.grid) drawGrid(ctx, scene);
  if (options.sensors) drawSensors(ctx, scene);
}

function drawGrid(ctx, { view, store, theme, units }) {
  const { plane } = store;
  ctx.strokeStyle = theme.grid;
  ctx.fillStyle = theme.gridText;
  ctx.lineWidth = 1;
  ctx.font = "10px system-ui, sans-serif";
  const [left, bottom] = view.worldAt(0, view.height);
  const [right, top] = view.worldAt(view.width, 0);
  const unit = plane.geographic ? 1 : units.unit;
  const step = gridStep((130 / view.scale) / unit, plane.geographic) * unit;
  const [, south] = plane.data(0, bottom);
  const [, north] = plane.data(0, top);
  ctx.beginPath();
  const texts = [];
  for (let x = Math.ceil(left / step) * step; x <= right; x += step) {
    const px = Math.round(view.screenX(x)) + 0.5;
    ctx.moveTo(px, 0);
    ctx.lineTo(px, view.height);
    texts.push([gridText(plane.data(x, 0)[0], step, plane, units, "EW"), px + 4, view.height - 6]);
  }
  const [low, high] = [Math.min(south, north), Math.max(south, north)];
  for (let y = Math.ceil(low / step) * step; y <= high; y += step) {
    const py = Math.round(view.screenY(plane.worldY(y))) + 0.5;
    ctx.moveTo(0, py);
    ctx.lineTo(view.width, py);
    texts.push([gridText(y, step, plane, units, "NS"), 6, py - 4]);
  }
  ctx.stroke();
  for (const [text, px, py] of texts) ctx.fillText(text, px, py);
}

function gridStep(least, geographic) {
  if (!geographic || least > 5) return roundStep(least * 2.2);
  // Parts of a degree that people know: minutes, or tenths and hundredths of them.
  const steps = [1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 1, 2, 5, 10];
  return steps.find((step) => step >= least) ?? 10;
}

function gridText(value, step, plane, units, letters) {
  const rounded = Math.abs(value) < step / 2 ? 0 : value;
  if (!plane.geographic) return units.ruler(Math.abs(rounded)).replace(/^/, rounded < 0 ? "−" : "");
  const places = step >= 1 ? 0 : step >= 0.1 ? (step === 0.25 ? 2 : 1) : Math.ceil(-Math.log10(step));
  return degrees(rounded, letters, places);
}

function drawSensors(ctx, { view, store, theme, options, units }) {
  for (const sensor of store.sensors) {
    const place = store.sensorPlace(sensor);
    if (sensor.coverage?.length > 2) drawCoverage(ctx, view, store.plane, theme, sensor.coverage);
    if (!place) continue;
    const [px, py] = [view.screenX(place[0]), view.screenY(place[1])];
    if (options.rings) drawRings(ctx, view, store.plane, theme, units, place);
    ctx.strokeStyle = theme.halo;
    ctx.fillStyle = sensor.silent ? theme.soft : theme.sensor;
    ctx.lineWidth = 3;
    ctx.beginPath();
    ctx.moveTo(px, py - 7);
    ctx.lineTo(px + 6, py + 5);
    ctx.lineTo(px - 6, py + 5);
    ctx.closePath();
    ctx.stroke();
    ctx.fill();
    ctx.font = "600 11px system-ui, sans-serif";
    ctx.textAlign = "center";
    ctx.strokeText(plain(sensor.name, 24), px, py + 18);
    ctx.fillText(plain(sensor.name, 24), px, py + 18);
    ctx.textAlign = "start";
  }
}

function drawCoverage(ctx, view, plane, theme, outline) {
  ctx.beginPath();
  for (const [x, y] of outline) ctx.lineTo(view.screenX(plane.worldX(x)), view.screenY(plane.worldY(y)));
  ctx.closePath();
  ctx.fillStyle = theme.coverage;
  ctx.fill();
  ctx.strokeStyle = theme.coverageEdge;
  ctx.lineWidth = 1;
  ctx.setLineDash([4, 4]);
  ctx.stroke();
  ctx.setLineDash([]);
}

/** Draw circles of round distances about a sensor. */
function drawRings(ctx, view, plane, theme, units, [x, y]) {
  const pixels = view.scale * plane.perMetre(y);
  const step = roundStep((0.42 * Math.min(view.width, view.height)) / pixels / units.unit) * units.unit;
  const [px, py] = [view.screenX(x), view.screenY(y)];
  const far = Math.hypot(Math.max(px, view.width - px), Math.max(py, view.height - py));
  const begin = Math.max(1, Math.floor((Math.hypot(Math.max(0, -px, px - view.width), Math.max(0, -py, py - view.height))) / (step * pixels)));
  ctx.strokeStyle = theme.ring;
  ctx.fillStyle = theme.gridText;
  ctx.lineWidth = 1;
  ctx.font = "10px system-ui, sans-serif";
  for (let k = begin; k < begin + 12 && k * step * pixels < far; k++) {
    const radius = k * step * pixels;
    ctx.beginPath();
    ctx.arc(px, py, radius, 0, 2 * Math.PI);
    ctx.stroke();
    const [tx, ty] = [px + radius * Math.sin(35 * RADIANS), py - radius * Math.cos(35 * RADIANS)];
    ctx.fillText(units.ruler(k * step), tx + 3, ty - 3);
  }
}
