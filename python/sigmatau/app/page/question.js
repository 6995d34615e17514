// Questions that must be answered before a log can be analysed: the question, rows of the file, and the choices.

import { make } from "./page.js";
import { bdi, button } from "./dom.js";
import { session } from "./session.js";
import { asPairs, ofSession, sensorName, topicChanges, UNITS } from "./channels.js";
import { text } from "./numbers.js";

const optionLabel = (option) => session.about.labels[option] ?? option.replaceAll("_", " ");
const PLACEHOLDER = /^(HZ|N|N:N|[A-Z]+|…|\.\.\.)$/; // a word in capitals stands for a value

/** Box with a question of a log or of an error, and its choices.
 *
 * `opened` has the topics. `options` reads and changes the options; `hasTable` states that a table of columns is below.
 */
export function questionBox(question, opened, options = ofSession) {
  const hints = distinct([question.hint ?? question.hints ?? []].flat());
  const topics = opened?.topics ?? [];
  const isTopic = (question.option === "topic" || hints.some((hint) => hint.option === "topic")) && topics.length;
  return make("div", { className: "box partial", role: "group", ariaLabel: "A choice is needed" },
    make("h2", {}, "A choice is needed"),
    make("p", {}, sentence(question.question ?? question.message)),
    ...(question.rows ? [make("pre", { tabIndex: 0, role: "region", ariaLabel: "Rows of the file" }, question.rows)] : []),
    ...(isTopic ? [topicChoices(topics, hints.filter(isPair).map(({ value }) => value), options)] : []),
    ...(options.hasTable && hints.some((hint) => hint.option === "channels" && isMapping(hint)) ? [make("p", {}, "Choose the use of each column in the table below, or state it here:")] : []),
    ...mappingChoices(hints.filter(isMapping), options),
    ...hints.filter((hint) => !isMapping(hint) && (hint.option !== "topic" || !isTopic) && !(options.hasTable && hint.option === "channels" && hint.key)).map((hint) => hintChoice(hint, options)));
}

/** Remove repeated hints: a message can name an option in each of its choices. */
function distinct(hints) {
  return [...new Map(hints.map((hint) => [JSON.stringify([hint.option, hint.key, hint.value]), hint])).values()];
}

/** Complete a message to a sentence; "has …" is a message that follows the name of the file. */
export function sentence(message) {
  if (/^(has|does|is|contains|states) /.test(message)) return `The file ${message}.`;
  return /^(an?|no|the|these|this) /.test(message) ? `${message[0].toUpperCase()}${message.slice(1)}.` : `${message}.`;
}

/** Buttons for pairs of topics of one device, then for each topic; topics with sensors come first. */
function topicChoices(topics, pairs, options) {
  const rows = [];
  for (const { name, rate_hz: rate, rows: count, channels } of [...topics].sort((a, b) => b.channels.length - a.channels.length)) {
    const facts = [rate ? `${text(rate)} Hz` : "", count ? `${count} rows` : "", signals(channels)];
    rows.push(topicChoice([name], facts.filter(Boolean).join(" · "), options));
  }
  return make("ul", { className: "entries" }, ...pairs.map((names) => topicChoice(names, "one device", options)), ...rows);
}

/** Names of the channels without the time, each once. */
const signals = (channels) => [...new Set(channels)].filter((name) => name !== "time").join(" ");

function topicChoice(names, facts, options) {
  const name = names.join(" and "), read = () => options.change(topicChanges(names.length > 1 ? names : names[0]));
  return make("li", {}, make("button", { type: "button", className: "entry", onclick: read, ariaLabel: `Read topic ${name}${facts ? `, ${facts}` : ""}` }, make("b", {}, bdi(name)), make("small", {}, facts)));
}

const isMapping = ({ value }) => Boolean(value) && typeof value === "object" && !Array.isArray(value);

const isPair = ({ option, value }) => option === "topic" && Array.isArray(value) && value.length > 1;

/** Choices of options with values by channel or sensor: a button for each, and a field if numbers of columns must be typed. */
function mappingChoices(hints, options) {
  const rows = new Map();
  for (const { option, value, text: pageWords, remark } of hints) {
    const name = option.replaceAll("_", "-"), pairs = Object.entries(value).map((pair) => pair.join("=")).join(", ");
    if (!rows.has(name)) rows.set(name, make("p", { className: "row" }, make("span", {}, `${optionLabel(option)}:`)));
    const control = Object.values(value).some((part) => PLACEHOLDER.test(String(part)))
      ? typed("", "", pairs, (stated) => options.change({ [name]: stated }))
      : button(pageWords ?? pairs, () => options.change({ [name]: { ...asPairs(options.all()[name]), ...value } }));
    rows.get(name).append(make("span", { className: "answer" }, control, ...(remark ? [make("small", {}, remark)] : [])));
  }
  return [...rows.values()];
}

/** Choices of an option: buttons for possible values, and a field for a value that must be typed. */
function hintChoice({ option, key, value, text: pageWords }, options) {
  const name = option.replaceAll("_", "-"), label = `${optionLabel(option)}${key ? ` of ${key}` : ""}`;
  const set = (stated) => options.change({ [name]: key ? { ...asPairs(options.all()[name]), [key]: stated } : stated });
  if (option === "unit" && key) {
    const usual = UNITS[sensorName(key)] ?? [], units = value && !usual.includes(value) && !PLACEHOLDER.test(value) ? [value, ...usual] : usual;
    return make("p", { className: "row" }, make("span", {}, `${label}:`), ...units.map((unit) => button(unit, () => set(unit), { ariaLabel: `${label}: ${unit}` })), typed("another", "", "", set));
  }
  if (value === true) return make("p", { className: "row" }, button(`Set ${pageWords ?? name}`, () => set(true)));
  const example = String(value ?? ""), isPlaceholder = PLACEHOLDER.test(example);
  return make("p", { className: "row" }, typed(label, isPlaceholder ? "" : example, isPlaceholder && option !== "rate" ? example : "", set));
}

function typed(label, value, placeholder, set) {
  const input = make("input", { type: "text", size: Math.max(14, placeholder.length), value, placeholder, ariaLabel: label || placeholder });
  return make("form", { className: "row", onsubmit: (event) => { event.preventDefault(); if (input.value.trim()) set(input.value.trim()); } },
    make("label", {}, label ? `${label} ` : "", input), make("button", { type: "submit" }, "Set"));
}
