/** Everything by keys. */

export const HELP = [
  ["← → ↑ ↓", "move the map"],
  ["+  −", "closer, farther"],
  ["0", "show everything"],
  ["space", "play or pause"],
  [",  .", "a step back, a step on"],
  ["[  ]", "play slower, faster"],
  ["Home  End", "to the beginning, to the end"],
  ["n  b", "next track of the list, the one before"],
  ["c", "keep the chosen track in the middle"],
  ["/", "search"],
  ["Esc", "let go of the chosen track"],
  ["k  h  l", "next colouring, trails, labels"],
  ["v e r s d g m y", "vectors, ellipses, reports, sensors, distances, grid, land, truth"],
  ["o  p  t", "what is shown, panel, dark or light"],
];
const STEP_PIXELS = 80;

/** Let keys work wherever nothing is being typed. */
export function watchKeys(page) {
  const { map, timeline } = page;
  const pan = (dx, dy) => () => {
    map.moved = true;
    map.view.pan(dx * STEP_PIXELS, dy * STEP_PIXELS);
    map.redraw();
  };
  const step = (sign) => () => timeline.go(timeline.shown + sign * stepSeconds(timeline));
  const keys = {
    ArrowLeft: pan(1, 0), ArrowRight: pan(-1, 0), ArrowUp: pan(0, 1), ArrowDown: pan(0, -1),
    "+": () => page.zoom(1.4), "=": () => page.zoom(1.4), "-": () => page.zoom(1 / 1.4), "−": () => page.zoom(1 / 1.4),
    0: () => map.fit(), " ": () => timeline.toggle(), ",": step(-1), ".": step(1),
    "[": () => timeline.faster(-1), "]": () => timeline.faster(1),
    Home: () => timeline.go(timeline.from), End: () => timeline.go(timeline.to),
    n: () => page.list.step(1), b: () => page.list.step(-1), c: () => page.hold(),
    "/": () => {
      page.root.classList.remove("narrow");
      page.tab(0);
      page.list.search.focus();
    },
    Escape: () => (page.panel.element.hidden ? map.select(null) : page.toggleOptions()),
    k: () => page.next("colour"), h: () => page.next("trail"), l: () => page.next("labels"),
    o: () => page.toggleOptions(), p: () => page.toggleSide(), t: () => page.toggleTheme(), "?": () => page.toggleHelp(),
  };
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || page.help.open) return;
    const { target } = event;
    const types = target.matches("input[type=search], select, textarea");
    const slides = target.matches("input[type=range]") && /^(Arrow|Home|End|Page)/.test(event.key);
    if (types || slides || (event.key === " " && target.matches("button, input"))) return;
    const act = Object.hasOwn(keys, event.key) ? keys[event.key] : null;
    if (!act && !page.panel.pressed(event.key)) return;
    act?.();
    event.preventDefault();
  });
}

function stepSeconds({ from, to }) {
  const span = to - from;
  return span > 1200 ? 10 : span > 120 ? 1 : span / 120;
}
