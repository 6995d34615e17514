// What the record gives: the estimate with its intervals, the errors beside each other, the length of record.

import { make } from "./page.js";
import { text } from "./numbers.js";
import { errorOfPaper, shown } from "./figures.js";
import { readings } from "./read_off.js";
import { hasNoise, modelNow, samplesNow, sensor, settings, termName, TERMS, timeText, unitOf } from "./settings.js";

const TERM_VALUES = 6, HEAD = 4;
const VERDICTS = ["The model describes the record.", "The model describes the record, with the parts below.", "The model is not exact; the intervals are widened."];

/** The numbers of crates/web/src/estimate.rs with names, in SI. */
export function estimateOf(values) {
  const [verdict, pValue, tauMin, tauMax] = values;
  const terms = Object.fromEntries(TERMS.map(({ id }, k) => {
    const [observed, value, low, high, limit, model] = values.slice(HEAD + k * TERM_VALUES);
    return [id, { observed: observed === 1, value, low, high, limit, model }];
  }));
  const rest = values.slice(HEAD + TERMS.length * TERM_VALUES);
  const corner = rest[0] > 0 ? [...rest.slice(0, 3)] : null, processes = [];
  for (let k = 3; k + 5 < rest.length; k += 6) processes.push({ sigma: [...rest.slice(k, k + 3)], time: [...rest.slice(k + 3, k + 6)] });
  return { verdict, pValue, tauMin, tauMax, terms, corner, processes };
}

const scaled = (values, size) => values.map((value) => value / size);

/** A value and the ends of its interval, with two digits of the error. */
function withInterval([value, low, high]) {
  if (!Number.isFinite(low) || !(high > low)) return [text(value), ""];
  const decimals = 1 - Math.floor(Math.log10((high - low) / 2)), size = 10 ** decimals;
  const shown = (x) => (decimals >= 0 ? x.toFixed(Math.min(decimals, 12)) : String(Math.round(x * size) / size));
  return [shown(value), `[${shown(low)}, ${shown(high)}]`];
}

const cell = (words, attributes = {}) => make("td", attributes, words);

const holdsIn = (value, low, high) => value >= low && value <= high;

/** Whether a value is within an interval. */
function inside(value, low, high) {
  if (!Number.isFinite(low)) return cell("");
  const holds = holdsIn(value, low, high);
  return cell(make("span", { className: `chip ${holds ? "good" : "partial"}` }, holds ? "inside" : "outside"));
}

/** Rows of the estimate: model, estimate with its interval or limit, read off by hand. */
export function showEstimate(place) {
  const found = shown.fit?.estimate;
  const rows = TERMS.map(({ id, slopeText }) => {
    const [units, size] = unitOf(id), present = settings.on[id], truth = present ? settings.value[id] : 0;
    const byHand = readings.has(id) ? `${text(readings.get(id))}` : "–";
    const head = [make("th", { scope: "row" }, `${termName(id)} ${id}`, make("small", {}, ` slope ${slopeText}`)), cell(present ? text(truth) : "absent")];
    if (!found) return make("tr", {}, ...head, cell(shown.fit ? "–" : "…"), cell(""), cell(""), cell(byHand), cell(units));
    const term = found.terms[id], [value, low, high, limit] = scaled([term.value, term.low, term.high, term.limit], size);
    if (!term.observed) {
      const words = Number.isFinite(limit) ? `below ${text(Math.abs(limit))}` : "no limit";
      return make("tr", {}, ...head, cell(words), cell("not seen"), inside(Math.abs(truth), Number.isFinite(limit) ? 0 : NaN, Math.abs(limit)), cell(byHand), cell(units));
    }
    const [middle, ends] = withInterval([value, low, high]);
    return make("tr", {}, ...head, cell(middle), cell(ends, { className: "interval" }), inside(truth, low, high), cell(byHand), cell(units));
  });
  function extra(name, truth, [value, low, high], units) {
    const [middle, ends] = withInterval([value, low, high]);
    return make("tr", {}, make("th", { scope: "row" }, name), cell(truth === null ? "absent" : text(truth)), cell(middle),
      cell(ends, { className: "interval" }), truth === null ? cell("") : inside(truth, low, high), cell(""), cell(units));
  }
  for (const { sigma, time } of found?.processes ?? []) {
    const present = settings.on.sigma;
    rows.push(extra("Gauss–Markov σ", present ? settings.value.sigma : null, scaled(sigma, sensor().units.sigma[1]), sensor().units.sigma[0]));
    rows.push(extra("Gauss–Markov time T", present ? settings.value.time : null, time, "s"));
  }
  if (found?.corner) rows.push(extra("Filter corner", settings.order ? settings.value.corner : null, found.corner, "Hz"));
  const head = make("tr", {}, ...["Term", "Chosen", "Estimate", "95 % interval", "Chosen is", "By hand", "Unit"].map((words) => make("th", { scope: "col" }, words)));
  place.replaceChildren(make("table", {}, make("thead", {}, head), make("tbody", {}, ...rows)));
}

const counted = { key: "", records: 0, intervals: 0, holding: 0, seeds: new Set() };

/** Count the intervals and limits that contain the chosen coefficients, over the records of the same settings. */
export function tally({ terms }) {
  const key = JSON.stringify([modelNow(), samplesNow()]);
  if (counted.key !== key) Object.assign(counted, { key, records: 0, intervals: 0, holding: 0, seeds: new Set() });
  if (!counted.seeds.has(settings.seed)) {
    counted.seeds.add(settings.seed);
    counted.records++;
    for (const { id } of TERMS) {
      const { observed, low, high, limit } = terms[id], truth = settings.on[id] ? settings.value[id] * unitOf(id)[1] : 0;
      if (!observed && !Number.isFinite(limit)) continue;
      counted.intervals++;
      if (observed ? holdsIn(truth, low, high) : Math.abs(truth) <= Math.abs(limit)) counted.holding++;
    }
  }
  const { records, intervals, holding } = counted;
  return `So far ${holding} of ${intervals} intervals and limits hold, in ${records} record${records > 1 ? "s" : ""} of this noise.`;
}

/** One sentence on the estimate. */
export function verdictText() {
  const { fit } = shown;
  if (!fit) return "Estimating …";
  if (!hasNoise()) return "There is no noise to estimate. Switch a term other than the ramp on.";
  if (fit.failed) return "This record cannot be estimated. Change the length or the noise.";
  const { verdict, pValue } = fit.estimate;
  return `${VERDICTS[verdict]} Goodness of fit p = ${text(pValue, 2)}. ${shown.samples.toLocaleString("en")} samples, ${text(fit.time, 2)} ms.`;
}

const SHARES = [[1000, "1/1000"], [100, "1/100"], [30, "1/30"], [10, "1/10"], [5, "1/5"], [3, "1/3"]];

/** The table of errors: eq. (26) and the exact one at shares of the record. */
export function showErrors(place, figures) {
  const limits = figures.limits(), samples = figures.samples();
  if (!limits) return;
  const rows = SHARES.flatMap(([share, words]) => {
    const size = samples / share;
    if (size < 1) return [];
    const tau = size * figures.tau0();
    let best = 0;
    limits.tau.forEach((t, k) => { if (Math.abs(Math.log(t / tau)) < Math.abs(Math.log(limits.tau[best] / tau))) best = k; });
    const at = limits.tau[best], exact = limits.exact[best], paper = 100 * errorOfPaper(samples, at / figures.tau0());
    return [make("tr", {}, make("th", { scope: "row" }, timeText(at)), cell(words), cell(`${text(paper, 2)} %`), cell(`${text(exact, 2)} %`), cell(text(paper / exact, 2)))];
  });
  const head = make("tr", {}, ...["τ", "of the record", "eq. (26)", "exact", "ratio"].map((words) => make("th", { scope: "col" }, words)));
  place.replaceChildren(make("table", {}, make("thead", {}, head), make("tbody", {}, ...rows)));
}

/** Length of record by eq. (26) for an error of a deviation at τ: N = n·(1 + 1/(2δ²)). [s] */
export const lengthOfPaper = (tau, error) => tau * (1 + 1 / (2 * error * error));

/** "How long must I record?": for an error of a point, and for each term to be seen. */
export function showPlan(place, { tau, error, needed, seen }) {
  const rate = settings.value.rate, length = (samples) => (samples ? timeText(samples / rate) : "more than 10⁸ samples");
  const point = make("p", {}, `σ(${timeText(tau)}) within ${text(100 * error)} %, one standard error: eq. (26) asks for `, make("b", {}, timeText(lengthOfPaper(tau, error))),
    ", the exact error of this noise for ", make("b", {}, length(needed)), ".");
  const rows = [0, 1, 3].flatMap((index, row) => {
    const { id } = TERMS[index];
    if (!settings.on[id]) return [];
    const isAlone = !seen[row][0] && TERMS.every((term) => term.id === id || term.id === "R" || !settings.on[term.id]) && !settings.on.sigma;
    const words = isAlone ? ["any length", "any length"] : seen[row].map(length);
    return [make("tr", {}, make("th", { scope: "row" }, `${termName(id)} ${id} = ${text(settings.value[id])} ${unitOf(id)[0]}`), ...words.map((each) => cell(each)))];
  });
  const head = make("tr", {}, ...["To see", "in half of the records", "in nine of ten"].map((words) => make("th", { scope: "col" }, words)));
  const parts = [point];
  if (rows.length) parts.push(make("div", { className: "scrolled" }, make("table", {}, make("thead", {}, head), make("tbody", {}, ...rows))));
  place.replaceChildren(...parts);
}
