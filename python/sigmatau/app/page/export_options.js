// Controls for the options of an export, made of their declarations, and buttons for the options that a note names.

import { make } from "./page.js";
import { button, checkbox, choice, field } from "./dom.js";
import { session } from "./session.js";
import { asPairs } from "./channels.js";

const BARE_NUMBER = /^\d+([.,]\d+)?$/;

/** The choices that the target uses. */
export function placedChoices(target, choices) {
  const placed = Object.entries(choices).filter(([name, value]) => {
    const allowed = target.choices[name];
    return Array.isArray(allowed) && typeof value === "string" ? allowed.includes(value) : Boolean(allowed);
  });
  const keys = target.names.map(({ key }) => key);
  const names = Object.entries(asPairs(choices.name)).filter(([key]) => keys.includes(key));
  return { ...Object.fromEntries(placed), ...(names.length ? { name: Object.fromEntries(names) } : {}) };
}

/** Controls for all options of a target; `set(name, value)` sets an option, and `undefined` removes it. */
export function optionControls(target, sensors, choices, set) {
  const declared = session.about.choices.filter(({ name }) => target.choices[name]);
  return [...declared.flatMap((option) => control(option, target.choices[option.name], sensors, choices[option.name], set)), ...target.names.map((field) => nameControl(field, choices, set))];
}

function control(option, allowed, sensors, value, set) {
  const { name, label, form } = option;
  if (form === "choice") {
    const entries = allowed.map((word) => [word, word === option.default ? `${word} (default)` : word]);
    const select = choice(label, entries, value ?? option.default, (word) => set(name, word === option.default ? undefined : word));
    return [described(option, field(label, focusable(select, name)))];
  }
  if (form === "flag") return [described(option, focusable(checkbox(label, Boolean(value), (on) => set(name, on || undefined)), name))];
  if (option.sensors.length) {
    const used = option.sensors.filter((sensor) => sensors.includes(sensor));
    const words = Array.isArray(allowed) ? make("datalist", { id: `words-${name}` }, ...allowed.map((word) => make("option", { value: word }))) : null;
    const fields = used.map((sensor) => {
      const input = textField(name, asPairs(value)[sensor] ?? "", option.default === null ? "default" : String(option.default), (text) => setKey(name, value, sensor, text, set));
      input.dataset.focus = `export-${name}-${sensor}`;
      input.ariaLabel = `${label}, ${sensor}`;
      if (words) input.setAttribute("list", words.id);
      return field(sensor, input);
    });
    return [described(option, make("div", { role: "group", ariaLabel: label }, make("span", { className: "label" }, label), make("div", { className: "row" }, ...fields), ...(words ? [words] : [])))];
  }
  const typed = (text) => set(name, text ? (option.unit === "s" && BARE_NUMBER.test(text) ? `${text.replace(",", ".")}s` : text) : undefined);
  const input = textField(name, value ?? "", "default", typed);
  return [described(option, field(option.unit && option.unit !== "s" ? `${label} [${option.unit}]` : label, input))];
}

/** Control for a field of the file that is not a noise parameter, such as a topic. */
function nameControl({ key, default: usual, choices: words }, choices, set) {
  const stated = asPairs(choices.name), label = key.replaceAll("_", " ");
  const change = (text) => setKey("name", choices.name, key, text, set);
  if (words.length) return make("div", { className: "option" }, field(label, focusable(choice(label, words.map((word) => [word, word === usual ? `${word} (default)` : word]), stated[key] ?? usual, (word) => change(word === usual ? "" : word)), `name-${key}`)));
  return make("div", { className: "option" }, field(label, textField(`name-${key}`, stated[key] ?? "", usual || "not stated", change)));
}

function described({ text, name }, shown) {
  const about = make("small", { id: `about-${name}` }, text);
  shown.querySelector("input, select")?.setAttribute("aria-describedby", about.id);
  return make("div", { className: "option" }, shown, about);
}

function focusable(shown, name) {
  (shown.matches("input, select") ? shown : shown.querySelector("input")).dataset.focus = `export-${name}`;
  return shown;
}

function textField(name, value, placeholder, change) {
  const input = make("input", { type: "text", value: String(value), placeholder, onchange: () => change(input.value.trim()) });
  return focusable(input, name);
}

function setKey(name, value, key, text, set) {
  const pairs = asPairs(value);
  if (text) pairs[key] = text;
  else delete pairs[key];
  set(name, Object.keys(pairs).length ? pairs : undefined);
}

/** Buttons for the words and flags that a note names. Values that must be typed are set in their controls. */
export function offered(hints, target, choices, set) {
  return (hints ?? []).flatMap(({ option, key, value, text }) => {
    const declared = session.about.choices.find(({ name }) => name === option), allowed = target.choices[option];
    if (!declared || !allowed) return [];
    const pairs = value && typeof value === "object" ? value : key ? { [key]: value } : null;
    const isWord = (word) => declared.choices.includes(word) && (!Array.isArray(allowed) || allowed.includes(word));
    if (declared.form === "flag" && (value === true || value === null)) return choices[option] ? [] : [button(`Set ${text}`, () => set(option, true))];
    if (pairs && Object.values(pairs).every(isWord)) return [button(`Set ${text}`, () => set(option, { ...asPairs(choices[option]), ...pairs }))];
    return !pairs && isWord(value) ? [button(`Set ${text}`, () => set(option, value))] : [];
  });
}
