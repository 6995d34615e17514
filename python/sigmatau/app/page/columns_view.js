// The second step: what the file contains, column by column, each changeable; and the picture of the record.

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

let running = null; // the look at the file that is under way

/** Show the step, and look at the file with the options of now. */
export function showColumns(view, analyse) {
  const head = make("div", { className: "head" }), body = make("div", { className: "columns" }), record = make("section", { ariaLabel: "Time series" });
  view.replaceChildren(head, body, record);
  return look(head, body, record, analyse);
}

async function look(head, body, record, analyse) {
  running?.abort();
  const here = (running = new AbortController());
  body.setAttribute("aria-busy", "true");
  showHead(head, session.opened, analyse);
  if (session.opened) showBody(body, session.opened);
  else body.replaceChildren(make("p", { className: "none" }, "Reading the file…"));
  let opened;
  try {
    opened = await open(session.source, session.options, here.signal);
  } catch (error) {
    if (error.name === "AbortError") return;
    body.removeAttribute("aria-busy");
    body.replaceChildren(error.hints?.length ? questionBox(error, session.opened) : errorBox(error), button("Undo the last change", () => document.getElementById("undo").click(), { disabled: document.getElementById("undo").disabled }));
    return;
  }
  if (here.signal.aborted) return;
  body.removeAttribute("aria-busy");
  setOpened(opened);
  if (opened.kind !== "log") return;
  showHead(head, opened, analyse);
  keepFocus(body, () => showBody(body, opened));
  announce(opened.question ? `A choice is needed: ${sentence(opened.question.question ?? opened.question.message)}` : `${opened.columns.length} columns; ready to analyse`);
  if (opened.question) record.replaceChildren();
  else {
    const picture = make("div", {}, make("p", { className: "none" }, "Drawing the record…"));
    record.replaceChildren(make("h2", {}, "Time series"), make("p", { className: "about" }, "Smallest and largest sample of each interval."), picture, ownParts());
    await showRecord(picture, session.source, session.options, here.signal);
  }
}

/** Parts that were chosen before the analysis. */
function ownParts() {
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
