// Several results of this session beside each other.

import { make } from "./page.js";
import { compare } from "./api.js";
import { checkbox, errorBox } from "./dom.js";

const results = new Map(); // id → name, in the order in which they were made
const chosen = new Set();

/** Keep a result for comparisons. */
export function rememberResult(id, result) {
  if (results.has(id)) return;
  results.set(id, `${result.summary.title}, ${result.command ? result.command.split(" ").slice(3).join(" ") || "defaults" : "stored"}`);
  chosen.add(id);
}

export const comparable = () => results.size;

/** Show the step. */
export function showCompare(view) {
  const place = make("div");
  const boxes = [...results].map(([id, name]) => checkbox(name, chosen.has(id), (on) => { on ? chosen.add(id) : chosen.delete(id); fillTable(place); }));
  view.replaceChildren(make("div", { className: "head" }, make("div", {}, make("h1", {}, "Compare"), make("p", { className: "about" }, "Results of this session: open another log or a stored result to add it."))),
    make("fieldset", {}, make("legend", {}, "Results"), ...boxes), place);
  return fillTable(place);
}

async function fillTable(place) {
  const ids = [...results.keys()].filter((id) => chosen.has(id));
  if (ids.length < 2) {
    place.replaceChildren(make("p", { className: "none" }, "Choose two results or more."));
    return;
  }
  try {
    const { text } = await compare(ids);
    place.replaceChildren(make("pre", { tabIndex: 0, role: "region", ariaLabel: "Comparison", className: "comparison" }, text));
  } catch (error) {
    place.replaceChildren(errorBox(error));
  }
}

