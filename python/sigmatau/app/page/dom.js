// Small parts of the page: buttons, labels, marks, messages. Text is never parsed as HTML.

import { make } from "./page.js";

export const byId = (id) => document.getElementById(id);

export function button(text, onclick, attributes = {}) {
  return make("button", { type: "button", onclick, ...attributes }, text);
}

/** A control with its label before it. */
export function field(label, control, note = "") {
  return make("label", { className: "field" }, make("span", {}, label), control, ...(note ? [make("small", {}, note)] : []));
}

export function checkbox(label, checked, onchange, attributes = {}) {
  const box = make("input", { type: "checkbox", checked, onchange: () => onchange(box.checked), ...attributes });
  return make("label", { className: "check" }, box, make("span", {}, label));
}

/** A list to choose from; entries are [value, text]. */
export function choice(label, entries, value, onchange) {
  const select = make("select", { ariaLabel: label, onchange: () => onchange(select.value) }, ...entries.map(([key, text]) => make("option", { value: key }, text)));
  select.value = value;
  return select;
}

export const chip = (text, kind) => make("span", { className: `chip ${kind}` }, text);
export const bdi = (text) => make("bdi", {}, text);

/** Tell users of screen readers what happened. */
export function announce(text) {
  byId("status").textContent = text;
}

/** Parse a number of a text field, with a decimal point or comma; null if it is not a number. */
export function parsed(text) {
  const value = Number(String(text).trim().replace(",", "."));
  return String(text).trim() && Number.isFinite(value) ? value : null;
}

export function debounce(action, delay) {
  let timer = 0;
  return (...values) => {
    clearTimeout(timer);
    timer = setTimeout(() => action(...values), delay);
  };
}

/** Copy a text; the button shows whether it was allowed. */
export async function copy(text, pressed) {
  const before = pressed.textContent;
  try {
    await navigator.clipboard.writeText(text);
    pressed.textContent = "Copied";
  } catch {
    pressed.textContent = "Not allowed";
  }
  announce(pressed.textContent);
  setTimeout(() => { pressed.textContent = before; }, 1500);
}

/** Box of an error: its message, and the first rows of the file. */
export function errorBox(error) {
  return make("div", { className: "box poor", role: "alert" },
    make("p", {}, error.message),
    ...(error.rows ? [make("pre", { tabIndex: 0 }, error.rows)] : []));
}

/** Whether a value means that the option is not stated. */
export function isEmpty(value) {
  if (value === undefined || value === null || value === "" || value === false) return true;
  return typeof value === "object" && Object.keys(value).length === 0;
}

/** The last part of a path. */
export const nameOfPath = (path) => path.split(/[\\/]/).pop();

export function size(bytes) {
  if (bytes < 1e3) return `${bytes} B`;
  const [factor, unit] = bytes < 1e6 ? [1e3, "kB"] : bytes < 1e9 ? [1e6, "MB"] : [1e9, "GB"];
  return `${(bytes / factor).toPrecision(3)} ${unit}`;
}

/** Replace controls and keep the focus on the same control. */
export function keepFocus(place, change) {
  const name = document.activeElement?.dataset?.focus;
  change();
  if (name) place.querySelector(`[data-focus="${CSS.escape(name)}"]`)?.focus();
}
