// The fourth step: files for filters and simulators as they would be written, the report, tables and the session.

import { make } from "./page.js";
import { addressOf, config, exported } from "./api.js";
import { bdi, button, chip, choice, copy, errorBox, field } from "./dom.js";
import { session } from "./session.js";
import { save } from "./saving.js";

const chosen = { target: "", choices: {} };
const DOWNLOADS = [
  ["report.html", "Report", "all figures and tables in one page that opens offline"],
  ["figure.svg", "Figure, SVG", "the Allan deviation of all axes"],
  ["figure.png", "Figure, PNG", "the same as pixels"],
  ["curve.csv", "Curves, CSV", "averaging times, deviations and intervals in SI units"],
  ["coefficients.csv", "Coefficients, CSV", "all terms of all axes in SI units"],
  ["result.json", "Result, JSON", "for sigmatau export, compare, plan and predict"],
];

/** Show the step. */
export function showFiles(view) {
  const targets = session.about.targets;
  if (!targets.some((one) => one.name === chosen.target)) chosen.target = targets[0].name;
  const preview = make("div", { className: "preview" });
  const again = () => showFile(preview);
  const list = make("div", { className: "targets", role: "radiogroup", ariaLabel: "Target" }, ...targets.map((target) => {
    const radio = make("input", { type: "radio", name: "target", value: target.name, checked: target.name === chosen.target, onchange: () => { chosen.target = target.name; again(); } });
    return make("label", { title: target.summary ?? "" }, radio, make("span", {}, make("b", {}, target.name), make("small", {}, target.summary ?? "")));
  }));
  view.replaceChildren(
    make("div", { className: "head" }, make("div", {}, make("h1", {}, "Take away"), make("p", { className: "about" }, bdi(session.result.summary.title)))),
    make("section", { ariaLabel: "Report, figures and tables" }, make("h2", {}, "Report, figures, tables"), downloads()),
    make("section", { ariaLabel: "Files of other programs" }, make("h2", {}, "Values for a filter or a simulator"), choicesRow(again), make("div", { className: "exports" }, list, preview)),
    make("section", { ariaLabel: "Session" }, make("h2", {}, "This session"), sessionBox()));
  return again();
}

function downloads() {
  const rows = [...DOWNLOADS, ...(session.source ? [["session.toml", "Session, TOML", "the options: sigmatau analyze --config FILE repeats the analysis"]] : [])];
  return make("ul", { className: "downloads" }, ...rows.map(([name, title, what]) => make("li", {}, make("a", { href: addressOf(session.id, name), download: "" }, title), make("small", {}, what))));
}

function choicesRow(again) {
  const set = (name, value) => { if (value) chosen.choices[name] = value; else delete chosen.choices[name]; again(); };
  const rate = make("input", { type: "text", size: 8, inputMode: "decimal", value: chosen.choices["filter-rate"] ?? "", placeholder: "record's", onchange: () => set("filter-rate", rate.value.trim()) });
  const axes = choice("Three axes", [["", "the worst"], ["mean", "root mean square"], ["each", "each, where the file has fields"]], chosen.choices.axes ?? "", (value) => set("axes", value));
  return make("div", { className: "row" }, field("Of three axes write", axes), field("Rate of the filter [Hz]", rate));
}

async function showFile(preview) {
  const { target } = chosen;
  preview.setAttribute("aria-busy", "true");
  let found;
  try {
    found = await exported(session.id, target, chosen.choices);
  } catch (error) {
    if (target === chosen.target) preview.replaceChildren(errorBox(error));
    return;
  } finally {
    preview.removeAttribute("aria-busy");
  }
  if (target !== chosen.target) return;
  const warnings = found.warnings.map((one) => make("li", {}, chip({ error: "Error", warning: "Warning", info: "Note" }[one.severity] ?? "Note", one.severity ?? "info"), make("span", {}, `${one.text}.`, ...(one.action ? [" ", make("em", {}, `${one.action}.`)] : []))));
  preview.replaceChildren(
    ...(warnings.length ? [make("ul", { className: "findings" }, ...warnings)] : []),
    ...found.files.map(filePreview),
    make("p", { className: "about" }, "The same from the saved JSON: ", make("code", {}, found.command)));
}

function filePreview({ name, text }) {
  return make("div", { className: "file-preview" },
    make("div", { className: "row" }, make("b", {}, bdi(name)), button("Copy", (event) => copy(text, event.currentTarget), { ariaLabel: `Copy ${name}` }), button("Save", () => save(new Blob([text], { type: "text/plain" }), name), { ariaLabel: `Save ${name}` })),
    make("pre", { tabIndex: 0, role: "region", ariaLabel: name }, text));
}

function sessionBox() {
  const place = make("div");
  if (!session.source) place.append(make("p", { className: "none" }, "This is a stored result: it has no options to repeat."));
  else config({ options: session.options, log: session.name }).then(({ toml }) => place.append(filePreview({ name: "session.toml", text: toml }))).catch((error) => place.append(errorBox(error)));
  return place;
}
