// State of the comparison: results of this session, of files and of stores, datasheets and noise models, and which are switched on.

import { openRun, result as fetchResult, runs, specification } from "./api.js";
import { setCompared } from "./session.js";

/** By key: {key, name, number, charts, coefficients, from}, in the order in which they were added. */
const results = new Map();
/** By key: {key, name, title, charts, origins, source, from}. */
const specifications = new Map();
/** By key: {key, name, source, unit, runs, further}. */
const stores = new Map();
const shown = new Set();
const pair = { first: null, second: null }; // keys of the results whose difference is shown
let count = 0, orders = 0; // numbers of results and of specifications that were added so far

export const allResults = () => [...results.values()];
export const allSpecifications = () => [...specifications.values()];
export const allStores = () => [...stores.values()];
export const isShown = ({ key }) => shown.has(key);
export const shownResults = () => allResults().filter(isShown);
export const shownSpecifications = () => allSpecifications().filter(isShown);

/** Add a result to the comparison. `from` states how to make it again: {source, name, options}, {store, run}, or {id}. */
export function rememberResult(id, result, from, name = resultName(result)) {
  if (results.has(id)) return;
  count += 1;
  results.set(id, { key: id, name, number: count, charts: result.charts, coefficients: result.summary.coefficients, from });
  shown.add(id);
  noteState();
}

const pairText = (value) => Object.entries(value).map(([key, text]) => (Array.isArray(value) ? text : `${key}=${text}`)).join(",");

function resultName({ options, summary: { title } }) {
  const texts = Object.entries(options ?? {}).map(([name, value]) => `${name} ${typeof value === "object" ? pairText(value) : value}`);
  return [title, ...texts].join(", ");
}

export function show({ key }, isOn) {
  if (isOn) shown.add(key);
  else shown.delete(key);
  noteState();
}

export function remove({ key }) {
  for (const each of [results, specifications]) each.delete(key);
  shown.delete(key);
  noteState();
}

/** The old and the new result whose difference is shown: the chosen ones, otherwise the first and the last that are switched on. */
export function chosenPair() {
  const listed = shownResults(), first = listed.find(({ key }) => key === pair.first) ?? listed[0];
  const rest = listed.filter((each) => each !== first);
  return [first, rest.find(({ key }) => key === pair.second) ?? rest[rest.length - 1]];
}

export function choosePair(first, second) {
  Object.assign(pair, { first: first.key, second: second.key });
  noteState();
}

/** Add a store with its runs. */
export function addStore(source, name, { runs: listed, more }) {
  const key = JSON.stringify(source);
  stores.set(key, { key, name, source, unit: "", runs: listed, further: more });
  noteState();
}

/** List the runs of some units of a store. */
export async function chooseUnits(store, unit) {
  const { runs: listed, more } = await runs(store.source, unit || null);
  Object.assign(store, { unit, runs: listed, further: more });
  noteState();
}

export const isAdded = (store, run) => allResults().some(({ from }) => from.run === run.run && JSON.stringify(from.store) === store.key);

/** Add the result of a run of a store: `run` is its number there. */
export async function addRun(source, run) {
  const { result: id, name } = await openRun(source, run);
  rememberResult(id, await fetchResult(id), { store: source, run }, name);
  return id;
}

/** Add the curves of a datasheet or a noise model: `named` is {name} of the library, or {path} or {file}. */
export async function addSpecification(named, choices = {}) {
  const content = await specification(named, choices);
  const key = JSON.stringify([named, choices]);
  orders += 1;
  specifications.set(key, { ...content, key, order: orders - 1, title: content.name, name: content.name.split(" (")[0], from: { named, choices } });
  shown.add(key);
  noteState();
}

/** Write the comparison into the address: how each part is made again, which parts are switched off, and the chosen pair. */
function noteState() {
  const off = (each) => (isShown(each) ? {} : { off: true });
  const [first, second] = [pair.first, pair.second].map((key) => allResults().findIndex((each) => each.key === key));
  const state = {
    results: allResults().map((each) => ({ ...each.from, ...off(each) })),
    specifications: allSpecifications().map((each) => ({ ...each.from, ...off(each) })),
    stores: allStores().map(({ source, name, unit }) => ({ source, name, ...(unit ? { unit } : {}) })),
    ...(first >= 0 && second >= 0 ? { pair: [first, second] } : {}),
  };
  setCompared(state.results.length + state.specifications.length + state.stores.length ? state : null);
}

/** Restore the comparison that an address states. `again` restores a result; `failed` is called with errors. */
export async function restoreComparison(state, again, failed) {
  const made = async (make) => {
    try {
      return await make();
    } catch (error) {
      failed(error);
      return null;
    }
  };
  const keys = [];
  for (const { off, ...from } of listIn(state.results)) {
    const key = await made(() => (from.store ? addRun(from.store, from.run) : again(from)));
    keys.push(key);
    if (off && key) shown.delete(key);
  }
  for (const { named, choices, off } of listIn(state.specifications)) {
    await made(() => addSpecification(named, choices));
    if (off) shown.delete(JSON.stringify([named, choices]));
  }
  for (const { source, name, unit } of listIn(state.stores)) await made(async () => addStore(source, name, await runs(source, unit || null)));
  const [first, second] = listIn(state.pair).map((index) => keys[index]);
  if (first && second) Object.assign(pair, { first, second });
  noteState();
}

const listIn = (value) => (Array.isArray(value) ? value : []);
