// Parts of the record: the chosen part, and the stretches that were left out.

import { make } from "./page.js";
import { bdi, button, field, parsed, announce } from "./dom.js";
import { session, setOptions } from "./session.js";
import { sensorName } from "./channels.js";
import { showPart } from "./overlays.js";

const MOST_ROWS = 40; // largest number of stretches that are listed
/** By reason why samples were not analysed: its words, and its cause in --keep. */
const REASONS = {
  missing: ["not recorded"], window: ["outside the window"], left_out: ["left out by you"], partly_at_rest: ["in motion"], not_at_rest: ["in motion"],
  spikes: ["spike", "spikes"], not_static: ["shock", "shocks"], start_transient: ["start-up", "start"], dropout: ["dropout", "dropouts"], saturation: ["saturated", "saturation"],
  stuck_samples: ["stuck value", "stuck"], interpolated: ["interpolated", "interpolated"], copied_stretch: ["copied stretch", "copies"],
};
const reasonText = (why) => REASONS[why]?.[0] ?? why.replaceAll("_", " ");
const cause = (why) => REASONS[why]?.[1];

export const seconds = (value) => `${Number(value.toPrecision(9))}s`;
const asList = (value) => (Array.isArray(value) ? value : value ? String(value).split(",") : []).map((text) => text.trim()).filter(Boolean);

/** Analyse one part only. */
export function useWindow(from, to) {
  setOptions({ window: `${seconds(from)}:${seconds(to)}` });
}

/** Leave a part out. */
export function leaveOut(from, to) {
  setOptions({ "leave-out": [...asList(session.options["leave-out"]), `${seconds(from)}:${seconds(to)}`] });
}

/** Controls of the chosen part; `zoom(from, to)` zooms to it. Returns {element, choose(from, to)}. */
export function partControls(zoom) {
  const from = make("input", { type: "text", inputMode: "decimal", ariaLabel: "From, in seconds", size: 9 });
  const to = make("input", { type: "text", inputMode: "decimal", ariaLabel: "To, in seconds", size: 9 });
  const range = () => { const a = parsed(from.value), b = parsed(to.value); return a !== null && b !== null && b > a ? [a, b] : null; };
  const act = (action) => () => { const ends = range(); if (ends) action(...ends); };
  const buttons = [
    button("Analyse only this part", act((a, b) => { clear(); useWindow(a, b); })),
    button("Leave this part out", act((a, b) => { clear(); leaveOut(a, b); })),
    button("Zoom to it", act(zoom)),
    button("Clear", () => clear()),
  ];
  const show = () => {
    const ends = range();
    for (const control of buttons) control.disabled = !ends;
    showPart(ends ? { from: ends[0], to: ends[1] } : null);
  };
  const clear = () => { from.value = to.value = ""; show(); };
  from.oninput = to.oninput = show;
  const element = make("div", { className: "part", role: "group", ariaLabel: "Part of the record" },
    make("p", { className: "about" }, "Drag across the time series, or type the start and the end of a part."),
    make("div", { className: "row" }, field("From [s]", from), field("to [s]", to), ...buttons));
  show();
  return {
    element,
    choose: (a, b) => {
      from.value = String(Number(Math.max(a, 0).toPrecision(6)));
      to.value = String(Number(b.toPrecision(6)));
      show();
      announce(`Part chosen from ${from.value} to ${to.value} seconds`);
    },
  };
}

/** List of the stretches that options or checks left out, each with a button that restores it. */
export function leftOutList(result) {
  const place = make("div", { className: "left-out" });
  const window = session.options.window;
  if (window) place.append(make("p", {}, "Analysed: the window ", bdi(String(window)), " ", button("Analyse all", () => setOptions({ window: undefined }))));
  for (const restored of asList(session.options.keep)) place.append(make("p", {}, `Restored: ${restored} `, button("Leave out again", () => setOptions({ keep: asList(session.options.keep).filter((text) => text !== restored) }), { ariaLabel: `Leave out ${restored} again` })));
  const stretches = merged(result?.left_out ?? []).filter((stretch) => stretch.why !== "window");
  const stated = asList(session.options["leave-out"]);
  if (!result) for (const text of stated) stretches.push({ ...parseRange(text), why: "left_out", text, channels: [] });
  if (!stretches.length) {
    place.append(make("p", { className: "none" }, "Nothing is left out."));
    return place;
  }
  const counts = new Map();
  for (const stretch of stretches) counts.set(stretch.why, (counts.get(stretch.why) ?? 0) + 1);
  for (const [why, count] of counts)
    place.append(make("p", { className: "row" }, make("span", {}, `${count} × ${reasonText(why)}`), ...(cause(why) && count > 1 ? [button("Restore all", () => restore(cause(why)), { ariaLabel: `Restore all: ${reasonText(why)}`, className: "small" })] : [])));
  const rows = stretches.slice(0, MOST_ROWS).map((stretch) => make("tr", {},
    make("td", {}, spanText(stretch), make("small", {}, bdi(channelsText(stretch.channels, result)))),
    make("td", {}, reasonText(stretch.why)),
    make("td", {}, ...restoreButton(stretch, stretches, stated))));
  place.append(make("div", { className: "scrolled", tabIndex: 0, role: "region", ariaLabel: "Stretches that are not analysed" },
    make("table", {}, make("thead", {}, make("tr", {}, ...["Time, channels", "Why", "Change"].map((text) => make("th", { scope: "col" }, text)))), make("tbody", {}, ...rows))));
  if (stretches.length > MOST_ROWS) place.append(make("p", { className: "none" }, `${stretches.length - MOST_ROWS} more are not listed.`));
  return place;
}

const number = (value) => (value >= 1000 ? String(Math.round(value * 10) / 10) : String(Number(value.toPrecision(4))));

function spanText({ from_s: from, to_s: to }) {
  return to - from < 2e-3 * Math.max(to, 1) ? `${number(from)} s` : `${number(from)}–${number(to)} s`;
}

/** Channels by sensor: "gyro x, y"; "all" for all. */
function channelsText(channels, result) {
  if (!channels.length || channels.length === Object.keys(result?.charts.channels ?? {}).length) return "all";
  const sensors = new Map();
  for (const name of channels) {
    const sensor = sensorName(name), axis = name === sensor ? "" : name.slice(sensor.length + 1);
    sensors.set(sensor, [...(sensors.get(sensor) ?? []), axis]);
  }
  return [...sensors].map(([sensor, axes]) => `${sensor} ${axes.join(", ")}`.trim()).join("; ");
}

/** Merge equal stretches of several channels into one row. */
function merged(stretches) {
  const rows = new Map();
  for (const stretch of stretches) {
    const key = `${stretch.from_s} ${stretch.to_s} ${stretch.why}`;
    if (!rows.has(key)) rows.set(key, { ...stretch, channels: [] });
    if (stretch.channel) rows.get(key).channels.push(stretch.channel);
  }
  return [...rows.values()].sort((a, b) => a.from_s - b.from_s);
}

/** Parse a range of time, as in the option --leave-out. */
function parseRange(text) {
  const sizes = { ms: 1e-3, s: 1, min: 60, h: 3600, d: 86400, "": 1 };
  const [from, to] = text.split(":").map((end) => { const match = /^([\d.eE+-]+)\s*(ms|s|min|h|d|)$/.exec(end.trim()); return match ? Number(match[1]) * sizes[match[2]] : NaN; });
  return { from_s: from, to_s: to };
}

function restoreButton(stretch, stretches, stated) {
  const label = `Restore ${spanText(stretch)}`;
  if (stretch.why === "left_out") {
    const middle = (stretch.from_s + stretch.to_s) / 2;
    const text = stretch.text ?? stated.find((range) => { const ends = parseRange(range); return ends.from_s <= middle && middle <= ends.to_s; });
    return text ? [button("Restore", () => setOptions({ "leave-out": stated.filter((range) => range !== text) }), { ariaLabel: label, className: "small" })] : [];
  }
  if (!cause(stretch.why)) return [];
  return [button("Restore", () => restore(`${seconds(stretch.from_s)}:${seconds(stretch.to_s)}`), { ariaLabel: label, title: "--keep", className: "small" })];
}

/** Restore the samples of a cause, or of a range of time, by the option --keep. */
function restore(text) {
  setOptions({ keep: [...new Set([...asList(session.options.keep), text])] });
}
