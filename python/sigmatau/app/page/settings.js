// Options of the analysis, next to the result; a change starts the analysis again.

import { make } from "./page.js";
import { button, checkbox, choice, field } from "./dom.js";
import { session, setOptions } from "./session.js";
import { asPairs, ofSession, setPair } from "./channels.js";

const METHODS = [["likelihood", "likelihood of the spectrum"], ["gls", "least squares on the curve"], ["read-off", "read-off of the paper"]];
const GRIDS = [["octave", "octaves"], ["half", "half octaves"], ["quarter", "quarter octaves"], ["eighth", "eighth octaves"], ["all", "all"]];

/** The panel of settings. */
export function settingsPanel() {
  const { options, about: { labels } } = session;
  const method = choice(labels.method, METHODS, options.method ?? "likelihood", (value) => setOptions({ method: value === "likelihood" ? undefined : value }));
  const taus = choice(labels.taus, withValue(GRIDS, options.taus ?? "half"), String(options.taus ?? "half"), (value) => setOptions({ taus: value === "half" ? undefined : value }));
  const window = make("input", { type: "text", size: 16, value: options.window ?? "", placeholder: "600s:7800s", onchange: () => setOptions({ window: window.value.trim() }) });
  for (const [name, control] of Object.entries({ method, taus, window })) control.dataset.focus = name;
  return make("section", { className: "settings", ariaLabel: "Settings" },
    make("h2", {}, "Settings"),
    termBoxes(), field(labels.method, method), field(labels.taus, taus), field(labels.window, window, "from:to with units, or most-stable=2h"),
    ...bandwidths(),
    checkbox(labels["at-rest"], Boolean(options["at-rest"]), (on) => setOptions({ "at-rest": on || undefined }), { title: "--at-rest" }),
    readOffRanges());
}

const withValue = (entries, value) => (entries.some(([key]) => key === String(value)) ? entries : [...entries, [String(value), String(value)]]);

/** Terms that the model may have. */
function termBoxes() {
  const all = session.about.terms.map((term) => term.name);
  const stated = session.options.terms;
  const on = new Set(stated ? (Array.isArray(stated) ? stated : String(stated).split(",").map((name) => name.trim())) : all);
  const boxes = session.about.terms.map((term) => {
    const box = checkbox(term.label, on.has(term.name), (is) => {
      is ? on.add(term.name) : on.delete(term.name);
      const names = all.filter((name) => on.has(name));
      if (names.length) setOptions({ terms: names.length === all.length ? undefined : names.join(",") });
      else { on.add(term.name); box.firstChild.checked = true; } // a model needs a term
    });
    box.firstChild.dataset.focus = `term-${term.name}`;
    return box;
  });
  return make("fieldset", {}, make("legend", {}, session.about.labels.terms), ...boxes);
}

/** The filter of each sensor, as its datasheet states it. */
function bandwidths() {
  const sensors = [...new Set(Object.keys(session.result?.charts.channels ?? {}).map((name) => name.split("_")[0]))].filter((name) => ["gyro", "accel"].includes(name));
  const stated = asPairs(session.options.bandwidth);
  return sensors.map((sensor) => {
    const input = make("input", { type: "text", size: 10, value: stated[sensor] ?? "", placeholder: "unknown", onchange: () => setPair(ofSession, "bandwidth", sensor, input.value.trim()) });
    input.dataset.focus = `bandwidth-${sensor}`;
    return field(session.about.labels.bandwidth.replace("sensor", sensor), input, "bandwidth of the datasheet: 30Hz, 30Hz/2");
  });
}

function readOffRanges() {
  const ranges = [session.options["read-off-at"] ?? []].flat();
  if (!ranges.length) return make("div", { hidden: true });
  return make("fieldset", {}, make("legend", {}, "Lines by hand"), ...ranges.map((range) => make("p", { className: "row" }, make("code", {}, range),
    button("Remove", () => setOptions({ "read-off-at": ranges.filter((line) => line !== range) }), { ariaLabel: `Remove the line ${range}` }))));
}
