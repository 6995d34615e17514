// Figures: one a sensor, with what can be chosen, buttons, and what is read at the cursor.

/** What is chosen of each sensor, in all its figures: its unit, and the channels that are seen. */
const chosen = new Map(content.sensors.map((sensor) => [sensor.name, { unit: 0, seen: new Set(sensor.channels) }]));
const figures = new Set();
const MOST_SENSORS = 4; // beside each other; of more, one is chosen

/** Fill a section with a figure a sensor.
 *
 * kind: {id, title, options: [{name, text, on}], describe(sensor, state): descriptions, readout(read, sensor, state): nodes,
 *        has(channel)}
 */
function fill(place, kind) {
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

function drop(place) {
  for (const one of [...figures]) if (place.contains(one.element)) { one.clear(); figures.delete(one); }
}

function figure(kind, sensor) {
  const state = { sensor, ...Object.fromEntries(kind.options.map((one) => [one.name, one.on(sensor)])) };
  Object.defineProperties(state, { unit: { get: () => sensor.units[chosen.get(sensor.name).unit] }, seen: { get: () => chosen.get(sensor.name).seen } });
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
      described.onread = (point) => readout.replaceChildren(...(point ? kind.readout(point, sensor, state, described) : [hint()]));
      made.drawn.push(draw(place, described));
      zoomTo(made.drawn[made.drawn.length - 1], zoomed.get(described.title) ?? []);
    }
    if (!made.drawn.length) body.append(make("p", { className: "none" }, "No axis is chosen."));
    readout.replaceChildren(hint());
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

function drawAll() {
  for (const one of figures) { one.visible = true; one.draw(); }
}

function caption(sensor) {
  return sensor.title === sensor.name ? make("bdi", {}, sensor.name) : sensor.title;
}

function hint() {
  return make("span", {}, "Point to read, drag to zoom, double-click for all.");
}

function shortName(sensor, channel) {
  return channel.startsWith(`${sensor.name}_`) ? channel.slice(sensor.name.length + 1) : channel;
}

function colourOf(sensor, channel) {
  return () => channelColour(sensor.channels.indexOf(channel), sensor.channels.length);
}

/** All figures of a sensor again, after its unit or its channels were changed in one of them. */
function changed(sensor) {
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
    const select = make("select", { ariaLabel: "Unit", onchange: () => { chosen.get(sensor.name).unit = select.selectedIndex; changed(sensor); } },
      ...sensor.units.map((unit) => make("option", {}, kind.unitText ? kind.unitText(unit.text) : unit.text)));
    const before = made.sync;
    made.syncUnit = () => { select.selectedIndex = chosen.get(sensor.name).unit; };
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
function readValues(point, unit) {
  return point.values.map(({ line, y, low, high }) => {
    const mark = make("b", {}, make("bdi", {}, line.name));
    mark.style.color = line.colour();
    const band = low === null ? "" : y === null ? `${text(low, 5)} to ${text(high, 5)}` : ` [${text(low)}, ${text(high)}]`;
    return make("span", {}, mark, " ", y === null ? "" : text(y, 4), band, ` ${unit}`);
  });
}
