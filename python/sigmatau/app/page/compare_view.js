// Results of this session, runs of a store and datasheets beside each other: one figure a sensor, and their numbers.

import { make } from "./page.js";
import { bdi, button, checkbox } from "./dom.js";
import { drop } from "./frame.js";
import { allResults, allSpecifications, isShown, remove, show } from "./comparison.js";
import { drawComparison, swatch } from "./compare_figure.js";
import { showNumbers } from "./compare_tables.js";
import { datasheetPicker, storePicker } from "./compare_sources.js";

/** Show the step; `openFile` shows the files that can be opened. */
export function showCompare(view, openFile) {
  drop(view);
  const legend = make("fieldset", { className: "legend" }), charts = make("div", { className: "charts" });
  const places = { difference: make("div"), coefficients: make("div"), repeatability: make("div") };
  const drawing = section("Allan deviation", charts);
  const draw = () => {
    drawing.hidden = !(allResults().length + allSpecifications().length);
    if (drawing.hidden) drop(charts);
    else drawComparison(charts);
    return showNumbers(places);
  };
  const removed = (each) => { remove(each); showCompare(view, openFile); view.querySelector(".legend input")?.focus(); };
  const changed = () => { fillLegend(legend, draw, removed); return draw(); };
  view.replaceChildren(
    make("div", { className: "head" }, make("div", {}, make("h1", {}, "Compare"), make("p", { className: "about" }, "Results of this session, runs of a store, datasheets and noise models.")),
      button("Open a file…", openFile, { title: "A log, a result, a store, a noise model or a datasheet" })),
    legend,
    make("div", { className: "sources" }, ...storePicker(changed), section("Add a datasheet", datasheetPicker(changed))),
    drawing,
    section("Is it the same?", places.difference),
    section("Coefficients", places.coefficients),
    section("Repeatability of the runs", places.repeatability));
  return changed();
}

/** What is compared, each with its line and a box that switches it on and off. */
function fillLegend(legend, draw, removed) {
  const item = (each) => {
    const box = checkbox(each.number ? `${each.number}: ${each.name}` : each.title, isShown(each), (on) => { show(each, on); draw(); });
    box.append(swatch(each));
    const facts = each.origins?.length ? [make("small", {}, bdi([...each.origins, each.source].filter(Boolean).join(" · ")))] : [];
    return make("li", {}, box, button("Remove", () => removed(each), { ariaLabel: `Remove ${each.name}`, className: "small" }), ...facts);
  };
  const items = [...allResults().map(item), ...allSpecifications().map(item)];
  legend.replaceChildren(make("legend", {}, "In the figure"), ...(items.length ? [make("ul", { className: "compared-list" }, ...items)] : [make("p", { className: "none" }, "Nothing yet. Analyse a log, open results or a store, or add a datasheet.")]));
}

function section(title, ...children) {
  return make("section", {}, make("h2", {}, title), ...children);
}
