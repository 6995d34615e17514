// The live record: samples, curve and coefficients while they arrive, and its end.

import { content, make, setContent } from "./page.js";
import { drop, figures, fill } from "./frame.js";
import { live, stopLive } from "./api.js";
import { announce, bdi, button, chip, errorBox } from "./dom.js";
import { linkedKinds, liveSeries } from "./kinds.js";
import { findingsList, overviewTable } from "./summary.js";

const EVERY = 1000; // between two looks [ms]
const STATES = { recording: ["Recording", "good"], stopped: ["Stopped", "partial"], ended: ["The input has ended", "partial"], failed: ["Failed", "poor"] };

/** Show the live record until another step is shown; `opened` begins with the saved log, `command` shows what does the same. */
export function showLive(view, opened, command) {
  const parts = { title: make("h1", {}, "Live"), headline: make("p", { className: "headline" }), actions: make("div", { className: "row" }), notes: make("div"), outlooks: make("ul", { className: "outlooks" }), table: make("div"), findings: make("div") };
  const charts = { deviation: make("div", { className: "charts" }), series: make("div", { className: "charts" }) };
  const sections = {
    summary: section("summary", "Coefficients so far", parts.outlooks, parts.table),
    deviation: section("deviation", "Allan deviation so far", charts.deviation),
    series: section("series", "Last minutes", charts.series),
    findings: section("findings", "Findings so far", parts.findings),
  };
  view.replaceChildren(make("div", { className: "head" }, make("div", {}, parts.title, parts.headline), parts.actions), parts.notes, ...Object.values(sections));
  const shown = { state: "", drawn: {} };
  const look = async () => {
    let found;
    try {
      found = await live();
    } catch (error) {
      if (parts.title.isConnected) { parts.actions.replaceChildren(); parts.notes.replaceChildren(errorBox(error)); }
      return;
    }
    if (!parts.title.isConnected) return;
    showState(found);
    showNumbers(found);
    if (found.state === "recording") setTimeout(look, EVERY);
  };

  function showState({ state, heading, error, path, options, command: text }) {
    const [word, mark] = STATES[state] ?? [state, ""];
    parts.headline.replaceChildren(make("span", {}, bdi(heading ?? "")), chip(word, mark));
    command(text);
    const key = `${state} ${error?.message ?? ""}`;
    if (key === shown.state) return;
    shown.state = key;
    announce(word);
    const open = button("Open the saved log", () => opened({ source: { path }, name: path.split(/[\\/]/).pop(), options }), { className: "primary", id: "open-saved" });
    if (state === "recording") parts.actions.replaceChildren(button(path ? "Stop and open the log" : "Stop", stop, { className: "primary", id: "stop-live" }));
    else parts.actions.replaceChildren(...(path ? [open] : []));
    parts.notes.replaceChildren(...(error ? [errorBox(error)] : []), make("p", { className: "about" }, ...noteOf(state, path, error)));
  }

  function noteOf(state, path, error) {
    if (path) return [state !== "recording" ? "Saved in " : error ? "What arrives is saved all the same, in " : "Every line is saved in ", bdi(path), "."];
    return [state === "recording" ? "The samples are not saved. Start with --save LOG to keep them for the whole analysis." : "The samples were not saved. Start again with --save LOG to keep them."];
  }

  async function stop(event) {
    event.currentTarget.disabled = true;
    try {
      const { path } = await stopLive();
      const found = await live();
      if (path && !found.error) return opened({ source: { path }, name: path.split(/[\\/]/).pop(), options: found.options });
      showState(found);
      showNumbers(found);
    } catch (error) {
      parts.notes.replaceChildren(errorBox(error));
    }
    return undefined;
  }

  function showNumbers({ state, overview, level, wait, outlooks = [], findings, charts: data, error }) {
    if (!data) return;
    parts.outlooks.replaceChildren(...outlooks.map(({ sensor, text }) => make("li", {}, make("strong", {}, bdi(sensor)), `: ${text}`)));
    parts.outlooks.hidden = !outlooks.length;
    if (overview) parts.table.replaceChildren(overviewTable({ overview, level }));
    else parts.table.replaceChildren(...(error ? [] : [make("p", { className: "box partial wait" }, whyNone(state, wait, data))]));
    parts.findings.replaceChildren(findingsList(findings));
    setContent(data);
    drawn("deviation", linkedKinds.deviation, (channel) => (channel.deviation ? (channel.deviation.model ? "model" : "curve") : ""));
    drawn("series", liveSeries, (channel) => (channel.series?.bins ? "series" : ""));
    sections.findings.hidden = !data.sensors.length;
  }

  /** Draw the figures again; they are made again only when there are others: what was chosen in them stays. */
  function drawn(name, kind, kindOf) {
    const place = charts[name], data = Object.entries(content.channels).map(([channel, one]) => `${channel} ${kindOf(one)}`);
    const key = data.join(), isEmpty = !data.some((text) => text.split(" ")[1]);
    sections[name].hidden = isEmpty;
    if (isEmpty) return;
    if (shown.drawn[name] !== key) {
      drop(place);
      place.replaceChildren();
      fill(place, kind);
      shown.drawn[name] = key;
    } else for (const one of figures) if (place.contains(one.element) && !isRead(one)) one.draw();
  }
  look();
}

/** Why there are no coefficients. */
function whyNone(state, wait, data) {
  if (state !== "recording") return "No coefficients: the record was too short, or the sensor moved.";
  if (wait) return `${wait[0].toUpperCase()}${wait.slice(1)}.`;
  return data.sensors.length ? "No coefficients yet." : "Waiting for the first lines.";
}

/** Whether a figure is being read by the pointer or by keys: it is drawn again afterwards. */
const isRead = (figure) => Boolean(figure.element.querySelector(".plot:hover, .plot:focus-visible"));

function section(id, title, ...children) {
  return make("section", { id: `live-${id}` }, make("h2", {}, title), ...children);
}
