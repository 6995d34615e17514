// The work that takes longer than a frame: records, their curves, and their estimates.

import { coreOf, halfOctaves } from "./core.js";

let module = null, call = null;
let held = ""; // what the record of the core was made from

/** Make the record of a request, unless it is there. Returns its envelope. */
function prepared({ model, samples, seed, columns, log }) {
  const key = log ? log.id : JSON.stringify([model, samples, seed]);
  if (held === key && !columns) return null;
  held = key;
  return log ? call("load", log.tau0, columns || 1, log.samples) : call("simulate", model, samples, seed, columns || 1);
}

const KINDS = {
  /** The record as it is drawn, and its Allan deviation with intervals for the noise of the model. */
  record(request) {
    const envelope = prepared(request);
    const sizes = halfOctaves(request.samples);
    const adev = call("allan", sizes).map(Math.sqrt);
    // The noise of a log is not known: intervals are those of a rate random walk, the widest of the noise terms.
    const { log, model, samples } = request, freedom = call("freedom", log ? [0, 0, 0, 1, 0, 0, 1, 0, 1, log.tau0] : model, samples, sizes);
    return { envelope, sizes, adev, freedom };
  },
  /** The density of the record. */
  density(request) {
    prepared(request);
    return { density: call("density") };
  },
  /** The coefficients of the record, and its density. */
  estimate(request) {
    prepared(request);
    const start = performance.now();
    const values = call("fit");
    return { values, time: performance.now() - start, density: call("density") };
  },
  /** The samples of the record, for a file. */
  samples(request) {
    prepared(request);
    return { rate: call("record") };
  },
  /** Lengths of record: for an error of the deviation, and for each term to be seen. */
  plan({ model, size, error }) {
    const needed = call("needed", model, size, error)[0];
    const seen = [0, 1, 3].map((term) => [0.5, 0.9].map((power) => (model[term] > 0 ? call("visible", model, term, power)[0] : 0)));
    return { needed, seen };
  },
};

self.onmessage = ({ data }) => {
  if (data.module) {
    module = data.module;
    call = coreOf(module);
    return;
  }
  let answer;
  try {
    answer = KINDS[data.kind](data);
  } catch (error) {
    // A panic leaves the memory of the core in any state.
    call = coreOf(module);
    held = "";
    answer = { failed: String(error) };
  }
  self.postMessage({ kind: data.kind, number: data.number, ask: data.ask, ...answer });
};
