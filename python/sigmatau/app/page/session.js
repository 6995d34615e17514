// The session: file, options and step, their history, and the fragment of the URL that stores them.

import { isEmpty } from "./dom.js";

const listeners = new Set();
/** States before and after the current one, for undo and redo: {options, exportState}, and {figure} in the step of a figure. */
const histories = { options: { done: [], undone: [] }, figure: { done: [], undone: [] } };
let lastKey = null; // key of the last change of the figure

/** `source` identifies the file: {path} or {file}; null before a file is opened. `exportState`: target and options of the export. `compared`: the comparison, as in the address. `resultSource`: the file of a stored result. `figure`: the clicked points of a figure, see figure_state.js. */
export const session = { source: null, name: "", options: {}, exportState: { target: "", choices: {} }, step: "open", opened: null, result: null, id: null, about: null, compared: null, resultSource: null, figure: null };

/** Identifiers of results, by file and options. */
const results = new Map();

export const onChange = (listener) => listeners.add(listener);
const optionsKey = (options) => JSON.stringify([session.source, options]);

function changed(what) {
  writeFragment();
  for (const listener of listeners) listener(what);
}

/** Change options by name; `undefined` removes an option. `undo` restores the previous state. */
export function setOptions(changes) {
  const next = { ...session.options, ...changes };
  for (const [name, value] of Object.entries(next)) if (isEmpty(value)) delete next[name];
  if (JSON.stringify(next) === JSON.stringify(session.options)) return;
  remember();
  session.options = next;
  changed("options");
}

/** Change the target of the export or its options. */
export function setExport(changes) {
  const next = { ...session.exportState, ...changes };
  if (JSON.stringify(next) === JSON.stringify(session.exportState)) return;
  remember();
  session.exportState = next;
  changed("export");
}

/** Change the clicked points. Consecutive changes with the same key, such as steps of arrow keys, are undone together. */
export function setFigure(figure, key = null) {
  if (JSON.stringify(figure) === JSON.stringify(session.figure)) return;
  if (key === null || key !== lastKey) remember("figure");
  lastKey = key;
  session.figure = figure;
  changed("figure");
}

/** Open a figure, without the history of the previous one. The log of the session stays. */
export function beginFigure(figure) {
  histories.figure = { done: [], undone: [] };
  lastKey = null;
  session.figure = figure;
  changed("figure");
}

const kindOfHistory = () => (session.step === "figure" ? "figure" : "options");
const stated = (kind) => (kind === "figure" ? { figure: session.figure } : { options: session.options, exportState: session.exportState });

function remember(kind = "options") {
  histories[kind].done.push(stated(kind));
  histories[kind].undone.length = 0;
}

export const canUndo = () => histories[kindOfHistory()].done.length > 0;
export const canRedo = () => histories[kindOfHistory()].undone.length > 0;

export function undo() {
  move("done", "undone");
}

export function redo() {
  move("undone", "done");
}

function move(from, to) {
  const kind = kindOfHistory(), history = histories[kind];
  if (!history[from].length) return;
  const before = stated(kind), next = history[from].pop();
  history[to].push(before);
  lastKey = null;
  Object.assign(session, next);
  if (kind === "figure") { changed("figure"); return; }
  if (next.exportState !== before.exportState) changed("export");
  if (next.options !== before.options) changed("options");
}

/** Store the state of the comparison in the address; null if nothing is compared. */
export function setCompared(state) {
  session.compared = state;
  writeFragment();
}

/** Start a session with a file, and discard the previous one. */
export function begin(source, name, options = {}, exportState = { target: session.exportState.target, choices: {} }) {
  histories.options = { done: [], undone: [] };
  Object.assign(session, { source, name, options, exportState, opened: null, result: null, id: null, resultSource: null });
  changed("source");
}

export function setStep(step) {
  session.step = step;
  changed("step");
}

export function setOpened(opened) {
  session.opened = opened;
  changed("opened");
}

export function setResult(id, result) {
  Object.assign(session, { id, result });
  if (session.source) results.set(optionsKey(session.options), id);
  changed("result");
}

export const resultOfOptions = () => results.get(optionsKey(session.options));

/** Write the state into the fragment of the address. */
export function writeFragment() {
  const parts = new URLSearchParams();
  if (session.source?.path) parts.set("path", session.source.path);
  if (session.source?.file) {
    parts.set("file", session.source.file);
    parts.set("name", session.name);
  }
  if (Object.keys(session.options).length) parts.set("options", JSON.stringify(session.options));
  if (session.exportState.target && session.source) parts.set("export", JSON.stringify({ target: session.exportState.target, choices: session.exportState.choices }));
  if (session.id && !session.source) parts.set("result", session.id);
  if (session.compared && session.step === "compare") parts.set("compare", JSON.stringify(session.compared));
  if (session.figure && session.step === "figure") parts.set("figure", JSON.stringify(session.figure));
  if (session.step !== "open") parts.set("step", session.step);
  const fragment = parts.toString();
  if (fragment !== location.hash.slice(1)) history.replaceState(null, "", fragment ? `#${fragment}` : location.pathname);
}

/** Parse the fragment: {source, name, options, exportState, step, result, compared, figure}, or null if it states no file, result, comparison or figure. */
export function readFragment() {
  const parts = new URLSearchParams(location.hash.slice(1));
  const options = objectOf(parts.get("options")), { target = "", choices = {} } = objectOf(parts.get("export"));
  const path = parts.get("path"), file = parts.get("file"), compared = parts.has("compare") ? objectOf(parts.get("compare")) : null;
  const figure = parts.has("figure") ? objectOf(parts.get("figure")) : null;
  if (!path && !file && !parts.get("result") && !compared && !figure) return null;
  const name = parts.get("name") ?? (path ?? "").split(/[\\/]/).pop();
  return { source: path ? { path } : file ? { file } : null, name, options, exportState: { target: String(target), choices: Object(choices) }, step: parts.get("step") ?? "columns", result: parts.get("result"), compared, figure };
}

/** Parse a JSON object; empty if the text is damaged, as in an address that was cut. */
function objectOf(text) {
  try {
    const object = JSON.parse(text ?? "{}");
    return object && typeof object === "object" && !Array.isArray(object) ? object : {};
  } catch {
    return {};
  }
}
