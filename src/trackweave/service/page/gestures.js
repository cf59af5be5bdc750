/** Fingers, mouse and wheel on the map. */

const CLICK_PIXELS = 5;

/** Let pointers move a view; `calls` has `moved`, `hover`, `click` and `leave`. */
export function watchPointers(element, view, calls) {
  const pointers = new Map();
  let travelled = 0;
  const place = (event) => {
    const box = element.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  element.addEventListener("pointerdown", (event) => {
    if (event.button) return;
    element.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, place(event));
    if (pointers.size === 1) travelled = 0;
  });
  element.addEventListener("pointermove", (event) => {
    const [x, y] = place(event);
    const before = pointers.get(event.pointerId);
    if (!before) {
      if (event.pointerType === "mouse") calls.hover(x, y);
      return;
    }
    travelled += Math.abs(x - before[0]) + Math.abs(y - before[1]);
    if (pointers.size === 1 && travelled > CLICK_PIXELS) {
      view.pan(x - before[0], y - before[1]);
      element.classList.add("dragging");
      calls.moved();
    } else if (pointers.size === 2) {
      pinch(pointers, event.pointerId, [x, y], view);
      calls.moved();
    }
    pointers.set(event.pointerId, [x, y]);
  });
  const release = (event) => {
    const was = pointers.delete(event.pointerId);
    if (!pointers.size) element.classList.remove("dragging");
    if (was && event.type === "pointerup" && !pointers.size && travelled <= CLICK_PIXELS) {
      calls.click(...place(event), event.pointerType !== "mouse");
    }
  };
  element.addEventListener("pointerup", release);
  element.addEventListener("pointercancel", release);
  element.addEventListener("pointerleave", () => calls.leave());
  element.addEventListener("wheel", (event) => {
    event.preventDefault();
    const step = event.deltaMode === 1 ? 30 * event.deltaY : event.deltaY;
    view.zoom(Math.exp(-Math.max(-240, Math.min(240, step)) * 0.0022), ...place(event));
    calls.moved();
  }, { passive: false });
  element.addEventListener("dblclick", (event) => {
    view.zoom(event.shiftKey ? 0.5 : 2, ...place(event));
    calls.moved();
  });
}

function pinch(pointers, moving, [x, y], view) {
  const [fromX, fromY] = pointers.get(moving);
  const [, [otherX, otherY]] = [...pointers].find(([id]) => id !== moving);
  const before = Math.hypot(fromX - otherX, fromY - otherY);
  const after = Math.hypot(x - otherX, y - otherY);
  const [middleX, middleY] = [(x + otherX) / 2, (y + otherY) / 2];
  if (before > 10 && after > 10) view.zoom(after / before, middleX, middleY);
  view.pan((x - fromX) / 2, (y - fromY) / 2);
}
