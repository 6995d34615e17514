// Controls of a figure: ticks and their values, curves, and what the axes show. They are made once and updated in place, so that
// a change of a field does not take the focus from the next one.

import { make } from "./page.js";
import { button, checkbox, choice, field } from "./dom.js";
import { UNITS } from "./channels.js";
import { boundedTurn, changed, curveName, defaultError, levelTurn, placeOf, tickName, withKind } from "./figure_state.js";

const KINDS = [["gyro", "gyroscope"], ["accel", "accelerometer"], ["signal", "another sensor"]];
const MOST_CURVES = 6;
const EXAMPLES = { x1: "0.01", x2: "1000", y1: "1", y2: "100" };

/** Colour of a curve over the picture, which has a white ground in both themes. */
export const markColour = (k) => `var(--mark-${k % MOST_CURVES})`;

/** Controls of the ticks and of the curves. `act` has current(), set(figure, target), choose(target) and done(key). Returns {element, update(figure, target)}. */
export function makeTargets(act) {
  const x = axis("x", act), y = axis("y", act), curves = curveList(act);
  return {
    element: make("div", { className: "targets-row" }, x.element, y.element, curves.element),
    update(figure, target) {
      x.update(figure, target, "X axis: averaging time", "s");
      y.update(figure, target, `Y axis: ${figure.content}`, figure.content === "variance" ? `(${figure.unit})²` : figure.unit);
      curves.update(figure, target);
    },
  };
}

/** Set the value of a field, unless the user types in it. */
function fill(input, value) {
  if (input !== document.activeElement || input.value.trim() === value) input.value = value;
}

const press = (made, isPressed) => { made.ariaPressed = String(isPressed); };

function axis(way, act) {
  const title = make("legend"), ticks = [`${way}1`, `${way}2`].map((key) => tick(key, act));
  const linear = checkbox("linear", false, (on) => act.set(changed(act.current(), (copy) => { copy.linear = ["x", "y"].filter((each) => (each === way ? on : copy.linear.includes(each))).join(""); })), { ariaLabel: `The ${way} axis is linear` });
  return {
    element: make("fieldset", { className: "ticks" }, title, ...ticks.map(({ element }) => element), linear),
    update(figure, target, name, unit) {
      title.textContent = name;
      for (const each of ticks) each.update(figure, target, unit);
      linear.firstChild.checked = figure.linear.includes(way);
    },
  };
}

function tick(key, act) {
  const name = tickName(key), unit = make("span");
  const choose = button(name, () => act.choose(key));
  const write = () => { const value = input.value.trim(); if (value !== act.current().ticks[key].value) act.set(changed(act.current(), (copy) => { copy.ticks[key].value = value; })); };
  const input = make("input", { type: "text", size: 5, placeholder: EXAMPLES[key], autocomplete: "off", onchange: write, onkeydown: (event) => { if (event.key === "Enter") { write(); act.done(); } } });
  input.dataset.tick = key;
  return {
    element: make("span", { className: "tick" }, choose, input, unit),
    update(figure, target, shownUnit) {
      const { place, value } = figure.ticks[key];
      press(choose, target === key);
      choose.textContent = `${name}${place ? " ✓" : ""}`;
      Object.assign(choose, { title: place ? "Click it again" : "Click it in the picture", ariaLabel: `Tick ${name}, ${place ? "set" : "not set"}` });
      Object.assign(input, { ariaLabel: `Value of tick ${name}${shownUnit ? ` in ${shownUnit}` : ""}`, className: place && !value ? "wanted" : "" });
      unit.textContent = key.endsWith("2") ? shownUnit : ""; // once for both
      fill(input, value);
    },
  };
}

function curveList(act) {
  const rows = make("span", { className: "rows" });
  const add = button("Add a curve", () => { const { length } = act.current().curves; act.set(changed(act.current(), (copy) => { copy.curves.push({ name: "", points: [] }); }), `c${length}`); }, { className: "small" });
  let made = [];
  return {
    element: make("fieldset", { className: "curves" }, make("legend", {}, "Curves"), rows, add),
    update(figure, target) {
      if (made.length !== figure.curves.length) {
        made = figure.curves.map((_, k) => curve(k, act));
        rows.replaceChildren(...made.map(({ element }) => element));
      }
      made.forEach((each) => each.update(figure, target));
      add.hidden = figure.curves.length >= MOST_CURVES;
    },
  };
}

function curve(k, act) {
  const swatch = make("i", { className: "swatch" }), count = make("span");
  swatch.style.background = markColour(k);
  const choose = make("button", { type: "button", onclick: () => act.choose(`c${k}`) }, swatch, count);
  const input = make("input", { type: "text", size: 8, autocomplete: "off", onchange: () => act.set(changed(act.current(), (copy) => { copy.curves[k].name = input.value.trim(); })) });
  const remove = button("", () => act.set(changed(act.current(), (copy) => { if (copy.curves.length > 1) copy.curves.splice(k, 1); else copy.curves[0].points = []; }), "c0"), { className: "small" });
  return {
    element: make("span", { className: "tick" }, choose, input, remove),
    update(figure, target) {
      const { name, points } = figure.curves[k], shown = curveName(figure, k), isSingle = figure.curves.length === 1;
      press(choose, target === `c${k}`);
      count.textContent = `${points.length} point${points.length === 1 ? "" : "s"}`;
      choose.ariaLabel = `Points of ${shown}: ${points.length}`;
      Object.assign(input, { placeholder: isSingle ? figure.kind : `${figure.kind}_x`, ariaLabel: `Name of ${shown}` });
      Object.assign(remove, { textContent: isSingle ? "Clear" : "Remove", ariaLabel: isSingle ? `Remove all points of ${shown}` : `Remove ${shown}`, hidden: isSingle && !points.length });
      fill(input, name);
    },
  };
}

/** Controls of the sensor, the unit, the clicking error, the record and the turn of the picture. Returns {element, update(figure, picture)}. */
export function makeSettings(act) {
  const inputs = {}, selects = {};
  const text = (label, name, placeholder, note = "") => {
    inputs[name] = make("input", { type: "text", placeholder, autocomplete: "off", onchange: () => act.set(changed(act.current(), (copy) => { copy[name] = inputs[name].value.trim(); })) });
    return field(label, inputs[name], note);
  };
  const select = (label, name, entries, change) => {
    selects[name] = choice(label, entries, entries[0][0], (value) => act.set(change(value)));
    return field(label, selects[name]);
  };
  const units = make("datalist", { id: "figure-units" }), turn = turnControl(act);
  const element = make("div", { className: "settings" },
    select("Sensor", "kind", KINDS, (kind) => withKind(act.current(), kind)),
    text("Unit of the rate", "unit", "e.g. deg/h"), units,
    select("The figure shows", "content", [["deviation", "Allan deviations"], ["variance", "Allan variances"]], (content) => changed(act.current(), (copy) => { copy.content = content; })),
    text("Clicking error [px of the picture]", "error", "", "Standard error. Default: a pixel of the screen at the smallest zoom that was used, three for a finger."),
    text("Sampling rate of the record [Hz]", "rate", "not stated"),
    text("Length of the record [h]", "hours", "not stated", "Default: the shortest possible one."),
    turn.element);
  inputs.unit.setAttribute("list", units.id);
  return {
    element,
    update(figure, picture) {
      for (const [name, input] of Object.entries(inputs)) fill(input, figure[name]);
      for (const [name, each] of Object.entries(selects)) each.value = figure[name];
      units.replaceChildren(...(UNITS[figure.kind] ?? []).map((value) => make("option", { value })));
      inputs.error.placeholder = String(defaultError(figure, picture));
      turn.update(figure);
    },
  };
}

function turnControl(act) {
  const turn = (value) => act.set(changed(act.current(), (copy) => { copy.turn = boundedTurn(value); }));
  const input = make("input", { type: "number", step: 0.1, min: -45, max: 45, onchange: () => turn(Number(input.value) || 0) });
  const level = button("Level the axes", () => turn(levelTurn(act.current())), { title: "Turn the picture so that the clicked ticks of each axis are in line" });
  return {
    element: make("div", { className: "turn" }, field("Turn of the picture [°]", input), level),
    update(figure) {
      fill(input, String(figure.turn));
      level.disabled = [null, figure.turn].includes(levelTurn(figure));
    },
  };
}

/** Label of a mark for screen readers. */
export function markLabel(figure, key) {
  const [x, y] = placeOf(figure, key).map(Math.round);
  if (!key.startsWith("c")) return `Tick ${tickName(key)} at ${x}, ${y}`;
  const [k, point] = key.slice(1).split(":").map(Number);
  return `Point ${point + 1} of ${figure.curves[k].points.length} of ${curveName(figure, k)} at ${x}, ${y}`;
}
