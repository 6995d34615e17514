// Numbers of a comparison: differences with their intervals, coefficients beside each other, repeatability.

import { make } from "./page.js";
import { compare } from "./api.js";
import { bdi, chip, choice, errorBox, field } from "./dom.js";
import { shownResults } from "./comparison.js";
import { raised } from "./summary.js";

const VERDICTS = { same: ["same", "good"], differs: ["differs", "poor"], unknown: ["cannot tell", "partial"] };
const chosen = { first: null, second: null }; // keys of the results whose difference is shown
let running = 0; // number of the last comparison that was asked for

/** Show the numbers of all results that are switched on; of one alone its coefficients. */
export async function showNumbers(places) {
  const shown = shownResults(), asked = (running += 1);
  for (const place of Object.values(places)) place.parentElement.hidden = shown.length < 2;
  places.coefficients.parentElement.hidden = !shown.length;
  if (shown.length) places.coefficients.replaceChildren(coefficientTable(shown));
  if (shown.length < 2) return;
  const pair = chosenPair(shown);
  for (const place of [places.difference, places.repeatability]) place.setAttribute("aria-busy", "true");
  try {
    const between = await compare(pair.map(({ key }) => key));
    const all = shown.length === 2 && pair[0] === shown[0] ? between : await compare(shown.map(({ key }) => key));
    if (asked !== running) return;
    places.difference.replaceChildren(pairControls(shown, pair, () => showNumbers(places)), ...differenceTable(between));
    places.repeatability.replaceChildren(...repeatability(all));
  } catch (error) {
    if (asked === running) { places.difference.replaceChildren(errorBox(error)); places.repeatability.replaceChildren(); }
  } finally {
    for (const place of [places.difference, places.repeatability]) place.removeAttribute("aria-busy");
  }
}

/** The two results whose difference is shown: those that were chosen, or the first and the last one. */
function chosenPair(shown) {
  const first = shown.find(({ key }) => key === chosen.first) ?? shown[0];
  const rest = shown.filter((each) => each !== first);
  return [first, rest.find(({ key }) => key === chosen.second) ?? rest[rest.length - 1]];
}

const numbered = ({ number, name }) => `${number}: ${name}`;

function pairControls(shown, [first, second], change) {
  const entries = (without) => shown.filter((each) => each !== without).map((each) => [each.key, numbered(each)]);
  const select = (label, entries, value, set) => field(label, choice(label, entries, value.key, (key) => { set(key); change(); }));
  return make("div", { className: "row" },
    select("Of", entries(first), second, (key) => { chosen.second = key; }),
    select("against", entries(null), first, (key) => { chosen.first = key; if (key === second.key) chosen.second = first.key; }));
}

/** The difference of each coefficient with its interval, and how many differ. */
function differenceTable({ differences, same_log: isSameLog }) {
  if (!differences.length) return [make("p", { className: "none" }, "These results have no coefficient in common.")];
  const counts = Object.keys(VERDICTS).map((verdict) => [VERDICTS[verdict], differences.filter((each) => each.verdict === verdict).length]);
  const rows = differences.map(({ channel, term, text, verdict }) => make("tr", {}, make("th", { scope: "row" }, bdi(channel)), make("th", { scope: "row" }, term.replaceAll("_", " ")),
    make("td", {}, chip(...VERDICTS[verdict])), make("td", {}, ...(text ? raised(text) : ["one is an upper limit"]))));
  const doubt = isSameLog ? [make("p", { className: "box partial" }, "Both results are of the same log, so their errors are not independent: these intervals do not hold.")] : [];
  return [
    ...doubt,
    make("p", { className: "verdicts" }, ...counts.filter(([, number]) => number).flatMap(([[word, mark], number]) => [chip(`${number} ${word}`, mark), " "])),
    make("p", { className: "about" }, "Same: the 95 % interval of the difference has 0 in it. Of 20 equal coefficients one is outside by chance."),
    scrolled("Differences", make("table", { className: "compared" }, head("Channel", "Term", "Verdict", "Difference"), make("tbody", {}, ...rows))),
  ];
}

/** The coefficients of the results beside each other, a row a channel and term. */
function coefficientTable(shown) {
  const rows = new Map();
  shown.forEach(({ coefficients }, k) => {
    for (const { channel, rows: terms } of coefficients) for (const [term, value, interval, unit] of terms) {
      const key = `${channel} ${term}`;
      if (!rows.has(key)) rows.set(key, { channel, term, cells: shown.map(() => null), unit });
      rows.get(key).unit ||= unit;
      rows.get(key).cells[k] = { value, interval: /^\[|±/.test(interval) ? interval : "" };
    }
  });
  const body = [...rows.values()].map(({ channel, term, cells, unit }) => make("tr", {},
    make("th", { scope: "row" }, bdi(channel)), make("th", { scope: "row" }, term), make("td", {}, ...raised(unit)),
    ...cells.map((cell) => make("td", { className: "value" }, cell ? cell.value : "–", ...(cell?.interval ? [" ", make("span", { className: "interval" }, cell.interval)] : [])))));
  return scrolled("Coefficients of the results", make("table", { className: "compared" }, head("Channel", "Term", "Unit", ...shown.map(({ number }) => `result ${number}`)), make("tbody", {}, ...body)));
}

/** The summary of the runs, and Tables I and III of the paper. */
function repeatability({ text, tables, unused }) {
  const block = (label, words) => make("pre", { tabIndex: 0, role: "region", ariaLabel: label, className: "comparison" }, words);
  return [
    ...unused.map((line) => make("p", { className: "about" }, bdi(`${line[0].toUpperCase()}${line.slice(1)}.`))),
    block("Repeatability", text), make("h3", {}, "Tables I and III of the paper"), block("Tables I and III", tables),
  ];
}

function head(...names) {
  return make("thead", {}, make("tr", {}, ...names.map((name) => make("th", { scope: "col" }, name))));
}

function scrolled(label, table) {
  return make("div", { className: "scrolled", tabIndex: 0, role: "region", ariaLabel: label }, table);
}
