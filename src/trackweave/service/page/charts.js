/** Small curves over time. */

import { el, sized } from "./dom.js";
import { digits } from "./words.js";

/**
 * A strip with lines over time. `lines` are `{name, colour, points: [[time, value]…], dots}`.
 */
export class Strip {
  constructor(title, { height = 64, zero = true, most = null, text = digits } = {}) {
    this.title = el("span", { text: title });
    this.value = el("span", { class: "value" });
    this.canvas = el("canvas", { height, role: "img", "aria-label": title });
    this.canvas.style.height = `${height}px`;
    this.element = el("figure", { class: "strip" }, el("figcaption", {}, this.title, this.value), this.canvas);
    Object.assign(this, { zero, most, text });
  }

  /** Draw lines between two moments, with a mark at a third. */
  draw(lines, from, to, at, theme) {
    const ctx = sized(this.canvas);
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    if (!width) return;
    ctx.clearRect(0, 0, width, height);
    const values = lines.flatMap((line) => line.points.map(([, value]) => value)).filter(Number.isFinite);
    this.element.classList.toggle("empty", !values.length);
    if (!values.length) {
      this.value.textContent = "–";
      return;
    }
    const [low, high] = this.#range(values);
    const px = (time) => ((time - from) / Math.max(to - from, 1e-9)) * (width - 2) + 1;
    const py = (value) => height - 3 - ((value - low) / (high - low)) * (height - 8);
    ctx.strokeStyle = theme.grid;
    ctx.lineWidth = 1;
    ctx.strokeRect(0.5, 0.5, width - 1, height - 1);
    for (const line of lines) this.#line(ctx, line, px, py);
    ctx.fillStyle = theme.gridText;
    ctx.font = "9px system-ui, sans-serif";
    ctx.fillText(this.text(high), 4, 10);
    ctx.fillText(this.text(low), 4, height - 4);
    ctx.strokeStyle = theme.soft;
    ctx.beginPath();
    ctx.moveTo(Math.round(px(at)) + 0.5, 0);
    ctx.lineTo(Math.round(px(at)) + 0.5, height);
    ctx.stroke();
    this.value.textContent = lines
      .map((line) => (line.name ? `${line.name} ` : "") + this.text(valueAt(line.points, at)))
      .join("  ");
  }

  #range(values) {
    let low = this.zero ? 0 : Infinity;
    let high = -Infinity;
    for (const value of values) {
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
    if (this.most !== null) high = Math.max(Math.min(high, this.most), this.zero ? 0 : low);
    const room = high > low ? 0.06 * (high - low) : Math.abs(high) || 1;
    const above = this.most === null ? high + room : Math.min(high + room, Math.max(this.most, high));
    return [this.zero && low === 0 ? 0 : low - room, above];
  }

  #line(ctx, { points, colour, dots }, px, py) {
    ctx.strokeStyle = ctx.fillStyle = colour;
    ctx.lineWidth = 1.3;
    ctx.beginPath();
    let begun = false;
    for (const [time, value] of thinned(points)) {
      if (!Number.isFinite(value)) {
        begun = false;
        continue;
      }
      const [x, y] = [px(time), py(value)];
      if (dots) ctx.rect(x - 1, y - 1, 2, 2);
      else if (begun) ctx.lineTo(x, y);
      else ctx.moveTo(x, y);
      begun = true;
    }
    if (dots) ctx.fill();
    else ctx.stroke();
  }
}

function valueAt(points, time) {
  let value = NaN;
  for (const [when, what] of points) {
    if (when > time + 1e-6) break;
    value = what;
  }
  return value;
}

/** Return points, and of very many the least and greatest of each short while. */
function thinned(points) {
  const most = 700;
  if (points.length <= most) return points;
  const found = [];
  const size = Math.ceil((2 * points.length) / most);
  for (let k = 0; k < points.length; k += size) {
    const some = points.slice(k, k + size);
    const least = some.reduce((one, other) => (other[1] < one[1] ? other : one));
    const greatest = some.reduce((one, other) => (other[1] > one[1] ? other : one));
    found.push(...(least[0] <= greatest[0] ? [least, greatest] : [greatest, least]));
  }
  return found;
}
