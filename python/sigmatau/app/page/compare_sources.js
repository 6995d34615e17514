// Controls that add runs of stores and datasheets to a comparison.

import { make } from "./page.js";
import { datasheets } from "./api.js";
import { announce, bdi, button, choice, errorBox, field } from "./dom.js";
import { addRun, addSpecification, allStores, chooseUnits, isAdded } from "./comparison.js";
import { text, timeUnit } from "./numbers.js";

const WITHOUT_CURVES = { failed: "failed", not_at_rest: "not at rest", too_short_to_tell: "too short" };
const choices = { named: "", use: "typical", sided: "", bias: "" };
const files = new Map(); // datasheets that were opened as files: entry of the list → {path} or {file}

/** Choose an opened datasheet in the list, but do not add it yet: its values may need a convention. */
export function offerDatasheet(source, name) {
  choices.named = `file ${name}`;
  files.set(choices.named, source);
}

/** Lists of the runs of each store; `changed` is called after a run was added. */
export function storePicker(changed) {
  return allStores().map((store) => {
    const place = make("section", { className: "store" });
    fillStore(place, store, changed);
    return place;
  });
}

function fillStore(place, store, changed) {
  const problem = make("div");
  const unit = make("input", { type: "text", size: 14, value: store.unit, placeholder: "all, or A*" });
  const list = async (event) => {
    event.preventDefault();
    try {
      await chooseUnits(store, unit.value.trim());
      fillStore(place, store, changed);
      place.querySelector("input").focus();
    } catch (error) {
      problem.replaceChildren(errorBox(error));
    }
  };
  const rows = store.runs.map((run) => runRow(store, run, problem, changed));
  place.replaceChildren(
    make("h2", {}, "Runs of ", bdi(store.name)),
    make("form", { className: "row", onsubmit: list }, field("Unit", unit), make("button", { type: "submit" }, "List")),
    problem,
    rows.length ? make("div", { className: "scrolled runs", tabIndex: 0, role: "region", ariaLabel: `Runs of ${store.name}` },
      make("table", { className: "compared" }, make("thead", {}, make("tr", {}, ...["", "Unit", "Run", "Recorded", "Length", "Temperature"].map((name) => make("th", { scope: "col" }, name)))), make("tbody", {}, ...rows)))
      : make("p", { className: "none" }, "No run of such a unit. A* stands for all names that begin with A."),
    ...(store.further ? [make("p", { className: "none" }, `${store.further} more runs are not listed: choose a unit.`)] : []));
}

function runRow(store, run, problem, changed) {
  const obstacle = WITHOUT_CURVES[run.state], added = isAdded(store, run);
  const label = `Add ${run.unit} ${run.name}`;
  const add = button(obstacle ?? (added ? "Added" : "Add"), async () => {
    add.disabled = true;
    try {
      await addRun(store.source, run.run);
      add.textContent = "Added";
      announce(`${run.unit} ${run.name} was added`);
      changed();
    } catch (error) {
      add.disabled = false;
      problem.replaceChildren(errorBox(error));
    }
  }, { disabled: Boolean(obstacle) || added, ariaLabel: label });
  const length = run.duration_s ? timeUnit(run.duration_s) : null;
  return make("tr", {}, make("td", {}, add), make("th", { scope: "row" }, bdi(run.unit)), make("td", {}, bdi(run.name)), make("td", {}, run.recorded ?? "–"),
    make("td", {}, length ? `${text(run.duration_s / length.size)} ${length.text}` : "–"), make("td", {}, run.temperature_degc === null ? "–" : `${text(run.temperature_degc)} °C`));
}

/** List of datasheets, of the library and of files, with controls for conventions that a datasheet may not state. */
export function datasheetPicker(changed) {
  const problem = make("div");
  const list = choice("Datasheet", [["", "choose a datasheet"], ...[...files.keys()].map((name) => [name, name])], choices.named, (value) => { choices.named = value; add.disabled = !value; });
  datasheets().then(({ datasheets: sheets }) => {
    list.append(...sheets.map(({ name, headline }) => make("option", { value: name }, headline)));
    list.value = choices.named;
  }, (error) => problem.replaceChildren(errorBox(error)));
  const select = (label, name, entries) => field(label, choice(label, entries, choices[name], (value) => { choices[name] = value; }));
  const add = button("Add", async () => {
    const { named, ...conventions } = choices;
    try {
      await addSpecification(files.get(named) ?? { name: named }, conventions);
      problem.replaceChildren();
      announce("The datasheet was added");
      changed();
    } catch (error) {
      problem.replaceChildren(errorBox(error));
    }
  }, { disabled: !choices.named, ariaLabel: "Add the datasheet" });
  return make("details", { open: Boolean(choices.named) }, make("summary", {}, "Datasheets"), make("div", { className: "row" }, field("Datasheet", list)), make("div", { className: "row" },
    select("Values", "use", [["typical", "typical"], ["maximum", "maximum"]]),
    select("Noise densities", "sided", [["", "as stated"], ["one", "one-sided"], ["two", "two-sided"]]),
    select("Bias instability", "bias", [["", "as stated"], ["minimum", "Allan minimum"], ["coefficient", "coefficient B"]]), add), problem);
}
