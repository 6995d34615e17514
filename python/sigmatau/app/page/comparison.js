// What is compared: results of this session, runs of stores, datasheets and noise models; which of them are switched on.

import { openRun, result as fetchResult, runs, specification } from "./api.js";

/** By key: {key, name, number, charts, coefficients}, in the order in which they were added. */
const results = new Map();
/** By key: {key, name, title, charts, origins, source}. */
const specifications = new Map();
/** By key: {key, name, source, unit, runs, further}. */
const stores = new Map();
const shown = new Set();
let count = 0, orders = 0; // of results and of specifications that were added

export const allResults = () => [...results.values()];
export const allSpecifications = () => [...specifications.values()];
export const allStores = () => [...stores.values()];
export const isShown = ({ key }) => shown.has(key);
export const shownResults = () => allResults().filter(isShown);
export const shownSpecifications = () => allSpecifications().filter(isShown);

/** Keep a result for comparisons. */
export function rememberResult(id, result, name = resultName(result)) {
  if (results.has(id)) return;
  count += 1;
  results.set(id, { key: id, name, number: count, charts: result.charts, coefficients: result.summary.coefficients });
  shown.add(id);
}

const pairText = (value) => Object.entries(value).map(([key, text]) => (Array.isArray(value) ? text : `${key}=${text}`)).join(",");

function resultName({ options, summary: { title } }) {
  const texts = Object.entries(options ?? {}).map(([name, value]) => `${name} ${typeof value === "object" ? pairText(value) : value}`);
  return [title, ...texts].join(", ");
}

export function show({ key }, isOn) {
  if (isOn) shown.add(key);
  else shown.delete(key);
}

export function remove({ key }) {
  for (const each of [results, specifications]) each.delete(key);
  shown.delete(key);
}

/** Keep a store that was opened, with its runs. */
export function addStore(source, name, { runs: listed, more }) {
  const key = JSON.stringify(source);
  stores.set(key, { key, name, source, unit: "", runs: listed, further: more });
}

/** List the runs of some units of a store. */
export async function chooseUnits(store, unit) {
  const { runs: listed, more } = await runs(store.source, unit || null);
  Object.assign(store, { unit, runs: listed, further: more });
}

const runKeys = new Map(); // of runs that were added
const runKey = (store, run) => `${store.key} ${run.run}`;
export const isAdded = (store, run) => results.has(runKeys.get(runKey(store, run)));

/** Add the result of a run of a store. */
export async function addRun(store, run) {
  const { result: id, name } = await openRun(store.source, run.run);
  rememberResult(id, await fetchResult(id), name);
  runKeys.set(runKey(store, run), id);
}

/** Add the curves of a datasheet or a noise model: `named` is {name} of the library, or {path} or {file}. */
export async function addSpecification(named, choices = {}) {
  const content = await specification(named, choices);
  const key = JSON.stringify([named, choices]);
  orders += 1;
  specifications.set(key, { ...content, key, order: orders - 1, title: content.name, name: content.name.split(" (")[0] });
  shown.add(key);
}
