/**
 * Numbers and names for people.
 *
 * Names come from strangers. What leaves `plain` is text without controls, and it is only ever set
 * as text: no page of ours makes markup of it.
 */

// Controls, marks that turn the direction of writing, letters that nobody sees, heaps of accents.
const UNSEEN =
  /[\p{C}\p{Zl}\p{Zp}\u034f\u115f\u1160\u17b4\u17b5\u3164\uffa0\ufe00-\ufe0f]|\p{M}{3,}/gu;
const KNOT = 0.514444;
const FOOT = 0.3048;
const NAUTICAL_MILE = 1852;

/** Return a stranger's text with a dot for each thing in it that does not show, cut to a length. */
export function plain(text, most = 40) {
  const letters = Array.from(String(text ?? "").slice(0, 4 * most).replace(UNSEEN, "·"));
  return letters.length > most ? letters.slice(0, most - 1).join("") + "…" : letters.join("");
}

/** Return a number with so many digits, a dash for none. */
export function digits(value, most = 3) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-3 || size >= 1e6)) return value.toExponential(1).replace("-", "−");
  const places = size >= 100 ? 0 : Math.max(0, most - Math.max(1, Math.ceil(Math.log10(size + 1e-12))));
  return value.toFixed(Math.min(places, 4)).replace("-", "−");
}

/** Return a count with thin spaces between thousands. */
export function counted(value) {
  return Number.isFinite(value)
    ? String(Math.round(value)).replace(/\B(?=(\d{3})+$)/g, "\u202f")
    : "–";
}

/** Return a share as per cent. */
export function percent(value) {
  if (!Number.isFinite(value)) return "–";
  return value === 0 || value >= 0.0995 ? `${Math.round(100 * value)} %` : `${digits(100 * value, 2)} %`;
}

const pad = (value) => String(Math.floor(value)).padStart(2, "0");

/** Return a moment: of the day (UTC) where times are of a calendar, else since the run's zero. */
export function clockTime(seconds, calendar, fine = false) {
  if (!Number.isFinite(seconds)) return "–";
  if (calendar) {
    const date = new Date(seconds * 1000);
    if (Number.isNaN(date.getTime())) return "–";
    return date.toISOString().slice(11, fine ? 21 : 19);
  }
  if (Math.abs(seconds) < 600) return `${seconds.toFixed(1).replace("-", "−")} s`;
  const size = Math.abs(seconds);
  return `${seconds < 0 ? "−" : ""}${pad(size / 3600)}:${pad((size / 60) % 60)}:${pad(size % 60)}`;
}

/** Return the day of a moment of the calendar, nothing otherwise. */
export function calendarDay(seconds, calendar) {
  const date = new Date(seconds * 1000);
  return calendar && !Number.isNaN(date.getTime()) ? date.toISOString().slice(0, 10) : "";
}

/** Return a length of time in words. */
export function lasting(seconds) {
  if (!Number.isFinite(seconds)) return "–";
  const size = Math.abs(seconds);
  if (size < 10) return `${seconds.toFixed(1)} s`;
  if (size < 120) return `${Math.round(seconds)} s`;
  if (size < 7200) return `${Math.round(seconds / 60)} min`;
  return `${(seconds / 3600).toFixed(1)} h`;
}

/** Kinds of units: how each writes speeds, heights and distances. */
export const UNITS = {
  metric: {
    name: "m, m/s",
    speed: (value) => `${digits(value, 2)} m/s`,
    height: (value) => `${counted(value)} m`,
    distance: (value) => (Math.abs(value) >= 1000 ? `${digits(value / 1000, 4)} km` : `${digits(value)} m`),
    ruler: (value) => (value >= 1000 ? `${+(value / 1000).toPrecision(3)} km` : `${+value.toPrecision(3)} m`),
    unit: 1,
  },
  road: {
    name: "km, km/h",
    speed: (value) => `${Math.round(value * 3.6)} km/h`,
    height: (value) => `${counted(value)} m`,
    distance: (value) => (Math.abs(value) >= 1000 ? `${digits(value / 1000, 4)} km` : `${digits(value)} m`),
    ruler: (value) => (value >= 1000 ? `${+(value / 1000).toPrecision(3)} km` : `${+value.toPrecision(3)} m`),
    unit: 1,
  },
  nautical: {
    name: "NM, kt, ft",
    speed: (value) =>
      value / KNOT < 9.95 ? `${(value / KNOT).toFixed(1)} kt` : `${Math.round(value / KNOT)} kt`,
    height: (value) => `${counted(Math.round(value / FOOT / 25) * 25)} ft`,
    // Where miles would be nothing but zeros, seamen and pilots take metres.
    distance: (value) =>
      Math.abs(value) < 0.1 * NAUTICAL_MILE ? `${digits(value)} m` : `${digits(value / NAUTICAL_MILE)} NM`,
    ruler: (value) => `${+(value / NAUTICAL_MILE).toPrecision(3)} NM`,
    unit: NAUTICAL_MILE,
  },
  pixels: {
    name: "px",
    speed: (value) => `${digits(value)} px/s`,
    height: (value) => `${digits(value)} px`,
    distance: (value) => `${digits(value)} px`,
    ruler: (value) => `${+value.toPrecision(3)} px`,
    unit: 1,
  },
};

/** Return the greatest of 1, 2 or 5 times a power of ten that is not above a value. */
export function roundStep(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return power * ([5, 2, 1].find((factor) => factor * power <= value * (1 + 1e-9)) ?? 1);
}

/** Return degrees with the letter of their half of the Earth. */
export function degrees(value, letters, places = 4) {
  return `${Math.abs(value).toFixed(places)}° ${letters[value < 0 ? 1 : 0]}`;
}
