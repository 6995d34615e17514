// The second step: the columns of the file, whose use and unit can be changed, and the time series of the record.

import { make } from "./page.js";
import { bdi, button, errorBox, keepFocus, announce } from "./dom.js";
import { open } from "./api.js";
import { session, setOpened } from "./session.js";
import { ofSession } from "./channels.js";
import { columnTable, meanLine, readingControls } from "./column_table.js";
import { questionBox, sentence } from "./question.js";
import { showRecord } from "./record_chart.js";
import { leftOutList } from "./parts.js";
import { findingsList } from "./summary.js";
import { text, timeUnit } from "./numbers.js";

let running = null; // AbortController of the request that reads the file

/** Show the step, and read the file with the current options. */
export function showColumns(view, analyse) {
  const head = make("div", { className: "head" }), body = make("div", { className: "columns" }), record = make("section", { ariaLabel: "Time series" });
  view.replaceChildren(head, body, record);
  return readFile(head, body, record, analyse);
}

async function readFile(head, body, record, analyse) {
  running?.abort();
  const request = (running = new AbortController());
  body.setAttribute("aria-busy", "true");
  showHead(head, session.opened, analyse);
  if (session.opened) showBody(body, session.opened);
  else body.replaceChildren(make("p", { className: "none" }, "Reading the file…"));
  let opened;
  try {
    opened = await open(session.source, session.options, request.signal);
  } catch (error) {
    if (error.name === "AbortError") return;
    body.removeAttribute("aria-busy");
    body.replaceChildren(error.hints?.length ? questionBox(error, session.opened) : errorBox(error), button("Undo the last change", () => document.getElementById("undo").click(), { disabled: document.getElementById("undo").disabled }));
    return;
  }
  if (request.signal.aborted) return;
  body.removeAttribute("aria-busy");
  setOpened(opened);
  if (opened.kind !== "log") return;
  showHead(head, opened, analyse);
  keepFocus(body, () => showBody(body, opened));
  announce(opened.question ? `A choice is needed: ${sentence(opened.question.question ?? opened.question.message)}` : `${opened.columns.length} columns; ready to analyse`);
  if (opened.question) record.replaceChildren();
  else {
    const picture = make("div", {}, make("p", { className: "none" }, "Drawing the record…"));
    record.replaceChildren(make("h2", {}, "Time series"), make("p", { className: "about" }, "Smallest and largest sample of each interval."), picture, chosenParts());
    await showRecord(picture, session.source, session.options, request.signal);
  }
}

/** List of the parts that the user left out before the analysis. */
function chosenParts() {
  return session.options["leave-out"] || session.options.window ? leftOutList(null) : make("div");
}

function showHead(head, opened, analyse) {
  const facts = [];
  if (opened?.rows) facts.push(`${opened.rows.toLocaleString("en")} rows`);
  if (opened?.duration_s) { const unit = timeUnit(opened.duration_s); facts.push(`${text(opened.duration_s / unit.size)} ${unit.text}`); }
  if (opened?.rate_hz) facts.push(`${text(opened.rate_hz, 4)} Hz${opened.rate_how ? ` (${opened.rate_how})` : ""}`);
  const start = make("button", { type: "button", className: "primary", id: "analyse", disabled: !opened || Boolean(opened.question), onclick: analyse, title: "Ctrl+Enter" }, "Analyse");
  head.replaceChildren(make("div", {}, make("h1", {}, bdi(session.name)), make("p", { className: "about" }, [opened?.format, ...facts].filter(Boolean).join(" · ") || " ")), start);
}

function showBody(body, opened) {
  body.replaceChildren(
    ...(opened.question ? [questionBox(opened.question, opened)] : []),
    readingControls(opened, ofSession),
    columnTable(opened, ofSession),
    ...opened.means.map(meanLine),
    ...(opened.question && !opened.findings.length ? [] : [make("h2", {}, "Findings"), findingsList(opened.findings.map((finding) => ({ ...finding, message: finding.text, axes: (finding.channels ?? [finding.channel]).filter(Boolean).join(", ") })), "No faults were found in the file. The analysis will check motion, shocks and noise.")]));
}
