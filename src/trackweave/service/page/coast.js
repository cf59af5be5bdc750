/**
 * Land: rings of longitudes and latitudes, drawn only as fine as the screen shows them.
 *
 * The file holds, for each ring, the number of its points and the steps from point to point in
 * thousandths of a degree; all numbers are variable-length integers, steps zigzag.
 */

const STEP_DEGREES = 1e-3;

/** Return the land's rings as places of the world, each with the box around it. */
export function decodeLand(bytes, plane) {
  const rings = [];
  let at = 0;
  let [longitude, latitude] = [0, 0];
  const number = () => {
    let [value, shift, byte] = [0, 1, 0];
    do {
      byte = bytes[at++];
      value += (byte & 127) * shift;
      shift *= 128;
    } while (byte & 128);
    return value;
  };
  const step = () => {
    const value = number();
    return value % 2 ? -(value + 1) / 2 : value / 2;
  };
  while (at < bytes.length) {
    const n = number();
    const places = new Float64Array(2 * n);
    const box = [Infinity, Infinity, -Infinity, -Infinity];
    for (let k = 0; k < n; k++) {
      longitude += step();
      latitude += step();
      const x = longitude * STEP_DEGREES;
      const y = plane.worldY(latitude * STEP_DEGREES);
      places[2 * k] = x;
      places[2 * k + 1] = y;
      box[0] = Math.min(box[0], x);
      box[1] = Math.min(box[1], y);
      box[2] = Math.max(box[2], x);
      box[3] = Math.max(box[3], y);
    }
    rings.push({ places, box });
  }
  return rings;
}

/** Draw the land that a view shows. */
export function drawLand(ctx, view, rings, theme) {
  const [left, bottom] = view.worldAt(0, view.height);
  const [right, top] = view.worldAt(view.width, 0);
  ctx.beginPath();
  // The Earth goes round: the same ring may show a turn further on.
  for (const turn of [-360, 0, 360]) {
    for (const { places, box } of rings) {
      if (box[2] + turn < left || box[0] + turn > right || box[3] < bottom || box[1] > top) continue;
      if ((box[2] - box[0] + box[3] - box[1]) * view.scale < 1.5) continue;
      addRing(ctx, view, places, turn);
    }
  }
  ctx.fillStyle = theme.land;
  ctx.fill("evenodd");
  ctx.strokeStyle = theme.coast;
  ctx.lineWidth = 1;
  ctx.lineJoin = "round";
  ctx.stroke();
}

const MARGIN = 50;

/** Add a ring to the path, without points too near to one another or far outside the screen. */
function addRing(ctx, view, places, turn) {
  const { scale, width, height } = view;
  const shiftX = width / 2 + (turn - view.x) * scale;
  const shiftY = height / 2 + view.y * scale;
  let [drawnX, drawnY, began] = [NaN, NaN, false];
  let [heldX, heldY, held, region] = [0, 0, false, 0];
  const line = (x, y) => {
    if (began) ctx.lineTo(x, y);
    else ctx.moveTo(x, y);
    began = true;
    drawnX = x;
    drawnY = y;
  };
  for (let k = 0; k < places.length; k += 2) {
    const x = places[k] * scale + shiftX;
    const y = shiftY - places[k + 1] * scale;
    const side =
      (x < -MARGIN ? 1 : x > width + MARGIN ? 2 : 0) | (y < -MARGIN ? 4 : y > height + MARGIN ? 8 : 0);
    if (side && side & region) {
      // Between points on one outer side nothing shows: only the last of them matters.
      region &= side;
      [heldX, heldY, held] = [x, y, true];
      continue;
    }
    if (held) line(heldX, heldY);
    held = false;
    if (side || !(Math.abs(x - drawnX) + Math.abs(y - drawnY) < 0.9)) line(x, y);
    region = side;
  }
  if (held) line(heldX, heldY);
  ctx.closePath();
}
