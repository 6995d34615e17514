// The fourth step: files for filters and simulators as they would be written, the report, tables and the session.

import { make } from "./page.js";
import { config, exported, fileAddress } from "./api.js";
import { bdi, button, chip, choice, copy, errorBox, field, keepFocus } from "./dom.js";
import { offered, optionControls, placedChoices } from "./export_options.js";
import { allResults, allSpecifications } from "./comparison.js";
import { session, setTaken } from "./session.js";
import { save } from "./saving.js";

let again = () => {}; // shows the controls and the file of the step on screen
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
  again = () => {
    keepFocus(options, () => showOptions(options));
    showSession(saved);
    return showFile(preview);
  };
  view.replaceChildren(
    make("div", { className: "head" }, make("div", {}, make("h1", {}, "Take away"), make("p", { className: "about" }, bdi(session.result.summary.title)))),
    make("section", { ariaLabel: "Report, figures and tables" }, make("h2", {}, "Report, figures, tables"), downloads()),
    make("section", { ariaLabel: "Files of other programs" }, make("h2", {}, "Values for a filter or a simulator"), make("div", { className: "exports" }, targetList(), preview, options)),
    make("section", { ariaLabel: "Session" }, make("h2", {}, "This session"), saved));
  return again();
}

/** The file was chosen or changed. */
export function fileChanged() {
  if (session.step === "files") again();
}

/** The chosen target; undefined before one is chosen. */
const targetNow = () => session.about.targets.find(({ name }) => name === session.taken.target);

/** The file as the command line and the session state it, once a target was chosen. */
export function fileOptions() {
  const target = targetNow();
  if (!target) return {};
  return { target: target.name, choices: placedChoices(target, session.taken.choices) };
}

function downloads() {
  return make("ul", { className: "downloads" }, ...DOWNLOADS.map(([name, title, what]) => {
    const obstacle = name === "report.pdf" ? session.about.no_pdf : "";
    return make("li", {}, obstacle ? make("b", {}, title) : make("a", { href: fileAddress(session.id, name), download: "" }, title), make("small", {}, obstacle ? `not here: ${obstacle}` : what));
  }));
}

function targetList() {
  return make("div", { className: "targets", role: "radiogroup", ariaLabel: "Target" }, ...session.about.targets.map((target) => {
    const radio = make("input", { type: "radio", name: "target", value: target.name, checked: target === targetNow(), onchange: () => setTaken({ target: target.name }) });
    return make("label", { title: target.summary ?? "" }, radio, make("span", {}, make("b", {}, target.name), make("small", {}, target.summary ?? "")));
  }));
}

function setChoice(name, value) {
  const choices = { ...session.taken.choices };
  if (value === undefined) delete choices[name];
  else choices[name] = value;
  setTaken({ target: targetNow().name, choices });
}

function showOptions(place) {
  const target = targetNow(), sensors = session.result.charts.sensors.map((sensor) => sensor.name);
  for (const radio of document.querySelectorAll(".targets input")) radio.checked = radio.value === target?.name; // also after undo
  place.hidden = !target;
  if (target) place.replaceChildren(make("h3", {}, "Options of the file"), ...optionControls(target, sensors, session.taken.choices, setChoice), ...restControl(), ...turnOnControl());
}

/** The results that are compared, without the one on screen. */
const restResults = () => allResults().filter(({ key }) => key !== session.id);

/** The result of the same sensor at rest, where the page has several results. */
function restControl() {
  const rest = restResults().map(({ key, number, name }) => [key, `${number}: ${name}`]);
  if (!rest.length) return [];
  const select = choice("Inflate", [["", "not compared"], ...rest], session.taken.inflate ?? "", (id) => setTaken({ inflate: id || undefined }));
  select.dataset.focus = "export-inflate";
  return [make("div", { className: "option" }, field("Inflate", select), make("small", {}, "For a record with motors running: the result of the same sensor at rest. The file states the ratios to it in comments."))];
}

/** Models that were opened as files: those of `sigmatau compare --model` have the turn-on biases of a unit. */
const modelFiles = () => allSpecifications().filter(({ from }) => !from.named.name);

/** The model file with the turn-on biases. */
function turnOnControl() {
  const models = modelFiles().map(({ key, name }) => [key, name]);
  const select = choice("Turn-on biases", [["", models.length ? "not added" : "no model file is open"], ...models], session.taken.turnOn ?? "", (key) => setTaken({ turnOn: key || undefined }));
  select.dataset.focus = "export-turn-on";
  select.disabled = !models.length;
  return [make("div", { className: "option" }, field("Turn-on biases", select), make("small", {}, "Spread of the offset between power-ups: the model file that sigmatau compare --model writes. Open it in step 1."))];
}

async function showFile(preview) {
  const { taken, id } = session, target = targetNow();
  if (!target) return preview.replaceChildren(make("p", { className: "none" }, "Choose a program from the list: the file that it reads is shown here, with its warnings."));
  preview.setAttribute("aria-busy", "true");
  let file;
  try {
    file = await exported(id, target.name, placedChoices(target, taken.choices), { inflate: restResults().find(({ key }) => key === taken.inflate)?.key, turnOn: modelFiles().find(({ key }) => key === taken.turnOn)?.from.named });
  } catch (error) {
    if (taken === session.taken) preview.replaceChildren(errorBox(error), ...offers(error.hints, target));
    return undefined;
  } finally {
    if (taken === session.taken) preview.removeAttribute("aria-busy");
  }
  if (taken !== session.taken) return undefined;
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
  const buttons = offered(hints, target, session.taken.choices, setChoice);
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
  const { taken, options } = session;
  try {
    const { toml } = await config({ options, log: session.source.path ?? session.name, ...fileOptions() });
    if (taken === session.taken && options === session.options) place.replaceChildren(filePreview({ name: "session.toml", text: toml }), make("p", { className: "about" }, "sigmatau analyze --config session.toml repeats the analysis and writes the file."));
  } catch (error) {
    place.replaceChildren(errorBox(error));
  }
}
