// What the record gives: the estimate with its intervals, beside what was chosen.

import { make } from "./page.js";
import { text } from "./numbers.js";
import { shown } from "./figures.js";
import { readings } from "./read_off.js";
import { hasNoise, modelNow, samplesNow, sensor, settings, termName, TERMS, unitOf } from "./settings.js";

const TERM_VALUES = 6, HEAD = 4;
const VERDICTS = ["The model describes the record.", "The model describes the record, with the parts below.", "The model is not exact; the intervals are widened."];
const SIGNIFICANCE = 0.05, CLOSE_TO_CERTAIN = 0.99;

/** The numbers of crates/web/src/estimate.rs with names, in SI. */
export function estimateOf(values) {
  const [verdict, pValue, tauMin, tauMax] = values;
  const terms = Object.fromEntries(TERMS.map(({ id }, k) => {
    const [observed, value, low, high, limit, model] = values.slice(HEAD + k * TERM_VALUES);
    return [id, { observed: observed === 1, value, low, high, limit, model }];
  }));
  const rest = values.slice(HEAD + TERMS.length * TERM_VALUES);
  const corner = rest[0] > 0 ? [...rest.slice(0, 3)] : null, lowPass = rest[3] > 0 ? { order: rest[3], corner: rest[4] } : null, processes = [];
  for (let k = 5; k + 5 < rest.length; k += 6) processes.push({ sigma: [...rest.slice(k, k + 3)], time: [...rest.slice(k + 3, k + 6)] });
  return { verdict, pValue, tauMin, tauMax, terms, corner, lowPass, processes };
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

/** Whether a value is within an interval, or below a limit. */
function inside(value, low, high, [yes, no] = ["inside", "outside"]) {
  if (!Number.isFinite(low)) return cell("");
  const holds = holdsIn(value, low, high);
  return cell(make("span", { className: `chip ${holds ? "good" : "partial"}` }, holds ? yes : no));
}

/** What the record holds of a chosen coefficient, in SI; folding changes N behind a filter. */
function truthOf(id) {
  if (!settings.on[id]) return 0;
  return id === "N" && settings.order ? shown.folded.white : settings.value[id] * unitOf(id)[1];
}

/** The corner that a fit of the samples has: the chosen one for a filter before the sampler, else where the samples have half the power. */
function cornerOf({ corner, lowPass }) {
  return lowPass && lowPass.corner === corner[0] ? settings.value.corner : shown.folded.corner;
}

/** A chosen value, with that of the record where folding changes it. */
const chosenWords = (chosen, held) => (Math.abs(held / chosen - 1) < 5e-3 ? text(chosen) : `${text(chosen)}, in the record ${text(held)}`);

/** The terms that describe the noise of a part which was not found. */
function describedBy({ terms }) {
  const ids = TERMS.map(({ id }) => id).filter((id) => terms[id].observed), added = ids.filter((id) => !settings.on[id]);
  const names = (added.length ? added : ids).join(", ");
  return names ? `not seen; described by ${names}` : "not seen";
}

/** Name and letter of a term; a phone shows the letter. */
export const termHead = (id) => make("span", {}, make("span", { className: "term-name" }, `${termName(id)} `), id);

/** Rows of the estimate: model, estimate with its interval or limit, read off by hand. */
export function showEstimate(place) {
  const found = shown.fit?.estimate;
  const row = (name, note, chosen, middle, ends, chip, hand, units) => make("tr", {}, make("th", { scope: "row" }, name, make("small", {}, ` ${note}`), make("span", { className: "unit-below" }, units)),
    cell(chosen, { className: "chosen" }), cell(make("span", {}, middle, " ", make("span", { className: "interval" }, ends))), chip, cell(hand), cell(units, { className: "unit" }));
  const rows = TERMS.map(({ id, slopeText }) => {
    const [units, size] = unitOf(id), present = settings.on[id], truth = truthOf(id) / size;
    const byHand = readings.has(id) ? text(readings.get(id)) : "–", chosen = present ? chosenWords(settings.value[id], truth) : "absent";
    const head = [termHead(id), `slope ${slopeText}`, chosen];
    if (!found) return row(...head, shown.fit ? "–" : "…", "", cell(""), byHand, units);
    const term = found.terms[id], [value, low, high, limit] = scaled([term.value, term.low, term.high, term.limit], size).map(Number);
    if (!term.observed) {
      const isLimited = Number.isFinite(limit);
      return row(...head, isLimited ? `below ${text(Math.abs(limit))}` : "no limit", "not seen",
        inside(Math.abs(truth), isLimited ? 0 : NaN, Math.abs(limit), ["limit holds", "limit too low"]), byHand, units);
    }
    const [middle, ends] = withInterval([value, low, high]);
    return row(...head, middle, ends, inside(truth, low, high), byHand, units);
  });
  function extra(name, chosen, truth, numbers, units) {
    const [middle, ends] = withInterval(numbers);
    rows.push(row(name, "", chosen, middle, ends, truth === null ? cell("") : inside(truth, numbers[1], numbers[2]), "", units));
  }
  const { value, on, order } = settings, [sigmaUnit, sigmaSize] = sensor().units.sigma;
  for (const { sigma, time } of found?.processes ?? []) {
    extra("Gauss–Markov σ", on.sigma ? text(value.sigma) : "absent", on.sigma ? value.sigma : null, scaled(sigma, sigmaSize), sigmaUnit);
    extra("Gauss–Markov time T", on.sigma ? text(value.time) : "absent", on.sigma ? value.time : null, time, "s");
  }
  if (found && on.sigma && !found.processes.length) {
    rows.push(row("Gauss–Markov σ", "", text(value.sigma), describedBy(found), "", cell(""), "", sigmaUnit));
    rows.push(row("Gauss–Markov time T", "", text(value.time), "not seen", "", cell(""), "", "s"));
  }
  const isFiltered = order > 0 && on.N;
  if (found?.corner) {
    const truth = isFiltered ? cornerOf(found) : null;
    extra("Filter corner", isFiltered ? (truth === null ? text(value.corner) : chosenWords(value.corner, truth)) : "absent", truth, found.corner, "Hz");
  } else if (found && isFiltered) rows.push(row("Filter corner", "", text(value.corner), "not seen: the samples look white", "", cell(""), "", "Hz"));
  const head = make("tr", {}, ...["Term", "Chosen", "Estimate [95 % interval]", "Chosen is", "By hand", "Unit"].map((words) => make("th", { scope: "col", className: words === "Unit" ? "unit" : "" }, words)));
  place.replaceChildren(make("table", {}, make("thead", {}, head), make("tbody", {}, ...rows)));
}

const counted = { key: "", records: 0, intervals: 0, holding: 0, seeds: new Set() };

/** Count the intervals and limits that contain the chosen coefficients, over the records of the same settings. */
export function tally({ terms, corner, lowPass }) {
  const key = JSON.stringify([modelNow(), samplesNow()]);
  if (counted.key !== key) Object.assign(counted, { key, records: 0, intervals: 0, holding: 0, seeds: new Set() });
  if (!counted.seeds.has(settings.seed)) {
    counted.seeds.add(settings.seed);
    counted.records++;
    const count = (holds) => { counted.intervals++; if (holds) counted.holding++; };
    for (const { id } of TERMS) {
      const { observed, low, high, limit } = terms[id], truth = truthOf(id);
      if (observed) count(holdsIn(truth, low, high));
      else if (Number.isFinite(limit)) count(Math.abs(truth) <= Math.abs(limit));
    }
    if (corner && settings.order && settings.on.N && cornerOf({ corner, lowPass }) !== null) count(holdsIn(cornerOf({ corner, lowPass }), corner[1], corner[2]));
  }
  const { records, intervals, holding } = counted;
  return `So far ${holding} of ${intervals} intervals and limits contain the true value, in ${records} record${records > 1 ? "s" : ""} of this noise.`;
}

/** The p-value in words. */
function fitInWords(p) {
  if (p > CLOSE_TO_CERTAIN) return `p > ${CLOSE_TO_CERTAIN}: no sign that the model is wrong.`;
  if (p > SIGNIFICANCE) return `p = ${text(p, 2)}, above ${SIGNIFICANCE}: no sign that the model is wrong.`;
  return `p = ${text(p, 2)}, below ${SIGNIFICANCE}: so large a misfit is rare if the model is right.`;
}

/** One sentence on the estimate. */
export function verdictText() {
  const { fit } = shown;
  if (!fit) return "Estimating …";
  if (!hasNoise()) return "There is no noise to estimate. Switch a term other than the ramp on.";
  if (fit.failed) return "This record cannot be estimated. Change the length or the noise.";
  const { verdict, pValue } = fit.estimate;
  return `${VERDICTS[verdict]} Goodness of fit ${fitInWords(pValue)} ${shown.samples.toLocaleString("en")} samples, ${text(fit.time, 2)} ms.`;
}
