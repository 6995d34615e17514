// "How far can a point be trusted?" and "How long must I record?": errors and lengths of record.

import { make } from "./page.js";
import { text } from "./numbers.js";
import { errorOfPaper } from "./figures.js";
import { termHead } from "./results.js";
import { settings, TERMS, timeText, unitOf } from "./settings.js";

const SHARES = [1000, 100, 30, 10, 5, 3];
const LONGEST_TAU = 1e4; // longest averaging time of the question [h]

/** A table with a head, in a region that scrolls. */
function tableWith(head, rows) {
  const columns = make("tr", {}, ...head.map((words) => make("th", { scope: "col" }, words)));
  const cells = rows.map(([first, ...rest]) => make("tr", {}, make("th", { scope: "row" }, first), ...rest.map((words) => make("td", {}, words))));
  return make("table", {}, make("thead", {}, columns), make("tbody", {}, ...cells));
}

/** The table of errors: eq. (26) and the exact one, close to shares of the record. */
export function showErrors(place, figures) {
  const limits = figures.limits(), samples = figures.samples();
  if (!limits) return;
  const rows = SHARES.flatMap((share) => {
    if (samples < share) return [];
    const tau = (samples / share) * figures.tau0();
    let best = 0;
    limits.tau.forEach((t, k) => { if (Math.abs(Math.log(t / tau)) < Math.abs(Math.log(limits.tau[best] / tau))) best = k; });
    const at = limits.tau[best], size = at / figures.tau0(), exact = limits.exact[best], paper = 100 * errorOfPaper(samples, size);
    return [[timeText(at), `1/${text(samples / size, 2)}`, `${text(paper, 2)} %`, `${text(exact, 2)} %`, text(paper / exact, 2)]];
  });
  place.replaceChildren(tableWith(["τ", "of the record", "eq. (26)", "exact", "ratio"], rows));
}

/** Length of record by eq. (26) for an error of a deviation at τ: N = n·(1 + 1/(2δ²)). [s] */
export const lengthOfPaper = (tau, error) => tau * (1 + 1 / (2 * error * error));

/** The numbers of the two boxes: {tau, error, problem}; τ is a whole number of samples. Boxes with other values are marked. */
export function questionOf(tauBox, errorBox, tau0) {
  const numberIn = (box) => Number(box.value.trim().replace(",", ".") || NaN);
  const tau = numberIn(tauBox), percent = numberIn(errorBox), most = 3600 * LONGEST_TAU;
  const isTau = tau >= tau0 * (1 - 1e-9) && tau <= most, isError = percent >= 0.1 && percent <= 70;
  tauBox.setAttribute("aria-invalid", String(!isTau));
  errorBox.setAttribute("aria-invalid", String(!isError));
  const problem = !isTau ? `τ must be a number from ${text(tau0)} s, the sample interval, to ${text(most)} s.` : !isError ? "The error must be a number from 0.1 % to 70 %." : null;
  return { tau: Math.max(1, Math.round(tau / tau0)) * tau0, error: percent / 100, problem };
}

/** For an error of a point, for each term to be told from zero, and for the same error of its coefficient. */
export function showPlan(place, { tau, error, needed, seen, coefficients }) {
  const rate = settings.value.rate, length = (samples) => (samples ? timeText(samples / rate) : "more than 10⁸ samples");
  const point = make("p", {}, `A point: σ(${timeText(tau)}) within ${text(100 * error)} %, one sigma: eq. (26) asks for `, make("b", {}, timeText(lengthOfPaper(tau, error))),
    ", the exact error of this noise for ", make("b", {}, length(needed)), ". A point of the curve is not a coefficient, which uses all points:");
  const rows = TERMS.flatMap(({ id }, index) => {
    if (!settings.on[id] || id === "R") return [];
    const row = [0, 1, 3].indexOf(index), isAlone = TERMS.every((term) => term.id === id || term.id === "R" || !settings.on[term.id]) && !settings.on.sigma;
    // While a Gauss–Markov process is present, it explains the slow noise as well.
    const isPlanned = row >= 0 && !(id === "K" && settings.on.sigma);
    const words = isAlone ? ["the shortest record", "the shortest record"] : isPlanned ? seen[row].map(length) : ["sigmatau plan", "sigmatau plan"];
    const bound = coefficients[id] ?? 0, shortest = isPlanned && !isAlone ? seen[row][0] : 1, precise = bound && shortest ? Math.max(bound, shortest) : 0;
    return [[make("span", {}, termHead(id), ` = ${text(settings.value[id])} ${unitOf(id)[0]}`), ...words, length(precise)]];
  });
  const parts = [point];
  if (rows.length) parts.push(make("div", { className: "scrolled", tabIndex: 0, role: "region", ariaLabel: "Lengths of record" },
    tableWith(["To tell it from zero:", "in half of the records", "in nine of ten", `For ±${text(100 * error)} % of the coefficient (one sigma)`], rows)));
  place.replaceChildren(...parts);
}
