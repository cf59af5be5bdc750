/** Pictures of the Earth from a server that the configuration names, where it names one. */

import { plain } from "./words.js";

const TILE = 256;
const MOST_KEPT = 300;
const FINEST = 19;

/** A map in tiles of Mercator's, by an address with {z}, {x} and {y}. */
export class Tiles {
  constructor(address, attribution, arrived) {
    this.address = address;
    this.attribution = plain(attribution ?? "", 80);
    this.arrived = arrived;
    this.images = new Map();
  }

  draw(ctx, view) {
    const level = Math.max(0, Math.min(FINEST, Math.round(Math.log2((view.scale * 360) / TILE))));
    const count = 2 ** level;
    const side = 360 / count; // of a tile, in the world's degrees
    const [left, bottom] = view.worldAt(0, view.height);
    const [right, top] = view.worldAt(view.width, 0);
    for (let column = Math.floor((left + 180) / side); column * side - 180 < right; column++) {
      for (let row = Math.max(0, Math.floor((180 - top) / side)); row < count && 180 - row * side > bottom; row++) {
        const image = this.#image(level, ((column % count) + count) % count, row);
        if (!image.complete || !image.naturalWidth) continue;
        const size = side * view.scale;
        ctx.drawImage(image, view.screenX(column * side - 180), view.screenY(180 - row * side), size + 0.5, size + 0.5);
      }
    }
    ctx.font = "10px system-ui, sans-serif";
    ctx.textAlign = "right";
    ctx.fillStyle = "#777";
    ctx.fillText(this.attribution, view.width - 8, view.height - 8);
    ctx.textAlign = "start";
  }

  #image(z, x, y) {
    const key = `${z}/${x}/${y}`;
    let image = this.images.get(key);
    if (!image) {
      image = new Image();
      image.onload = this.arrived;
      image.src = this.address.replace("{z}", z).replace("{x}", x).replace("{y}", y);
      this.images.set(key, image);
      if (this.images.size > MOST_KEPT) this.images.delete(this.images.keys().next().value);
    }
    return image;
  }
}
