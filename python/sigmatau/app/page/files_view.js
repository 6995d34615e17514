// The fourth step: the report, figures and tables, previews of files for filters and simulators, and the session.

import { make } from "./page.js";
import { config, exported, fileAddress } from "./api.js";
import { bdi, button, chip, choice, copy, errorBox, field, keepFocus } from "./dom.js";
import { offered, optionControls, placedChoices } from "./export_options.js";
import { allResults, allSpecifications } from "./comparison.js";
import { session, setExport } from "./session.js";
import { save } from "./saving.js";

let refresh = () => {}; // shows the controls and the previews of the step again
const DOWNLOADS = [
  ["report.html", "Report", "all figures and tables in one page that opens offline"],
  ["report.pdf", "Report, PDF", "to print and to sign"],
  ["figure.svg", "Figure, SVG", "the Allan deviation of all axes"],
  ["figure.png", "Figure, PNG", "the same as a bitmap"],
  ["curve.csv", "Curves, CSV", "averaging times, deviations and intervals in SI units"],
  ["coefficients.csv", "Coefficients, CSV", "all terms of all axes in SI units"],
  ["result.json", "Result, JSON", "for sigmatau export, compare, plan and predict"],
];

/** Show the step. */
export function showFiles(view) {
  const preview = make("div", { className: "preview" }), options = make("aside", { ariaLabel: "Options of the file" }), saved = make("div");
  refresh = () => {
    keepFocus(options, () => showOptions(options));
    showSession(saved);
    return showFile(preview);
  };
  view.replaceChildren(
    make("div", { className: "head" }, make("div", {}, make("h1", {}, "Export"), make("p", { className: "about" }, bdi(session.result.summary.title)))),
    make("section", { ariaLabel: "Report, figures and tables" }, make("h2", {}, "Report, figures, tables"), downloads()),
    make("section", { ariaLabel: "Files of other programs" }, make("h2", {}, "Values for a filter or a simulator"), make("div", { className: "exports" }, targetList(), preview, options)),
    make("section", { ariaLabel: "Session" }, make("h2", {}, "This session"), saved));
  return refresh();
}

/** Show the file again after another target or option was chosen. */
export function fileChanged() {
  if (session.step === "files") refresh();
}

/** The chosen target; undefined if none is chosen. */
const chosenTarget = () => session.about.targets.find(({ name }) => name === session.exportState.target);

/** Target and options of the export, for the command line and the session; empty if no target is chosen. */
export function fileOptions() {
  const target = chosenTarget();
  if (!target) return {};
  return { target: target.name, choices: placedChoices(target, session.exportState.choices) };
}

function downloads() {
  return make("ul", { className: "downloads" }, ...DOWNLOADS.map(([name, title, what]) => {
    const obstacle = name === "report.pdf" ? session.about.no_pdf : "";
    return make("li", {}, obstacle ? make("b", {}, title) : make("a", { href: fileAddress(session.id, name), download: "" }, title), make("small", {}, obstacle ? `not available: ${obstacle}` : what));
  }));
}

function targetList() {
  return make("div", { className: "targets", role: "radiogroup", ariaLabel: "Target" }, ...session.about.targets.map((target) => {
    const radio = make("input", { type: "radio", name: "target", value: target.name, checked: target === chosenTarget(), onchange: () => setExport({ target: target.name }) });
    return make("label", { title: target.summary ?? "" }, radio, make("span", {}, make("b", {}, target.name), make("small", {}, target.summary ?? "")));
  }));
}

function setChoice(name, value) {
  const choices = { ...session.exportState.choices };
  if (value === undefined) delete choices[name];
  else choices[name] = value;
  setExport({ target: chosenTarget().name, choices });
}

function showOptions(place) {
  const target = chosenTarget(), sensors = session.result.charts.sensors.map((sensor) => sensor.name);
  for (const radio of document.querySelectorAll(".targets input")) radio.checked = radio.value === target?.name; // also after undo
  place.hidden = !target;
  if (target) place.replaceChildren(make("h3", {}, "Options of the file"), ...optionControls(target, sensors, session.exportState.choices, setChoice), ...restControl(), ...turnOnControl());
}

/** Results of the comparison, except the one on screen. */
const restResults = () => allResults().filter(({ key }) => key !== session.id);

/** Control for the result of the same sensor at rest; none if the page has only one result. */
function restControl() {
  const rest = restResults().map(({ key, number, name }) => [key, `${number}: ${name}`]);
  if (!rest.length) return [];
  const select = choice("Inflate", [["", "not compared"], ...rest], session.exportState.inflate ?? "", (id) => setExport({ inflate: id || undefined }));
  select.dataset.focus = "export-inflate";
  return [make("div", { className: "option" }, field("Inflate", select), make("small", {}, "For a record with motors running: the result of the same sensor at rest. The file states the ratios to it in comments."))];
}

/** Models that were opened as files. A model that `sigmatau compare --model` wrote has the turn-on biases of a unit. */
const modelFiles = () => allSpecifications().filter(({ from }) => !from.named.name);

/** Control for the model file with the turn-on biases. */
function turnOnControl() {
  const models = modelFiles().map(({ key, name }) => [key, name]);
  const select = choice("Turn-on biases", [["", models.length ? "not added" : "no model file is open"], ...models], session.exportState.turnOn ?? "", (key) => setExport({ turnOn: key || undefined }));
  select.dataset.focus = "export-turn-on";
  select.disabled = !models.length;
  return [make("div", { className: "option" }, field("Turn-on biases", select), make("small", {}, "Spread of the offset between power-ups: the model file that sigmatau compare --model writes. Open it in step 1."))];
}

async function showFile(preview) {
  const { exportState, id } = session, target = chosenTarget();
  if (!target) return preview.replaceChildren(make("p", { className: "none" }, "Choose a program from the list: the file that it reads is shown here, with its warnings."));
  preview.setAttribute("aria-busy", "true");
  let file;
  try {
    file = await exported(id, target.name, placedChoices(target, exportState.choices), { inflate: restResults().find(({ key }) => key === exportState.inflate)?.key, turnOn: modelFiles().find(({ key }) => key === exportState.turnOn)?.from.named });
  } catch (error) {
    if (exportState === session.exportState) preview.replaceChildren(errorBox(error), ...offers(error.hints, target));
    return undefined;
  } finally {
    if (exportState === session.exportState) preview.removeAttribute("aria-busy");
  }
  if (exportState !== session.exportState) return undefined;
  preview.replaceChildren(
    ...(file.warnings.length ? [make("ul", { className: "findings" }, ...file.warnings.map((note) => noteRow(note, target)))] : []),
    ...file.files.map(filePreview),
    make("p", { className: "about" }, "The same from the saved JSON: ", make("code", {}, file.command)));
  return undefined;
}

const SEVERITIES = { error: "Error", warning: "Warning", info: "Note" };

function noteRow({ severity, text, action, hint }, target) {
  return make("li", {}, chip(SEVERITIES[severity] ?? "Note", severity ?? "info"),
    make("span", {}, `${text}.`, ...(action ? [" ", make("em", {}, `${action}.`)] : []), ...offers(hint, target)));
}

function offers(hints, target) {
  const buttons = offered(hints, target, session.exportState.choices, setChoice);
  return buttons.length ? [make("span", { className: "row" }, ...buttons)] : [];
}

function filePreview({ name, text }) {
  return make("div", { className: "file-preview" },
    make("div", { className: "row" }, make("b", {}, bdi(name)), button("Copy", (event) => copy(text, event.currentTarget), { ariaLabel: `Copy ${name}` }), button("Save", () => save(new Blob([text], { type: "text/plain" }), name), { ariaLabel: `Save ${name}` })),
    make("pre", { tabIndex: 0, role: "region", ariaLabel: name }, text));
}

async function showSession(place) {
  if (!session.source) {
    place.replaceChildren(make("p", { className: "none" }, "This is a stored result: it has no options to repeat."));
    return;
  }
  const { exportState, options } = session;
  try {
    const { toml } = await config({ options, log: session.source.path ?? session.name, ...fileOptions() });
    if (exportState === session.exportState && options === session.options) place.replaceChildren(filePreview({ name: "session.toml", text: toml }), make("p", { className: "about" }, "sigmatau analyze --config session.toml repeats the analysis and writes the file."));
  } catch (error) {
    place.replaceChildren(errorBox(error));
  }
}
