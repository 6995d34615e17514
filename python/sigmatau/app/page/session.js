// The session: file, options and step, their history, and the fragment of the URL that stores them.

import { isEmpty } from "./dom.js";

const listeners = new Set();
const done = [], undone = []; // states before and after the current one, for undo and redo: {options, exportState}

/** `source` identifies the file: {path} or {file}; null before a file is opened. `exportState`: target and options of the export. `compared`: the comparison, as in the address. `resultSource`: the file of a stored result. */
export const session = { source: null, name: "", options: {}, exportState: { target: "", choices: {} }, step: "open", opened: null, result: null, id: null, about: null, compared: null, resultSource: null };

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

const stated = () => ({ options: session.options, exportState: session.exportState });

function remember() {
  done.push(stated());
  undone.length = 0;
}

export const canUndo = () => done.length > 0;
export const canRedo = () => undone.length > 0;

export function undo() {
  move(done, undone);
}

export function redo() {
  move(undone, done);
}

function move(from, to) {
  if (!from.length) return;
  const before = stated(), next = from.pop();
  to.push(before);
  Object.assign(session, next);
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
  done.length = undone.length = 0;
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
  if (session.step !== "open") parts.set("step", session.step);
  const fragment = parts.toString();
  if (fragment !== location.hash.slice(1)) history.replaceState(null, "", fragment ? `#${fragment}` : location.pathname);
}

/** Parse the fragment: {source, name, options, exportState, step, result, compared}, or null if it states no file, result or comparison. */
export function readFragment() {
  const parts = new URLSearchParams(location.hash.slice(1));
  const options = objectOf(parts.get("options")), { target = "", choices = {} } = objectOf(parts.get("export"));
  const path = parts.get("path"), file = parts.get("file"), compared = parts.has("compare") ? objectOf(parts.get("compare")) : null;
  if (!path && !file && !parts.get("result") && !compared) return null;
  const name = parts.get("name") ?? (path ?? "").split(/[\\/]/).pop();
  return { source: path ? { path } : file ? { file } : null, name, options, exportState: { target: String(target), choices: Object(choices) }, step: parts.get("step") ?? "columns", result: parts.get("result"), compared };
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
