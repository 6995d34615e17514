// The third step: coefficients, curves and time series of a result, and the settings of the analysis.

import { make, setContent } from "./page.js";
import { drop, fill } from "./frame.js";
import { charts } from "./api.js";
import { bdi, button, chip, errorBox } from "./dom.js";
import { session } from "./session.js";
import { byHand } from "./by_hand.js";
import { linkedKinds } from "./kinds.js";
import { leftOutList } from "./parts.js";
import { hasSeries, seriesSection } from "./record_chart.js";
import { settingsPanel } from "./settings.js";
import { coefficientTables, findingsList, overviewTable, VERDICTS } from "./summary.js";

const MOST_CHARTS = 8; // results whose charts are remembered
const remembered = new Map();
const ABOUT = {
  deviation: "Measured curves with their intervals, and the fitted model, dashed where it was fitted and dotted elsewhere.",
  "by-hand": "The terms of one axis, and lines drawn by hand.",
  series: "Smallest and largest sample of each interval. Shaded: not analysed.",
  density: "Two-sided. Dashed: the fitted model. The frequency under the pointer is marked in the Allan deviation.",
  residuals: "Measured Allan deviation divided by that of the model: near 1 if the model fits.",
  map: "Dynamic Allan deviation divided by its median. Colour marks differences larger than chance explains; a stable record has no colour.",
};
const TITLES = { deviation: "Allan deviation", "by-hand": "By hand", series: "Time series", density: "Density", residuals: "Residuals", map: "Stability" };
let clearHand = () => {};

/** Show the result of the session. */
export async function showResult(view, openExport) {
  const { id, result } = session, { summary } = result;
  const focus = document.activeElement?.dataset?.focus, scrolled = view.dataset.result ? scrollY : 0;
  drop(view);
  clearHand();
  setContent(result.charts);
  const hand = byHand();
  clearHand = hand.clear;
  const places = Object.fromEntries(Object.keys(TITLES).map((name) => [name, make("div", { className: name === "by-hand" ? "" : "charts" })]));
  for (const name of ["deviation", "density"]) places[name].dataset.chart = name; // as wide as the diagram that is drawn by hand
  places["by-hand"].append(hand.element);
  const sections = [
    section("summary", "Summary", "", overviewTable(summary)),
    section("deviation", TITLES.deviation, ABOUT.deviation, places.deviation),
    section("findings", "Findings", "", findingsList(summary.findings)),
    section("by-hand", TITLES["by-hand"], ABOUT["by-hand"], places["by-hand"]),
    ...(result.has_samples ? ["series", "density", "residuals", "map"] : ["residuals"]).map((name) => section(name, TITLES[name], ABOUT[name], places[name])),
    section("coefficients", "Coefficients", "", coefficientTables(summary.coefficients, summary.legend)),
  ];
  const leftOut = section("left-out", "Not analysed", "", leftOutList(result));
  view.replaceChildren(heading(summary, openExport), sectionButtons(sections), make("div", { className: session.source ? "result" : "result stored" }, make("div", { className: "wide" }, ...sections), make("aside", { ariaLabel: "Left-out stretches and settings" }, ...(session.source ? [leftOut, settingsPanel()] : []))));
  view.dataset.result = id;
  fill(places.deviation, linkedKinds.deviation);
  if (focus) view.querySelector(`[data-focus="${CSS.escape(focus)}"]`)?.focus({ preventScroll: true });
  scrollTo(0, scrolled);
  if (result.has_samples) await fillFromSamples(id, places);
  else fillOrExplain(places.residuals, "residuals");
}

function heading(summary, openExport) {
  const [word, mark] = VERDICTS[summary.verdict] ?? ["", ""];
  return make("div", { className: "head" }, make("div", {}, make("h1", {}, bdi(summary.title)),
    make("p", { className: "headline" }, make("span", {}, summary.headline), ...(word ? [chip(word, mark)] : []))), button("Export", openExport, { className: "primary" }));
}

function section(id, title, about, ...children) {
  const heading2 = make("h2", { tabIndex: -1 }, title);
  return make("section", { id: `part-${id}` }, heading2, ...(about ? [make("p", { className: "about" }, about)] : []), ...children);
}

/** Buttons that scroll to the sections. A link would replace the fragment of the URL, which stores the state of the page. */
function sectionButtons(sections) {
  return make("nav", { className: "sections", ariaLabel: "Sections of the result" }, ...sections.map((part) => button(part.firstChild.textContent, () => { part.scrollIntoView({ block: "start" }); part.firstChild.focus({ preventScroll: true }); })));
}

/** Fill in the charts that need the samples, which are computed after the coefficients. */
async function fillFromSamples(id, places) {
  const names = ["series", "density", "residuals", "map"];
  if (!remembered.has(id)) for (const name of names) places[name].replaceChildren(make("p", { className: "none" }, "Drawing…"));
  try {
    if (!remembered.has(id)) remembered.set(id, await charts(id));
  } catch (error) {
    for (const name of names) places[name].replaceChildren(name === "series" ? errorBox(error) : make("p", { className: "none" }, "Not drawn."));
    return;
  }
  if (remembered.size > MOST_CHARTS) remembered.delete(remembered.keys().next().value);
  if (session.id !== id || !places.series.isConnected) return;
  setContent(remembered.get(id));
  places.series.classList.remove("charts");
  places.series.replaceChildren(...(hasSeries() ? seriesSection() : [make("p", { className: "none" }, "The record has no samples to draw.")]));
  for (const name of ["density", "residuals", "map"]) fillOrExplain(places[name], name);
}

function fillOrExplain(place, name) {
  place.replaceChildren();
  fill(place, linkedKinds[name]);
  if (!place.firstChild) place.append(make("p", { className: "none" }, name === "residuals" ? "Not drawn: there is no fitted model." : "Not drawn: the record is too short, or too many samples are missing."));
}
