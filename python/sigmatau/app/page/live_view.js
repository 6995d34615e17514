// The live record: samples, curve and coefficients so far, and buttons that stop it and analyse its log.

import { content, make, setContent } from "./page.js";
import { drop, figures, fill } from "./frame.js";
import { live, changeLiveOptions, stopLive } from "./api.js";
import { announce, bdi, button, chip, errorBox, isEmpty, nameOfPath } from "./dom.js";
import { linkedKinds, liveSeries } from "./kinds.js";
import { columnChoice } from "./live_columns.js";
import { startForm } from "./live_start.js";
import { questionBox } from "./question.js";
import { findingsList, overviewTable } from "./summary.js";

const INTERVAL = 1000; // time between two requests for the state [ms]
const STATES = { recording: ["Recording", "good"], stopped: ["Stopped", "partial"], ended: ["The input has ended", "partial"], failed: ["Failed", "poor"] };

/** Show the live record until another step is shown, or the form that starts one.
 *
 * Records are saved in `folder`; `opened` is called with a saved log, and `command` with the equivalent command.
 */
export async function showLive(view, { folder, opened, command }) {
  const place = make("div", { className: "head" }, make("div", {}, make("h1", {}, "Live"), make("p", { className: "none" }, "Looking for a live record…")));
  view.replaceChildren(place); // the controls of the last step do nothing here
  let state;
  try {
    state = await live();
  } catch (error) {
    return place.isConnected ? view.replaceChildren(errorBox(error)) : undefined;
  }
  if (!place.isConnected) return undefined; // another step was chosen meanwhile
  if (state.state !== "none") return showRecord(view, state, { folder, opened, command });
  command("sigmatau app");
  return view.replaceChildren(
    make("div", { className: "head" }, make("div", {}, make("h1", {}, "Live"), make("p", { className: "about" }, "Watch a sensor at rest while it is recorded, and see when the record is long enough."))),
    startForm(folder, (begun) => showRecord(view, begun, { folder, opened, command })));
}

function showRecord(view, first, { folder, opened, command }) {
  const parts = { title: make("h1", {}, "Live"), headline: make("p", { className: "headline" }), actions: make("div", { className: "row" }), notes: make("div"), outlooks: make("ul", { className: "outlooks" }), table: make("div"), findings: make("div") };
  const charts = { deviation: make("div", { className: "charts" }), series: make("div", { className: "charts" }) };
  const shown = { state: "", drawn: {} };
  let last = first;
  const columns = columnChoice(changeOptions);
  const sections = {
    summary: section("summary", "Coefficients so far", parts.outlooks, parts.table),
    deviation: section("deviation", "Allan deviation so far", charts.deviation),
    series: section("series", "Last minutes", charts.series),
    findings: section("findings", "Findings so far", parts.findings),
  };
  view.replaceChildren(make("div", { className: "head" }, make("div", {}, parts.title, parts.headline), parts.actions), parts.notes, columns.element, ...Object.values(sections));
  const refresh = async () => {
    let state;
    try {
      state = await live();
    } catch (error) {
      if (parts.headline.isConnected) { parts.actions.replaceChildren(); parts.notes.replaceChildren(errorBox(error)); }
      return;
    }
    if (parts.headline.isConnected) take(state);
  };

  function take(state) {
    last = state;
    showState(state);
    columns.update(state);
    showNumbers(state);
    if (state.state === "recording") setTimeout(refresh, INTERVAL);
  }

  function showState({ state, heading, error, path, options, command: text }) {
    const [word, mark] = STATES[state] ?? [state, ""];
    parts.headline.replaceChildren(make("span", {}, bdi(heading ?? "")), chip(word, mark));
    command(text);
    const key = `${state} ${error?.message ?? ""}`;
    if (key === shown.state) return;
    shown.state = key;
    announce(word);
    const open = button("Open the log", () => openLog(path, options), { className: "primary", id: "open-saved" });
    const again = button("Record again…", () => view.replaceChildren(parts.title, startForm(folder, (begun) => showRecord(view, begun, { folder, opened, command }))), { id: "record-again" });
    if (state === "recording") parts.actions.replaceChildren(button(path && !error ? "Stop and analyse" : "Stop", stop, { className: "primary", id: "stop-live" }));
    else parts.actions.replaceChildren(...(path ? [open] : []), again);
    parts.notes.replaceChildren(...problemParts(error, { state, path, options }), make("p", { className: "about" }, ...noteParts(state, path, error)));
  }

  /** Read the record with other options; after its end, open its log with them. */
  async function changeOptions(changes) {
    const stated = Object.fromEntries(Object.entries({ ...last.options, ...changes }).filter(([, value]) => !isEmpty(value)));
    if (last.state !== "recording") return openLog(last.path, stated);
    try {
      const { options } = await changeLiveOptions(stated);
      last = { ...last, options };
      columns.update(last);
    } catch (refusal) {
      parts.notes.prepend(errorBox(refusal));
    }
    return undefined;
  }

  /** Box of an error. A question has its choices, and an answer is used at once. */
  function problemParts(error, { state, path, options }) {
    if (!error) return [];
    if (!error.hint || (state !== "recording" && !path)) return [errorBox(error)];
    const words = (error.question ?? error.message).replace(/^(.*?: )?(?=(has|does|is|contains|states) )/, "The input ");
    return [questionBox({ ...error, question: words }, null, { all: () => options, change: changeOptions, hasTable: true })];
  }

  const openLog = (path, options) => opened({ source: { path }, name: nameOfPath(path), options, kind: "log", isAnalysed: true });

  function noteParts(state, path, error) {
    if (path) return [state !== "recording" ? "The log is " : error ? "Meanwhile all lines are saved in " : "All lines are saved in ", bdi(path), "."];
    return [state === "recording" ? "The samples are not saved. To keep them, record again with the name of a file." : "The samples were not saved. To keep them, record again with the name of a file."];
  }

  async function stop(event) {
    event.currentTarget.disabled = true;
    try {
      const { path } = await stopLive();
      const state = await live();
      if (path && !state.error) return openLog(path, state.options);
      take(state);
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
    else parts.table.replaceChildren(...(error ? [] : [make("p", { className: "box partial wait" }, reasonText(state, wait, data))]));
    sections.summary.hidden = Boolean(error) && !overview;
    parts.findings.replaceChildren(findingsList(findings));
    setContent(data);
    drawFigures("deviation", linkedKinds.deviation, (channel) => (channel.deviation ? (channel.deviation.model ? "model" : "curve") : ""));
    drawFigures("series", liveSeries, (channel) => (channel.series?.bins ? "series" : ""));
    sections.findings.hidden = !data.sensors.length;
  }

  /** Draw the figures again. They are replaced only if channels or curves are added, so that the user's settings remain. */
  function drawFigures(name, kind, stateName) {
    const place = charts[name], data = Object.entries(content.channels).map(([key, channel]) => `${key} ${stateName(channel)}`);
    const state = data.join(), isEmpty = !data.some((text) => text.split(" ")[1]);
    sections[name].hidden = isEmpty;
    if (isEmpty) return;
    if (shown.drawn[name] !== state) {
      drop(place);
      place.replaceChildren();
      fill(place, kind);
      shown.drawn[name] = state;
    } else for (const figure of figures) if (place.contains(figure.element) && !isInUse(figure)) figure.draw();
  }

  take(first);
}

/** Reason why there are no coefficients. */
function reasonText(state, wait, data) {
  if (state !== "recording") return "No coefficients: the record was too short, or the sensor moved.";
  if (wait) return `${wait[0].toUpperCase()}${wait.slice(1)}.`;
  return data.sensors.length ? "No coefficients yet." : "Waiting for the first lines.";
}

/** Whether the user points at a figure or moves in it by keys. It is not drawn again meanwhile. */
const isInUse = (figure) => Boolean(figure.element.querySelector(".plot:hover, .plot:focus-visible"));

function section(id, title, ...children) {
  return make("section", { id: `live-${id}` }, make("h2", {}, title), ...children);
}
