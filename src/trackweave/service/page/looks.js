/**
 * Colours and shapes.
 *
 * The shape tells the status, so that colour is free for something else and nobody needs it to
 * read the map: an arrowhead (a disc where nothing moves) is confirmed, its outline coasts, a
 * diamond is tentative.
 */

import { COASTING, CONFIRMED, TENTATIVE } from "./store.js";

/** What each theme paints with. */
export const THEMES = {
  dark: {
    sea: "#0a111b", land: "#182330", coast: "#3d526a", grid: "#1c2938", gridText: "#5d7188",
    ring: "#22354a", ink: "#dde7f2", soft: "#8fa3b8", halo: "#0a1019", plate: "rgba(10,16,25,.72)",
    echo: "#64788e", falseAlarm: "#536478", sensor: "#ffd166", coverage: "rgba(255,209,102,.055)",
    coverageEdge: "rgba(255,209,102,.35)", select: "#ffffff", truth: "#7d8fa3",
    status: ["#e9b44c", "#4fd1a5", "#b79cf0"], lightness: 66, chroma: 82,
    tracks: ["#56c7f5", "#f7b955", "#6fdc8c", "#f58fb4", "#b6a5ff", "#f4e06d", "#ff9470", "#5fe0d2", "#c3d46a", "#9db8ff"],
  },
  light: {
    sea: "#dfe8ee", land: "#f7f5f0", coast: "#9fb0bd", grid: "#ccd8e0", gridText: "#75889a",
    ring: "#b9c8d3", ink: "#16212d", soft: "#526373", halo: "#fdfdfc", plate: "rgba(255,255,255,.78)",
    echo: "#7f8f9d", falseAlarm: "#a3b0bb", sensor: "#9a6a00", coverage: "rgba(176,126,0,.06)",
    coverageEdge: "rgba(154,106,0,.4)", select: "#000000", truth: "#8593a0",
    status: ["#a86a00", "#00795a", "#6b4bc0"], lightness: 38, chroma: 80,
    tracks: ["#0072a8", "#b35c00", "#1a7f37", "#b8286a", "#6244c4", "#857000", "#c2401c", "#00807a", "#5c7a00", "#3558c9"],
  },
};

/** By what tracks may be coloured. */
export const COLOURINGS = ["track", "status", "height", "speed"];
const STEPS = 24;
const MOST = { height: 12500, speed: 300 };

/** Gives tracks their colours: a number of a palette for each, so that like is drawn together. */
export class Palette {
  constructor(theme, by, most) {
    this.theme = THEMES[theme];
    this.by = by;
    this.most = most ?? MOST[by] ?? 1;
    const { lightness, chroma } = this.theme;
    const scale = () =>
      Array.from({ length: STEPS }, (_, k) => `hsl(${18 + (282 * k) / (STEPS - 1)} ${chroma}% ${lightness}%)`);
    this.colours = by === "track" ? this.theme.tracks : by === "status" ? this.theme.status : scale();
    this.unknown = this.colours.length;
    this.colours = [...this.colours, this.theme.soft];
  }

  /** Return the number of a track's colour at one of its rows. */
  of(course, row) {
    if (this.by === "track") return course.number % this.theme.tracks.length;
    if (this.by === "status") return course.status[row];
    const value = this.by === "height" ? course.height[row] : course.speed(row);
    if (!(value >= -1000)) return this.unknown;
    return Math.max(0, Math.min(STEPS - 1, Math.floor((value / this.most) * STEPS)));
  }
}

/** Add a track's symbol to a path: at a place of the screen, pointing along a direction. */
export function addSymbol(path, status, px, py, size, sin, cos, moves) {
  if (status === TENTATIVE) {
    const r = 0.42 * size;
    path.moveTo(px, py - r);
    path.lineTo(px + r, py);
    path.lineTo(px, py + r);
    path.lineTo(px - r, py);
    path.closePath();
    return;
  }
  if (!moves) {
    const r = 0.36 * size;
    path.moveTo(px + r, py);
    path.arc(px, py, r, 0, 2 * Math.PI);
    return;
  }
  // Forward is (sin, −cos) on the screen, to the right of it (cos, sin).
  const [tip, wing, side, notch] = [0.68 * size, -0.42 * size, 0.44 * size, -0.2 * size];
  path.moveTo(px + sin * tip, py - cos * tip);
  path.lineTo(px + sin * wing + cos * side, py - cos * wing + sin * side);
  path.lineTo(px + sin * notch, py - cos * notch);
  path.lineTo(px + sin * wing - cos * side, py - cos * wing - sin * side);
  path.closePath();
}

/** Paint symbols that share a colour and a status. */
export function paintSymbols(ctx, path, status, colour, theme, size) {
  ctx.lineJoin = "round";
  ctx.strokeStyle = theme.halo;
  if (status === CONFIRMED) {
    ctx.lineWidth = size > 10 ? 2.5 : 1.5;
    ctx.stroke(path);
    ctx.fillStyle = colour;
    ctx.fill(path);
    return;
  }
  ctx.fillStyle = theme.halo;
  ctx.fill(path);
  ctx.strokeStyle = colour;
  ctx.lineWidth = status === COASTING ? 1.6 : 1.4;
  ctx.stroke(path);
}

/** Draw one symbol on a small canvas of its own, for legends. */
export function symbolSample(status, colour, theme, moves = true) {
  const canvas = document.createElement("canvas");
  const ratio = 2;
  canvas.width = canvas.height = 18 * ratio;
  canvas.className = "sample";
  const ctx = canvas.getContext("2d");
  ctx.scale(ratio, ratio);
  const path = new Path2D();
  addSymbol(path, status, 9, 9, 15, Math.SQRT1_2, Math.SQRT1_2, moves);
  paintSymbols(ctx, path, status, colour, THEMES[theme], 15);
  return canvas;
}
