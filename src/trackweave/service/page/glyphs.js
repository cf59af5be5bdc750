/**
 * Symbols and vectors drawn by the graphics processor: thousands of them cost the page no more
 * than to write down where they are. Where there is none to be had, `available` is false.
 */

import { CONFIRMED, TENTATIVE } from "./store.js";

const POINT_NUMBERS = 5; // x, y, angle, kind, and four bytes of colour
const LINE_NUMBERS = 3; // x, y, and four bytes of colour
const ROOM = 2.2; // of a symbol, in its sizes

const POINTS = [
  `attribute vec4 place; attribute vec4 colour; uniform vec2 screen; uniform float side;
  varying vec4 tint; varying vec3 pose;
  void main() {
    tint = colour;
    pose = vec3(sin(place.z), cos(place.z), place.w);
    gl_Position = vec4(place.xy / screen * vec2(2, -2) + vec2(-1, 1), 0, 1);
    gl_PointSize = side;
  }`,
  `precision highp float;
  varying vec4 tint; varying vec3 pose; uniform float side; uniform float size; uniform vec3 halo;
  float edge(vec2 p, vec2 a, vec2 b, inout float inside) {
    vec2 e = b - a, w = p - a;
    vec2 d = w - e * clamp(dot(w, e) / dot(e, e), 0.0, 1.0);
    bvec3 c = bvec3(p.y >= a.y, p.y < b.y, e.x * w.y > e.y * w.x);
    if (all(c) || all(not(c))) inside = -inside;
    return dot(d, d);
  }
  float dart(vec2 p) {
    vec2 tip = vec2(0.0, 0.68), right = vec2(0.44, -0.42), notch = vec2(0.0, -0.2), left = vec2(-0.44, -0.42);
    float inside = 1.0;
    float d = edge(p, tip, right, inside);
    d = min(d, edge(p, right, notch, inside));
    d = min(d, edge(p, notch, left, inside));
    d = min(d, edge(p, left, tip, inside));
    return inside * sqrt(d);
  }
  void main() {
    vec2 p = (gl_PointCoord - 0.5) * side * vec2(1, -1) / size;
    p = vec2(p.x * pose.y - p.y * pose.x, p.x * pose.x + p.y * pose.y);
    float kind = floor(pose.z + 0.5);
    float shape = floor(kind / 2.0);
    float d = shape < 0.5 ? dart(p) : shape < 1.5 ? length(p) - 0.36 : (abs(p.x) + abs(p.y) - 0.42) * 0.7071;
    d *= size;
    bool full = mod(kind, 2.0) > 0.5;
    float line = size * 0.06 + 0.2;
    float ink = full ? clamp(0.5 - d, 0.0, 1.0) : clamp(0.5 + line - abs(d), 0.0, 1.0);
    float plate = clamp(0.5 + size * 0.1 - d, 0.0, 1.0);
    float alpha = max(ink, plate);
    if (alpha <= 0.0) discard;
    gl_FragColor = vec4(mix(halo, tint.rgb, ink) * alpha, alpha);
  }`,
];
const LINES = [
  `attribute vec2 place; attribute vec4 colour; uniform vec2 screen; varying vec4 tint;
  void main() {
    tint = colour;
    gl_Position = vec4(place / screen * vec2(2, -2) + vec2(-1, 1), 0, 1);
  }`,
  `precision highp float; varying vec4 tint;
  void main() { gl_FragColor = vec4(tint.rgb * 0.85, 0.85); }`,
];

/** A sheet of symbols and of lines from them. */
export class Glyphs {
  constructor(canvas) {
    this.canvas = canvas;
    const gl = canvas.getContext("webgl", { antialias: true, premultipliedAlpha: true });
    this.gl = gl;
    if (!gl) return;
    canvas.addEventListener("webglcontextlost", () => (this.gl = null));
    [this.points, this.lines] = [makeProgram(gl, POINTS), makeProgram(gl, LINES)];
    if (!this.points || !this.lines) {
      this.gl = null;
      return;
    }
    this.buffers = [gl.createBuffer(), gl.createBuffer()];
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    this.grow(256);
  }

  get available() {
    return this.gl !== null;
  }

  grow(room) {
    this.room = room;
    this.pointData = new Float32Array(POINT_NUMBERS * room);
    this.pointColours = new Uint32Array(this.pointData.buffer);
    this.lineData = new Float32Array(2 * LINE_NUMBERS * room);
    this.lineColours = new Uint32Array(this.lineData.buffer);
  }

  /** Begin with a sheet for so many symbols, in a palette's colours. */
  begin(many, palette) {
    if (many > this.room) this.grow(2 * many);
    if (palette !== this.palette) {
      this.palette = palette;
      this.inks = inksOf(palette.colours);
      [this.halo] = inksOf([palette.theme.halo]);
    }
    this.nLines = 0;
    this.nPoints = 0;
  }

  line(colour, fromX, fromY, toX, toY) {
    const at = 2 * LINE_NUMBERS * this.nLines++;
    const { lineData: data, lineColours: inks } = this;
    data[at] = fromX;
    data[at + 1] = fromY;
    inks[at + 2] = inks[at + 5] = this.inks[colour];
    data[at + 3] = toX;
    data[at + 4] = toY;
  }

  symbol(status, colour, px, py, angle, moves) {
    const at = POINT_NUMBERS * this.nPoints++;
    const { pointData: data } = this;
    data[at] = px;
    data[at + 1] = py;
    data[at + 2] = moves && status !== TENTATIVE ? angle : 0;
    data[at + 3] = 2 * (status === TENTATIVE ? 2 : moves ? 0 : 1) + (status === CONFIRMED ? 1 : 0);
    this.pointColours[at + 4] = this.inks[colour];
  }

  /** Show what was written down. */
  end(view, size) {
    const { gl, canvas } = this;
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [Math.round(view.width * ratio), Math.round(view.height * ratio)];
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
    }
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    const screen = [view.width, view.height];
    this.#draw(this.lines, this.buffers[0], this.lineData, LINE_NUMBERS, 2 * this.nLines, gl.LINES, screen);
    gl.useProgram(this.points.program);
    const [r, g, b] = [this.halo & 255, (this.halo >> 8) & 255, (this.halo >> 16) & 255];
    gl.uniform3f(this.points.uniform("halo"), r / 255, g / 255, b / 255);
    gl.uniform1f(this.points.uniform("size"), size * ratio);
    gl.uniform1f(this.points.uniform("side"), Math.ceil(ROOM * size * ratio));
    this.#draw(this.points, this.buffers[1], this.pointData, POINT_NUMBERS, this.nPoints, gl.POINTS, screen);
  }

  #draw({ program, uniform, place, colour }, buffer, data, numbers, count, mode, screen) {
    const { gl } = this;
    if (!count) return;
    gl.useProgram(program);
    gl.uniform2f(uniform("screen"), ...screen);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data.subarray(0, count * numbers), gl.DYNAMIC_DRAW);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, numbers - 1, gl.FLOAT, false, 4 * numbers, 0);
    gl.enableVertexAttribArray(colour);
    gl.vertexAttribPointer(colour, 4, gl.UNSIGNED_BYTE, true, 4 * numbers, 4 * (numbers - 1));
    gl.drawArrays(mode, 0, count);
  }
}

function makeProgram(gl, [vertex, fragment]) {
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) return null;
  const uniforms = new Map();
  const uniform = (name) => {
    if (!uniforms.has(name)) uniforms.set(name, gl.getUniformLocation(program, name));
    return uniforms.get(name);
  };
  return {
    program, uniform,
    place: gl.getAttribLocation(program, "place"), colour: gl.getAttribLocation(program, "colour"),
  };
}

/** Return colours as the four bytes that they have in a buffer. */
function inksOf(colours) {
  const canvas = document.createElement("canvas");
  canvas.width = colours.length;
  canvas.height = 1;
  const ctx = canvas.getContext("2d", { willReadFrequently: true });
  colours.forEach((colour, k) => {
    ctx.fillStyle = colour;
    ctx.fillRect(k, 0, 1, 1);
  });
  return new Uint32Array(ctx.getImageData(0, 0, colours.length, 1).data.buffer.slice(0));
}
