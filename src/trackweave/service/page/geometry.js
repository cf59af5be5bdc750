/**
 * Where things are: places of the data, of the flat world that is drawn, and of the screen.
 *
 * The world of geographic data is Mercator's, in degrees of longitude: true to angles, so that a
 * course looks like one. The world of a plane is the plane.
 */

const METRES_PER_DEGREE = 111195.08;
export const RADIANS = Math.PI / 180;
const MOST_NORTHERN = 85;

/** What the data's coordinates are: degrees, or metres of a plane, or pixels with y downwards. */
export class Plane {
  constructor({ geographic = false, down = false } = {}) {
    this.geographic = geographic;
    this.down = down;
    this.middle = NaN; // longitudes are taken within half a turn of the first one
  }

  /** Return the world's x of a longitude, or of an x. */
  worldX(x) {
    if (!this.geographic) return x;
    if (Number.isNaN(this.middle)) this.middle = x;
    return x - 360 * Math.round((x - this.middle) / 360);
  }

  /** Return the world's y of a latitude, or of a y. */
  worldY(y) {
    if (!this.geographic) return this.down ? -y : y;
    const latitude = Math.max(-MOST_NORTHERN, Math.min(MOST_NORTHERN, y)) * RADIANS;
    return Math.asinh(Math.tan(latitude)) / RADIANS;
  }

  /** Return the data's x and y of a place of the world. */
  data(worldX, worldY) {
    if (!this.geographic) return [worldX, this.down ? -worldY : worldY];
    const longitude = worldX - 360 * Math.round(worldX / 360);
    return [longitude, Math.atan(Math.sinh(worldY * RADIANS)) / RADIANS];
  }

  /** Return how many units of the world a metre has at a height of the world. */
  perMetre(worldY) {
    return this.geographic ? Math.cosh(worldY * RADIANS) / METRES_PER_DEGREE : 1;
  }

  /** Return 1 where the world's y grows with the data's, else −1. */
  get up() {
    return this.down && !this.geographic ? -1 : 1;
  }
}

/** What part of the world the screen shows. */
export class View {
  constructor() {
    this.width = 1;
    this.height = 1;
    this.x = 0;
    this.y = 0;
    this.scale = 1; // pixels of the screen for a unit of the world
    this.version = 0;
    this.limits = { least: 1e-12, most: 1e12 };
  }

  screenX(x) {
    return (x - this.x) * this.scale + this.width / 2;
  }

  screenY(y) {
    return (this.y - y) * this.scale + this.height / 2;
  }

  worldAt(px, py) {
    return [
      (px - this.width / 2) / this.scale + this.x,
      this.y - (py - this.height / 2) / this.scale,
    ];
  }

  pan(dx, dy) {
    this.x -= dx / this.scale;
    this.y += dy / this.scale;
    this.version += 1;
  }

  /** Make everything so many times larger, and leave a place of the screen where it is. */
  zoom(factor, px = this.width / 2, py = this.height / 2) {
    const [x, y] = this.worldAt(px, py);
    this.scale = Math.max(this.limits.least, Math.min(this.limits.most, this.scale * factor));
    this.x = x - (px - this.width / 2) / this.scale;
    this.y = y + (py - this.height / 2) / this.scale;
    this.version += 1;
  }

  /** Show a box of the world, with room on each side of the screen for what lies over it. */
  fit([left, bottom, right, top], room = { left: 40, right: 40, top: 40, bottom: 40 }) {
    const across = Math.max(this.width - room.left - room.right, 50);
    const upwards = Math.max(this.height - room.top - room.bottom, 50);
    const width = Math.max(right - left, 1e-9);
    const height = Math.max(top - bottom, 1e-9);
    this.scale = Math.min(across / width, upwards / height);
    this.x = (left + right) / 2 + (room.right - room.left) / 2 / this.scale;
    this.y = (bottom + top) / 2 - (room.bottom - room.top) / 2 / this.scale;
    this.limits = { least: this.scale / 2000, most: this.scale * 20000 };
    this.version += 1;
  }

  resize(width, height) {
    this.width = width;
    this.height = height;
    this.version += 1;
  }
}

/** Return the box around places of the world, somewhat wider; null where there are none. */
export function boxAround(places) {
  let [left, bottom, right, top] = [Infinity, Infinity, -Infinity, -Infinity];
  for (const [x, y] of places) {
    if (!Number.isFinite(x + y)) continue;
    left = Math.min(left, x);
    right = Math.max(right, x);
    bottom = Math.min(bottom, y);
    top = Math.max(top, y);
  }
  return left <= right ? [left, bottom, right, top] : null;
}

/** Return half axes and angle of the ellipse of a covariance's greatest and least spread. */
export function ellipseOf(xx, xy, yy) {
  const middle = (xx + yy) / 2;
  const apart = Math.hypot((xx - yy) / 2, xy);
  return [
    Math.sqrt(Math.max(middle + apart, 0)),
    Math.sqrt(Math.max(middle - apart, 0)),
    0.5 * Math.atan2(2 * xy, xx - yy),
  ];
}
