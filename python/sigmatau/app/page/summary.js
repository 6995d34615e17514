// Tables and text of a result: overview of the coefficients, findings, coefficients of each channel.

import { make } from "./page.js";
import { bdi, chip } from "./dom.js";

const SEVERITIES = { error: "Error", warning: "Warning", info: "Note" };
export const VERDICTS = {
  at_rest: ["At rest", "good"], partly_at_rest: ["At rest in part", "partial"], not_at_rest: ["Not at rest", "poor"],
  too_short_to_tell: ["Too short to tell", "poor"], assumed: ["Taken as at rest", "partial"],
};

const WITHOUT = {
  not_at_rest: "No coefficients: the sensor is not at rest. Choose a part at rest in the time series, or check “Analyse motion as noise”.",
  too_short_to_tell: "No coefficients: the record is too short to distinguish rest from motion.",
};

/** A text with superscripts: the exponents in "m/s/h^{3/2}" and "m^2" are raised. */
export function raised(text) {
  const parts = String(text).split(/\^(\{[^}]*\}|-?\d+)/);
  return parts.map((part, k) => (k % 2 ? make("sup", {}, part.replace(/[{}]/g, "")) : part)).filter((part) => part !== "");
}

/** The main coefficients, one row per axis. */
export function overviewTable({ overview, level, verdict, coefficients }) {
  if (!overview) return make("p", { className: "box partial" }, coefficients?.some((table) => table.rows.length) ? "The coefficients were not fitted but read off the curves: see Coefficients." : WITHOUT[verdict] ?? "No coefficients: nothing was fitted.");
  const heads = (texts) => texts.map((text) => make("th", { scope: "col" }, ...raised(text)));
  const body = overview.sensors.flatMap(({ length, runs, units, axes }) => [
    make("tr", { className: "units" }, ...heads([runs ? `${runs} runs` : `over ${length}`, ...units]), make("td")),
    ...axes.map(({ channel, coefficients, trust }) => make("tr", {}, make("th", { scope: "row" }, bdi(channel)), ...coefficients.map(valueCell), make("td", {}, chip(trust, trust)))),
  ]);
  return make("div", {},
    make("div", { className: "scrolled", tabIndex: 0, role: "region", ariaLabel: "Main coefficients" }, make("table", { className: "overview" }, make("thead", {}, make("tr", {}, ...heads(["Axis", ...overview.labels, "Trust"]))), make("tbody", {}, ...body))),
    ...(level ? [make("p", { className: "legend" }, `Values with their ${level} confidence intervals; below: upper limit of a term that is not observed.`)] : []));
}

/** A value with its interval below, as in the report. */
function valueCell({ value, interval }) {
  return make("td", { className: "value" }, ...raised(value), ...(interval ? [" ", make("span", { className: "interval" }, interval)] : []));
}

/** Findings in order; notes are folded if there are many. */
export function findingsList(findings, none = "No faults were found in the record.") {
  if (!findings?.length) return make("p", { className: "none" }, none);
  const grave = findings.filter((finding) => finding.severity !== "info"), notes = findings.filter((finding) => finding.severity === "info");
  const parts = [];
  parts.push(grave.length ? make("ul", { className: "findings" }, ...grave.map(findingRow)) : make("p", { className: "none" }, "No warnings."));
  if (notes.length) parts.push(make("details", { open: notes.length <= 2 }, make("summary", {}, `${notes.length} note${notes.length > 1 ? "s" : ""} on the record`), make("ul", { className: "findings" }, ...notes.map(findingRow))));
  return make("div", {}, ...parts);
}

function findingRow({ severity, axes, message, action, where }) {
  return make("li", {}, chip(SEVERITIES[severity] ?? severity, severity), make("span", {},
    ...(axes ? [make("strong", {}, bdi(axes)), " "] : []),
    ...raised(`${message}.`), ...(action ? [" ", make("em", {}, `${action}.`)] : []),
    ...(where ? [make("span", { className: "where" }, `At ${where}.`)] : [])));
}

/** All coefficients, in a table for each channel. */
export function coefficientTables(tables, legend) {
  const articles = (tables ?? []).map((table) => make("article", {},
    make("h3", {}, bdi(table.channel), " ", ...(table.trust ? [chip(table.trust, table.trust)] : [])),
    make("p", { className: "verdict" }, table.verdict),
    make("div", { className: "scrolled", tabIndex: 0, role: "region", ariaLabel: `Coefficients of ${table.channel}` }, make("table", {}, make("tbody", {}, ...table.rows.map(([term, value, interval, unit]) =>
      make("tr", {}, make("th", { scope: "row" }, term), make("td", { className: "value" }, value), make("td", { className: "value" }, ...raised(unit)), make("td", { className: "interval" }, interval)))))),
    ...(table.notes?.length ? [make("ul", { className: "notes" }, ...table.notes.map((note) => make("li", {}, ...raised(note))))] : [])));
  return make("div", {}, make("div", { className: "channels" }, ...articles), ...(legend ? [make("p", { className: "legend" }, ...raised(legend))] : []));
}
