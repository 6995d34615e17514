// One axis in detail: terms of its model can be switched off, and lines of the five slopes are drawn by hand.

import { channelColour, colour, content, make } from "./page.js";
import { draw, plots, zoom } from "./plot.js";
import { readOff } from "./api.js";
import { bdi, button, checkbox, choice } from "./dom.js";
import { session, setOptions } from "./session.js";
import { text } from "./numbers.js";
import { drawSlopes, pointOfSlope, SIGNS } from "./slopes.js";
import { follow, showPoint } from "./overlays.js";

const HEIGHT = 420;
const chosen = { channel: "", off: new Set(), lines: new Map() }; // off: hidden terms; lines: averaging time by term [s]

/** Make the section of one axis. Returns {element, clear}; `clear` removes its plot. */
export function byHand() {
  const names = Object.keys(content.channels).filter((name) => content.channels[name].deviation);
  if (!names.length) return { element: make("div"), clear() {} };
  if (!names.includes(chosen.channel)) chosen.channel = names[0];
  const place = make("div", { className: "plot" }), table = make("div", { className: "terms" }), readout = make("div", { className: "readout" });
  const state = { plot: null, lines: null, cells: new Map(), asked: new Map() };
  const clear = () => { if (state.plot) { state.plot.u.destroy(); plots.delete(state.plot); } place.replaceChildren(); };
  const show = () => { clear(); drawAxis(state, place, table, readout); };
  const select = choice("Axis", names.map((name) => [name, name]), chosen.channel, (name) => { chosen.channel = name; chosen.off.clear(); show(); });
  const element = make("figure", { className: "by-hand" },
    make("div", { className: "top" }, make("figcaption", {}, "One axis: ", select),
      make("div", { className: "controls tools" }, button("+", () => zoom(state.plot, 1 / 1.5), { title: "Zoom in" }), button("−", () => zoom(state.plot, 1.5), { title: "Zoom out" }), button("Reset", () => state.plot.reset(), { title: "Show all" }))),
    make("div", { className: "bench" }, make("div", {}, place, readout), table));
  new IntersectionObserver((entries, watcher) => { if (entries.some((entry) => entry.isIntersecting)) { watcher.disconnect(); show(); } }, { rootMargin: "600px" }).observe(element);
  place.style.minHeight = `${HEIGHT}px`;
  return { element, clear };
}

const sensorWith = (channel) => content.sensors.find((sensor) => sensor.channels.includes(channel));

function drawAxis(state, place, table, readout) {
  const sensor = sensorWith(chosen.channel), unit = sensor.units[0], deviation = content.channels[chosen.channel].deviation;
  const inUnit = (values) => values.map((value) => (value === null ? null : value / unit.factor));
  const terms = session.about.terms.map((term, k) => ({ ...term, colour: () => channelColour(k, 6) }));
  const parts = Object.entries(deviation.parts ?? {}).map(([label, values], k) => {
    const term = terms.find((each) => label.startsWith(each.label));
    return { label, values, colour: term?.colour ?? (() => channelColour(5 - (k % 6), 6)) };
  });
  const curve = { tau: deviation.tau, adev: inUnit(deviation.adev) };
  const described = {
    title: `Allan deviation of ${chosen.channel}, with its terms`, height: HEIGHT, link: "tau",
    x: { label: "averaging time τ [s]", log: true }, y: { label: `Allan deviation σ(τ) [${unit.text}]`, log: true },
    lines: drawnLines(deviation, parts, inUnit, unit),
    onread: (point) => {
      readout.replaceChildren(...(point?.values.length ? [make("b", {}, `τ = ${text(point.x)} s`), make("span", {}, `σ = ${text(point.values[0].y, 4)} ${unit.text} [${text(point.values[0].low)}, ${text(point.values[0].high)}]`)] : [make("span", {}, "Drag a handle along the curve, or move it by the arrow keys.")]));
      showPoint("tau", point ? point.x : null, described);
    },
  };
  state.plot = draw(place, described);
  place.setAttribute("role", "group"); // not an image: it contains handles
  described.onread(null);
  follow({ drawn: [state.plot] });
  state.lines = drawSlopes(state.plot, curve.tau, curve.adev, terms, (term, k) => { chosen.lines.set(term.name, curve.tau[k]); ask(state, term, curve.tau[k]); });
  table.replaceChildren(...termTable(state, terms, parts, curve, () => redrawLines(state, deviation, parts, inUnit, unit)));
  for (const term of terms) if (chosen.lines.has(term.name)) lay(state, term, curve, chosen.lines.get(term.name));
}

function drawnLines(deviation, parts, inUnit) {
  const { tau, adev, low, high, model } = deviation;
  const lines = [{ name: chosen.channel, x: tau, y: inUnit(adev), colour: () => colour("ink"), points: tau.length < 120, read: true, interval: { low: inUnit(low), high: inUnit(high) },
    low: inUnit(low.map((value, k) => Math.max(value ?? 0, 0.1 * adev[k]))), high: inUnit(high.map((value, k) => Math.min(value ?? Infinity, 10 * adev[k]))) }];
  if (!model) return lines;
  const off = parts.filter((part) => chosen.off.has(part.label));
  const rest = model.map((value, k) => (value === null ? null : Math.sqrt(Math.max(value ** 2 - off.reduce((sum, part) => sum + (part.values[k] ?? 0) ** 2, 0), 0)) || null));
  lines.push({ name: off.length ? "model without the hidden terms" : "fitted model", x: tau, y: inUnit(rest), colour: () => colour("link"), width: 1.8, dash: [6, 4], framed: false });
  const smallest = Math.min(...adev.filter((value) => value > 0)) / 4;
  for (const part of parts) {
    const y = inUnit(part.values.map((value) => (value === null || value < smallest ? null : value)));
    lines.push({ name: part.label, x: tau, y: chosen.off.has(part.label) ? y.map(() => null) : y, colour: part.colour, width: 1.2, dash: [2, 3], framed: false, tag: part.label });
  }
  return lines;
}

/** Update the lines after a term was switched on or off; the plot keeps its scales. */
function redrawLines(state, deviation, parts, inUnit) {
  const { plot } = state;
  plot.described.lines = drawnLines(deviation, parts, inUnit);
  const data = [deviation.tau];
  for (const line of plot.described.lines) {
    data.push(line.y);
    if (line.low) data.push(line.low, line.high);
  }
  plot.u.setData(data, false);
  plot.u.redraw(false);
}

function termTable(state, terms, parts, curve, redraw) {
  const fitted = session.result.summary.coefficients.find(({ channel }) => channel === chosen.channel)?.rows ?? [];
  state.cells.clear();
  const rows = terms.map((term) => {
    const part = parts.find((each) => each.label.startsWith(term.label));
    const row = fitted.find(([label]) => label === term.label);
    const cell = make("td", { className: "read" });
    state.cells.set(term.name, cell);
    const toggle = part ? checkbox("", !chosen.off.has(part.label), (on) => { on ? chosen.off.delete(part.label) : chosen.off.add(part.label); redraw(); }, { ariaLabel: `${term.label} in the model` }) : make("span", { className: "none" }, "–");
    const slope = checkbox(SIGNS[term.slope], chosen.lines.has(term.name), (on) => {
      if (on) lay(state, term, curve, curve.tau[pointOfSlope(curve.tau, curve.adev, term.slope)]);
      else { chosen.lines.delete(term.name); state.lines.hide(term.name); cell.replaceChildren(); }
    }, { ariaLabel: `Line of slope ${SIGNS[term.slope]}: ${term.label}` });
    const name = make("th", { scope: "row" }, make("i", { className: "swatch" }), term.label);
    name.firstChild.style.background = term.colour();
    return make("tr", {}, name, make("td", {}, toggle), make("td", { className: "value" }, row ? `${row[1]} ${row[3]}` : "–"), make("td", {}, slope), cell);
  });
  const further = parts.filter((part) => !terms.some((term) => part.label.startsWith(term.label))).map((part) => make("tr", {}, make("th", { scope: "row" }, bdi(part.label)),
    make("td", {}, checkbox("", !chosen.off.has(part.label), (on) => { on ? chosen.off.delete(part.label) : chosen.off.add(part.label); redraw(); }, { ariaLabel: `${part.label} in the model` })), make("td", {}), make("td", {}), make("td", { className: "read" })));
  const heads = ["Term", "In model", "Fitted", "Line", "Read off by hand"].map((head) => make("th", { scope: "col" }, head));
  return [make("table", {}, make("thead", {}, make("tr", {}, ...heads)), make("tbody", {}, ...rows, ...further)),
    make("p", { className: "legend" }, "Read-off as in the paper: check a line, then drag its handle along the curve. The error follows from eq. (26). A line is refused where the curve has a different slope.")];
}

/** Place the line of a term at an averaging time, and ask the server for its value. */
function lay(state, term, curve, tau) {
  const k = curve.tau.reduce((best, value, j) => (Math.abs(Math.log(value / tau)) < Math.abs(Math.log(curve.tau[best] / tau)) ? j : best), 0);
  chosen.lines.set(term.name, curve.tau[k]);
  state.lines.place(term.name, k);
  ask(state, term, curve.tau[k]);
}

/** Ask the server for the value of a line; while a handle moves, only the last position is asked for. */
function ask(state, term, tau) {
  const cell = state.cells.get(term.name), channel = chosen.channel;
  state.asked.get(term.name)?.abort();
  const request = new AbortController();
  state.asked.set(term.name, request);
  if (!cell.firstChild) cell.replaceChildren("…");
  setTimeout(async () => {
    if (request.signal.aborted) return;
    try {
      const read = await readOff(session.id, { channel, term: term.name, tau_s: tau }, request.signal);
      showLine(state, term, channel, cell, read);
    } catch (error) {
      if (error.name !== "AbortError") showLine(state, term, channel, cell, { refused: error.message });
    }
  }, 60);
}

function showLine(state, term, channel, cell, read) {
  if (!chosen.lines.has(term.name) || chosen.channel !== channel) return;
  const tau = make("span", { className: "tau" }, `τ = ${text(chosen.lines.get(term.name))} s`);
  if (read.refused) {
    cell.replaceChildren(tau, " ", make("span", { className: "refusal" }, `refused: ${read.refused}`));
    state.lines.describe(term.name, `refused, ${read.refused}`, true);
    return;
  }
  const error = read.relative_error === null || read.relative_error === undefined ? "" : ` (error ${text(100 * read.relative_error, 2)} %)`;
  cell.replaceChildren(tau, " ", make("b", {}, read.text), error, " ", button("Use", () => use(channel, term, read), { title: "Write this range into the options: --read-off-at", ariaLabel: `Use this line of ${term.label} in the analysis` }));
  state.lines.describe(term.name, `${read.text}${error}`, false);
}

/** Set the option --read-off-at to the range of a line. */
function use(channel, term, { from_s: from, to_s: to }) {
  const key = `${channel}.${term.name}=`;
  const ranges = [session.options["read-off-at"] ?? []].flat().filter((range) => !range.startsWith(key));
  setOptions({ "read-off-at": [...ranges, `${key}${Number(from.toPrecision(9))}s:${Number(to.toPrecision(9))}s`] });
}
