// The step that compares results of this session, files, runs of stores and datasheets: changes, figures and tables.

import { make } from "./page.js";
import { bdi, button, checkbox } from "./dom.js";
import { drop } from "./frame.js";
import { allResults, allSpecifications, isShown, remove, show } from "./comparison.js";
import { drawComparison, swatch } from "./compare_figure.js";
import { fileAdder } from "./compare_open.js";
import { showNumbers } from "./compare_tables.js";
import { datasheetPicker, storePicker } from "./compare_sources.js";

/** Show the step; `command` shows the equivalent commands, `inColumns` opens a log in step 2, `inFigure` a figure. */
export function showCompare(view, { command, inColumns, inFigure }) {
  drop(view);
  const legend = make("fieldset", { className: "legend" }), charts = make("div", { className: "charts" });
  const places = { difference: make("div"), coefficients: make("div"), repeatability: make("div") };
  const drawing = section("Allan deviation", charts), stores = make("div", { className: "sources" });
  const draw = () => {
    drawing.hidden = !(allResults().length + allSpecifications().length);
    if (drawing.hidden) drop(charts);
    else drawComparison(charts);
    return showNumbers(places, command);
  };
  const removed = (each) => { remove(each); showCompare(view, { command, inColumns, inFigure }); view.querySelector(".legend input, #add-file")?.focus(); };
  const changed = () => { fillLegend(legend, draw, removed); return draw(); };
  const adder = make("section", { className: "adder" });
  const opened = () => {
    stores.replaceChildren(...storePicker(changed));
    adder.replaceChildren(...fileAdder(opened, inColumns, inFigure), datasheetPicker(changed));
    return changed();
  };
  view.replaceChildren(
    make("div", { className: "head" }, make("div", {}, make("h1", {}, "Compare"), make("p", { className: "about" }, "Results of this session, files, runs of a store, datasheets and noise models."))),
    make("div", { className: "sources" }, legend, adder), stores,
    section("Has it changed?", places.difference),
    drawing,
    section("Coefficients", places.coefficients),
    section("Repeatability of the runs", places.repeatability));
  return opened();
}

/** List everything that is compared, each with its line and a box that switches it on and off. */
function fillLegend(legend, draw, removed) {
  const item = (each) => {
    const box = checkbox(each.number ? `${each.number}: ${each.name}` : each.title, isShown(each), (on) => { show(each, on); draw(); });
    box.append(swatch(each));
    const facts = each.origins?.length ? [make("small", {}, bdi([...each.origins, each.source].filter(Boolean).join(" · ")))] : [];
    return make("li", {}, box, button("Remove", () => removed(each), { ariaLabel: `Remove ${each.name}`, className: "small" }), ...facts);
  };
  const items = [...allResults().map(item), ...allSpecifications().map(item)];
  legend.replaceChildren(make("legend", {}, "In the figure"), ...(items.length ? [make("ul", { className: "compared-list" }, ...items)] : [make("p", { className: "none" }, "Nothing yet. Add a file, or analyse a log first.")]));
}

function section(title, ...children) {
  return make("section", {}, make("h2", {}, title), ...children);
}
