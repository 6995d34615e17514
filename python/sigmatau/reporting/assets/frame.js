// Figures: one a sensor, with what can be chosen, buttons, and what is read at the cursor.

import { channelColour, content, make } from "./page.js";
import { text } from "./numbers.js";
import { onPrint } from "./paper.js";
import { draw, plots, zoom, zoomOf, zoomTo } from "./plot.js";
import { saveCsv, savePng, saveSvg } from "./saving.js";
import { onRecolour } from "./theme.js";

/** What is chosen of each sensor, in all its figures: its unit, and the channels that are seen. */
const chosen = new Map();
export const figures = new Set();
const remembered = new Map(); // options of a figure that is made again, of another result
const MOST_SENSORS = 4; // beside each other; of more, one is chosen
const PAPER = 660; // width of a plot on A4 with margins of 15 mm [px]

/** Forget what was chosen of sensors: another file has others. */
export function forget() {
  chosen.clear();
  remembered.clear();
}

function chosenOf(sensor) {
  if (!chosen.has(sensor.name)) chosen.set(sensor.name, { unit: 0, seen: new Set(sensor.channels) });
  return chosen.get(sensor.name);
}

/** Fill a section with a figure a sensor.
 *
 * kind: {id, title, options: [{name, text, on}], describe(sensor, state): descriptions, readout(read, sensor, state): nodes,
 *        has(channel), drawn(figure), onread(point, figure), onselect(from, to, description): in place of a zoom, onrange(from, to, figure, description): after one}
 */
export function fill(place, kind) {
  const sensors = content.sensors.filter((sensor) => sensor.channels.some((name) => kind.has(content.channels[name])));
  if (sensors.length <= MOST_SENSORS) {
    place.append(...sensors.map((sensor) => figure(kind, sensor)));
    return;
  }
  const show = (k) => { drop(place); place.replaceChildren(figure(kind, sensors[k])); };
  const select = make("select", { onchange: () => show(select.selectedIndex), ariaLabel: "Sensor" }, ...sensors.map((one) => make("option", {}, one.name)));
  place.before(make("p", { className: "chooser" }, select));
  show(0);
}

export function drop(place) {
  for (const one of [...figures]) if (place.contains(one.element)) { watcher.unobserve(one.element); one.clear(); figures.delete(one); }
}

function figure(kind, sensor) {
  const key = `${kind.id} ${sensor.name}`;
  const state = { ...Object.fromEntries(kind.options.map((one) => [one.name, one.on(sensor)])), ...remembered.get(key), sensor };
  remembered.set(key, state);
  Object.defineProperties(state, { unit: { get: () => sensor.units[chosenOf(sensor).unit] }, seen: { get: () => chosenOf(sensor).seen } });
  const channels = sensor.channels.filter((name) => kind.has(content.channels[name]));
  const body = make("div"), readout = make("div", { className: "readout" });
  readout.setAttribute("aria-live", "polite");
  const made = { kind, sensor, state, body, drawn: [], element: null, visible: false };
  made.clear = () => { for (const plot of made.drawn) { plot.u.destroy(); plots.delete(plot); } made.drawn = []; body.replaceChildren(); };
  made.draw = () => {
    if (!made.visible) return;
    const zoomed = new Map(made.drawn.map((plot) => [plot.described.title, zoomOf(plot)]));
    made.clear();
    for (const described of kind.describe(sensor, state)) {
      const place = make("div", { className: "plot" });
      body.append(place);
      described.onread = (point) => {
        readout.replaceChildren(...(point ? kind.readout(point, sensor, state, described) : [hint(kind)]));
        kind.onread?.(point, made, described);
      };
      if (kind.onrange) described.onrange = (from, to) => kind.onrange(from, to, made, described);
      if (kind.onselect) described.onselect = (from, to) => kind.onselect(from, to, described);
      made.drawn.push(draw(place, described));
      zoomTo(made.drawn[made.drawn.length - 1], zoomed.get(described.title) ?? []);
    }
    if (!made.drawn.length) body.append(make("p", { className: "none" }, "No axis is chosen."));
    readout.replaceChildren(hint(kind));
    kind.drawn?.(made);
  };
  const reserve = kind.height(sensor, state);
  body.style.minHeight = `${reserve}px`;
  made.element = make("figure", {},
    make("div", { className: "top" }, make("figcaption", {}, caption(sensor)), tools(made)),
    axesControls(made, channels), optionControls(made), body, readout);
  made.element.dataset.sensor = sensor.name;
  figures.add(made);
  watcher.observe(made.element);
  return made.element;
}

/** Figures are drawn when they come near the window. */
const watcher = new IntersectionObserver((entries) => {
  for (const entry of entries) {
    if (!entry.isIntersecting) continue;
    watcher.unobserve(entry.target);
    for (const one of figures) if (one.element === entry.target) { one.visible = true; one.draw(); }
  }
}, { rootMargin: "600px" });

onRecolour(() => { for (const one of figures) one.sync?.(); });

onPrint(() => {
  for (const one of figures) { one.visible = true; one.draw(); }
  for (const { element, drawn, kind } of figures) {
    const wide = kind.id === "deviation" || kind.id === "density" || element.parentElement.children.length === 1;
    for (const { u, described } of drawn) u.setSize({ width: wide ? PAPER : PAPER / 2 - 22, height: described.height * (wide ? 1 : 0.8) });
  }
});

function caption(sensor) {
  return sensor.title === sensor.name ? make("bdi", {}, sensor.name) : sensor.title;
}

function hint(kind) {
  return make("span", {}, kind.hint ?? "Point to read, drag to zoom, double-click for all.");
}

export function shortName(sensor, channel) {
  return channel.startsWith(`${sensor.name}_`) ? channel.slice(sensor.name.length + 1) : channel;
}

export function colourOf(sensor, channel) {
  return () => channelColour(sensor.channels.indexOf(channel), sensor.channels.length);
}

/** All figures of a sensor again, after its unit or its channels were changed in one of them. */
export function changed(sensor) {
  for (const one of figures) if (one.sensor === sensor) { one.sync?.(); one.draw(); }
}

function axesControls(made, channels) {
  const { sensor, state } = made;
  if (channels.length < 2 || made.kind.axes === false) return make("div", { hidden: true });
  const boxes = channels.map((name) => {
    const box = make("input", { type: "checkbox", checked: state.seen.has(name), onchange: () => { box.checked ? state.seen.add(name) : state.seen.delete(name); changed(sensor); } });
    const swatch = make("i");
    swatch.style.background = colourOf(sensor, name)();
    swatch.dataset.channel = name;
    return make("label", {}, box, swatch, make("bdi", {}, shortName(sensor, name)));
  });
  const all = channels.length > 3 ? [["All", channels], ["None", []]].map(([word, seen]) =>
    make("button", { type: "button", onclick: () => { state.seen.clear(); seen.forEach((name) => state.seen.add(name)); changed(sensor); } }, word)) : [];
  made.sync = () => boxes.forEach((label, k) => {
    label.firstChild.checked = state.seen.has(channels[k]);
    label.children[1].style.background = colourOf(sensor, channels[k])();
  });
  const group = make("div", { className: "controls axes", role: "group", ariaLabel: "Axes" }, ...boxes, ...all);
  const syncBoxes = made.sync;
  made.sync = () => { syncBoxes(); made.syncUnit?.(); };
  return group;
}

function optionControls(made) {
  const { kind, sensor, state } = made;
  const boxes = kind.options.filter((option) => option.needs?.(sensor) ?? true).map((option) => {
    const box = make("input", { type: "checkbox", checked: state[option.name], onchange: () => { state[option.name] = box.checked; made.draw(); } });
    return make("label", {}, box, option.text);
  });
  const parts = [...boxes];
  if (kind.choices) parts.push(...kind.choices(made));
  if (kind.unit !== false && sensor.units.length > 1) {
    const select = make("select", { ariaLabel: "Unit", onchange: () => { chosenOf(sensor).unit = select.selectedIndex; changed(sensor); } },
      ...sensor.units.map((unit) => make("option", {}, kind.unitText ? kind.unitText(unit.text) : unit.text)));
    const before = made.sync;
    made.syncUnit = () => { select.selectedIndex = chosenOf(sensor).unit; };
    made.sync = before ?? (() => made.syncUnit());
    parts.push(select);
  }
  return make("div", { className: "controls options", hidden: !parts.length }, ...parts);
}

function tools(made) {
  const button = (word, title, action) => make("button", { type: "button", title, onclick: action }, word);
  return make("div", { className: "controls tools" },
    button("+", "Zoom in", () => made.drawn.forEach((plot) => zoom(plot, 1 / 1.5))),
    button("−", "Zoom out", () => made.drawn.forEach((plot) => zoom(plot, 1.5))),
    button("Reset", "Show all", () => made.drawn.forEach((plot) => plot.reset())),
    button("PNG", "Save as PNG", () => savePng(made)),
    button("SVG", "Save as SVG", () => saveSvg(made)),
    button("CSV", "Save the numbers as CSV", () => saveCsv(made)));
}

/** Values of the lines at the cursor, each with its interval. */
export function readValues(point, unit) {
  return point.values.map(({ line, y, low, high }) => {
    const mark = make("b", {}, make("bdi", {}, line.name));
    mark.style.color = line.colour();
    const band = low === null ? "" : y === null ? `${text(low, 5)} to ${text(high, 5)}` : ` [${text(low)}, ${text(high)}]`;
    return make("span", {}, mark, " ", y === null ? "" : text(y, 4), band, ` ${unit}`);
  });
}
