/** Elements, made of words and never of markup. */

/** Make an element with attributes, `on…` listeners and children; text children are text. */
export function el(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name === "text") element.textContent = value;
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(name, value);
  }
  element.append(...children.filter((child) => child !== null));
  return element;
}

/** Make a name of a stranger's: set apart, so that its direction of writing turns nothing else. */
export function nameOf(text) {
  return el("bdi", { text });
}

const ICONS = {
  play: "M7 5l11 7-11 7z",
  pause: "M7 5h3.6v14H7zM13.4 5H17v14h-3.6z",
  plus: "M11 5h2v6h6v2h-6v6h-2v-6H5v-2h6z",
  minus: "M5 11h14v2H5z",
  fit: "M4 4h6v2H6v4H4zM14 4h6v6h-2V6h-4zM4 14h2v4h4v2H4zM18 14h2v6h-6v-2h4z",
  theme: "M12 3a9 9 0 100 18 9 9 0 000-18zm0 2a7 7 0 010 14z",
  layers: "M12 4l9 5-9 5-9-5zM5.2 12.6L12 16.4l6.8-3.8L21 14l-9 5-9-5z",
  help: "M11 17h2v2h-2zM12 5a4.4 4.4 0 00-4.4 4.4h2a2.4 2.4 0 114.3 1.5c-1 1.1-2.9 1.8-2.9 4.1h2c0-1.5 3.4-2 3.4-5.6A4.4 4.4 0 0012 5z",
  list: "M4 6h16v2H4zM4 11h16v2H4zM4 16h16v2H4z",
  close: "M6.4 5L12 10.6 17.6 5 19 6.4 13.4 12l5.6 5.6-1.4 1.4-5.6-5.6L6.4 19 5 17.6l5.6-5.6L5 6.4z",
  live: "M12 8a4 4 0 110 8 4 4 0 010-8z",
  target: "M11 3h2v4h-2zM11 17h2v4h-2zM3 11h4v2H3zM17 11h4v2h-4zM12 9a3 3 0 110 6 3 3 0 010-6z",
  curves: "M4 19V5h2v12h14v2zM8 14l3-5 3 3 4-7 1.7 1-5.3 9-3-3-1.7 3z",
};

/** Make a picture of our own small set. */
export function icon(name) {
  const space = "http://www.w3.org/2000/svg";
  const svg = document.createElementNS(space, "svg");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("aria-hidden", "true");
  const path = document.createElementNS(space, "path");
  path.setAttribute("d", ICONS[name]);
  path.setAttribute("fill-rule", "evenodd");
  svg.append(path);
  return svg;
}

/** Make a button with an icon; `label` is read out and shown on hovering. */
export function iconButton(name, label, onclick) {
  return el("button", { type: "button", class: "icon", title: label, "aria-label": label, onclick }, icon(name));
}

/** Fit a canvas's own pixels to the screen's and return its context, scaled to CSS pixels. */
export function sized(canvas) {
  const ratio = window.devicePixelRatio || 1;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const ctx = canvas.getContext("2d");
  ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
  return ctx;
}
