/**
 * Symbols and vectors drawn as outlines, where no graphics processor is to be had: the same calls
 * as `Glyphs`.
 */

import { addSymbol, paintSymbols } from "./looks.js";

/** Gathers outlines of one colour and status, and paints each gathering at once. */
export class Outlines {
  constructor(ctx) {
    this.ctx = ctx;
  }

  begin(_, palette, size) {
    this.palette = palette;
    this.size = size;
    this.paths = new Map();
    this.rays = palette.colours.map(() => null);
  }

  line(colour, fromX, fromY, toX, toY) {
    const path = (this.rays[colour] ??= new Path2D());
    path.moveTo(fromX, fromY);
    path.lineTo(toX, toY);
  }

  symbol(status, colour, px, py, angle, moves) {
    const key = 3 * colour + status;
    if (!this.paths.has(key)) this.paths.set(key, new Path2D());
    addSymbol(this.paths.get(key), status, px, py, this.size, Math.sin(angle), Math.cos(angle), moves);
  }

  end(view, size) {
    const { ctx, palette } = this;
    ctx.lineWidth = 1.1;
    this.rays.forEach((path, colour) => {
      if (!path) return;
      ctx.strokeStyle = palette.colours[colour];
      ctx.stroke(path);
    });
    for (const [key, path] of this.paths) {
      paintSymbols(ctx, path, key % 3, palette.colours[Math.floor(key / 3)], palette.theme, size);
    }
  }
}
