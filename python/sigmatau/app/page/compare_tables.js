// Tables of a comparison: differences with their intervals, coefficients of all results, repeatability.

import { make } from "./page.js";
import { compare } from "./api.js";
import { bdi, button, chip, choice, errorBox, field } from "./dom.js";
import { choosePair, chosenPair, shownResults } from "./comparison.js";
import { raised } from "./summary.js";

const VERDICTS = { changed: ["changed", "partial"], differs: ["by chance?", "info"], same: ["no change seen", "good"], unknown: ["not decided", "info"] };
let lastRequest = 0; // number of the last request for a comparison

/** Show the tables of all results that are switched on; of a single result, only its coefficients. `command` shows the equivalent commands. */
export async function showNumbers(places, command) {
  const shown = shownResults(), request = (lastRequest += 1);
  for (const place of Object.values(places)) place.parentElement.hidden = shown.length < 2;
  places.coefficients.parentElement.hidden = !shown.length;
  if (shown.length) places.coefficients.replaceChildren(coefficientTable(shown));
  if (shown.length < 2) return command(null);
  const pair = chosenPair();
  for (const place of [places.difference, places.repeatability]) place.setAttribute("aria-busy", "true");
  try {
    const between = await compare(pair.map(({ key }) => key));
    const all = shown.length === 2 && pair[0] === shown[0] ? between : await compare(shown.map(({ key }) => key));
    if (request !== lastRequest) return undefined;
    places.difference.replaceChildren(...differenceParts(between, pair), pairControls(shown, pair, () => showNumbers(places, command)));
    places.repeatability.replaceChildren(...repeatability(all));
    command(all.command);
  } catch (error) {
    if (request === lastRequest) { places.difference.replaceChildren(errorBox(error)); places.repeatability.replaceChildren(); command(null); }
  } finally {
    for (const place of [places.difference, places.repeatability]) place.removeAttribute("aria-busy");
  }
  return undefined;
}

const numbered = ({ number, name }) => `${number}: ${name}`;

/** Controls that choose the new and the old result, and exchange them. */
function pairControls(shown, [first, second], change) {
  const set = (old, recent) => { choosePair(old, recent); change(); };
  const find = (key) => shown.find((each) => each.key === key);
  const select = (label, value, chosen) => field(label, choice(label, shown.map((each) => [each.key, numbered(each)]), value.key, chosen));
  return make("div", { className: "row" },
    select("New", second, (key) => set(key === first.key ? second : first, find(key))),
    select("Old", first, (key) => set(find(key), key === second.key ? first : second)),
    button("Exchange", () => set(second, first)));
}

/** A sentence whether something changed, and the difference of each coefficient with its interval. */
function differenceParts({ differences, same_log: isSameLog }, [first, second]) {
  if (!differences.length) return [make("p", { className: "none" }, "These results have no coefficient in common.")];
  const kind = (each) => (each.changed ? "changed" : each.verdict);
  const order = Object.keys(VERDICTS), sorted = [...differences].sort((a, b) => order.indexOf(kind(a)) - order.indexOf(kind(b)));
  const rows = sorted.map((each) => make("tr", {}, make("th", { scope: "row" }, bdi(each.channel), ` ${each.term.replaceAll("_", " ")}`),
    make("td", {}, ...(each.text ? raised(each.text) : ["only an upper limit in one result"])), make("td", {}, chip(...VERDICTS[kind(each)]))));
  const doubt = isSameLog ? [make("p", { className: "box partial" }, "Both results are of the same log, so their errors are not independent: these intervals do not hold.")] : [];
  return [
    ...doubt,
    answer(differences),
    make("p", { className: "about" }, `New minus old: ${numbered(second)} minus ${numbered(first)}, with 95 % intervals.`),
    scrolled("Differences", make("table", { className: "compared" }, head("Coefficient", "New minus old", "Verdict"), make("tbody", {}, ...rows)), "scrolled runs differences"),
  ];
}

/** Sentence that answers whether the coefficients changed. */
function answer(differences) {
  const changed = differences.filter((each) => each.changed), chance = differences.filter((each) => each.verdict === "differs" && !each.changed).length;
  const words = changed.length
    ? `${changed.length} of ${differences.length} coefficients changed.`
    : differences.some((each) => each.value !== null) ? "These records do not show a change. A change smaller than the intervals cannot be excluded." : "No coefficient is observed in both results.";
  const mark = changed.length ? VERDICTS.changed : differences.some((each) => each.value !== null) ? VERDICTS.same : VERDICTS.unknown;
  const more = chance ? ` ${chance} further interval${chance > 1 ? "s do" : " does"} not contain 0, which chance explains among ${differences.length} comparisons.` : "";
  return make("p", { className: "verdicts" }, chip(...mark), " ", make("strong", {}, words), more);
}

/** Table of coefficients: a row for each channel and term, a column for each result. */
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

function scrolled(label, table, className = "scrolled") {
  return make("div", { className, tabIndex: 0, role: "region", ariaLabel: label }, table);
}
