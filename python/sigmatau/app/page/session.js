// What the page is about: the file, the options, the step; their history, and the fragment of the URL that has them.

import { isEmpty } from "./dom.js";

const listeners = new Set();
const undone = [], done = []; // what was stated before and after: {options, taken}

/** `source` is what the server calls the file: {path} or {file}; null before one is opened. `taken` is the file for a filter, `compared` what is compared, as the address states it; `resultSource` the file of a result. */
export const session = { source: null, name: "", options: {}, taken: { target: "", choices: {} }, step: "open", opened: null, result: null, id: null, about: null, compared: null, resultSource: null };

/** Results by the file and the options that they were made with. */
const results = new Map();

export const onChange = (listener) => listeners.add(listener);
const optionsKey = (options) => JSON.stringify([session.source, options]);

function changed(what) {
  writeFragment();
  for (const listener of listeners) listener(what);
}

/** Change options: names and their values, undefined removes one. The state before can be had again by `undo`. */
export function setOptions(changes) {
  const next = { ...session.options, ...changes };
  for (const [name, value] of Object.entries(next)) if (isEmpty(value)) delete next[name];
  if (JSON.stringify(next) === JSON.stringify(session.options)) return;
  remember();
  session.options = next;
  changed("options");
}

/** Choose the file for a filter: its target and its choices. */
export function setTaken(changes) {
  const next = { ...session.taken, ...changes };
  if (JSON.stringify(next) === JSON.stringify(session.taken)) return;
  remember();
  session.taken = next;
  changed("taken");
}

const stated = () => ({ options: session.options, taken: session.taken });

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
  if (next.taken !== before.taken) changed("taken");
  if (next.options !== before.options) changed("options");
}

/** What is compared has changed; null if nothing is. */
export function setCompared(state) {
  session.compared = state;
  writeFragment();
}

/** Begin with a file: what was known of another one is forgotten. */
export function begin(source, name, options = {}, taken = { target: session.taken.target, choices: {} }) {
  done.length = undone.length = 0;
  Object.assign(session, { source, name, options, taken, opened: null, result: null, id: null, resultSource: null });
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
  if (session.taken.target && session.source) parts.set("export", JSON.stringify({ target: session.taken.target, choices: session.taken.choices }));
  if (session.id && !session.source) parts.set("result", session.id);
  if (session.compared && session.step === "compare") parts.set("compare", JSON.stringify(session.compared));
  if (session.step !== "open") parts.set("step", session.step);
  const fragment = parts.toString();
  if (fragment !== location.hash.slice(1)) history.replaceState(null, "", fragment ? `#${fragment}` : location.pathname);
}

/** What a fragment says: {source, name, options, taken, step, result, compared}; null where it says nothing. */
export function readFragment() {
  const parts = new URLSearchParams(location.hash.slice(1));
  const options = objectOf(parts.get("options")), { target = "", choices = {} } = objectOf(parts.get("export"));
  const path = parts.get("path"), file = parts.get("file"), compared = parts.has("compare") ? objectOf(parts.get("compare")) : null;
  if (!path && !file && !parts.get("result") && !compared) return null;
  const name = parts.get("name") ?? (path ?? "").split(/[\\/]/).pop();
  return { source: path ? { path } : file ? { file } : null, name, options, taken: { target: String(target), choices: Object(choices) }, step: parts.get("step") ?? "columns", result: parts.get("result"), compared };
}

/** The object of a JSON text; empty for a fragment that was cut. */
function objectOf(text) {
  try {
    const object = JSON.parse(text ?? "{}");
    return object && typeof object === "object" && !Array.isArray(object) ? object : {};
  } catch {
    return {};
  }
}
