// The page as a whole: steps, history, keys, the command line, and the response to changed options.

import { drop, forget } from "./frame.js";
import { make } from "./page.js";
import { about, config, files, open, result as fetchResult } from "./api.js";
import { announce, button, byId, copy, errorBox, nameOfPath } from "./dom.js";
import { begin, beginFigure, canRedo, canUndo, onChange, readFragment, redo, session, setResult, setStep, undo } from "./session.js";
import { showLive } from "./live_view.js";
import { acceptDrops, openDropped, showOpen, sourceOfEntry } from "./open_view.js";
import { showColumns } from "./columns_view.js";
import { questionBox } from "./question.js";
import { analyse, cancel } from "./jobs.js";
import { showResult } from "./result_view.js";
import { fileChanged, fileOptions, showFiles } from "./files_view.js";
import { showCompare } from "./compare_view.js";
import { addAgain, dropFile } from "./compare_open.js";
import { addSpecification, addStore, allResults, rememberResult, restoreComparison } from "./comparison.js";
import { offerDatasheet } from "./compare_sources.js";
import { figureFrom, newFigure } from "./figure_state.js";
import { figureChanged, showFigure } from "./figure_view.js";

const view = byId("view");
const STEPS = ["live", "open", "columns", "result", "files", "compare", "figure"];
const NOT_LOGS = /\.(toml|db|sqlite3?|png|jpe?g|webp|gif|svg|pdf)$/i; // may not be a log; the content decides
const TITLES = { live: "Live", open: "Open", columns: "Columns", result: "Result", files: "Export", compare: "Compare", figure: "Figure" };

/** Show the step of the session. */
async function show() {
  if (session.step !== "result") { drop(view); delete view.dataset.result; }
  try {
    if (session.step === "live") await showLive(view, { folder: session.about.folder, opened, command: (text) => { if (session.step === "live") byId("command").textContent = text; } });
    else if (session.step === "open") showOpen(view, session.about, opened);
    else if (session.step === "columns") await showColumns(view, startAnalysis);
    else if (session.step === "result") await showResult(view, () => goTo("files"));
    else if (session.step === "files") await showFiles(view);
    else if (session.step === "figure") await showFigure(view, { command: (text) => showCommandOf("figure", text), compared: () => goTo("compare") });
    else await showCompare(view, { command: (text) => showCommandOf("compare", text), inColumns: opened, inFigure: openFigure });
  } catch (error) {
    showError(error);
  }
}

function showError(error) {
  if (error.name === "AbortError") return;
  const box = error.hints?.length ? questionBox(error, session.opened) : errorBox(error);
  byId("problem")?.remove();
  const notice = make("div", { id: "problem" }, box, button("Dismiss", () => notice.remove()));
  view.prepend(notice);
  if (!error.message) throw error;
}

function goTo(step) {
  setStep(step);
  if (!["live", "figure"].includes(step)) showCommand();
  scrollTo(0, 0);
  view.focus({ preventScroll: true });
  announce(TITLES[step]);
  return show();
}

/** Open a chosen file: a log or a result starts a new session, other files are added to the comparison. */
async function opened({ source, name, options = {}, exportState, kind = NOT_LOGS.test(name) ? "unknown" : "log", isAnalysed = false }) {
  if (!["log", "result"].includes(kind)) {
    try {
      const content = await open(source, {});
      if (content.kind !== "log") return await openContent(content, source, name);
    } catch (error) {
      return showError(error);
    }
  }
  cancel();
  forget();
  begin(source, name, options, exportState);
  await goTo("columns");
  return isAnalysed && session.opened && !session.opened.question ? startAnalysis() : undefined;
}

/** Open a figure: its curves are clicked. */
function openFigure({ source, name }) {
  beginFigure(newFigure(source, nameOfPath(name)));
  return goTo("figure");
}

/** Open a file that is not a log: a session, a result, a store, a model, a datasheet or a figure. */
async function openContent(content, source, name) {
  if (content.kind === "figure") return openFigure({ source, name });
  if (content.kind === "session") return opened({ source: { path: content.log }, name: nameOfPath(content.log), options: content.options, exportState: { target: content.target ?? "", choices: content.choices }, kind: "log" });
  if (content.kind === "result") return openResult(content.result, name, source);
  if (content.kind === "store") addStore(source, name, content);
  else if (content.kind === "model") await addSpecification(source);
  else offerDatasheet(source, name);
  return goTo("compare");
}

async function startAnalysis() {
  byId("problem")?.remove();
  try {
    if (await analyse()) await goTo("result");
  } catch (error) {
    showError(error);
  }
}

/** Apply changed options: read the columns again, or analyse again and show the new result in place. */
async function optionsChanged() {
  if (session.step === "columns") return show();
  if (!session.id) return undefined;
  view.setAttribute("aria-busy", "true");
  byId("problem")?.remove();
  try {
    if (await analyse()) await show();
  } catch (error) {
    showError(error);
  } finally {
    view.removeAttribute("aria-busy");
  }
  return undefined;
}

async function showCommand() {
  const { source, name, options } = session;
  if (!source) {
    byId("command").textContent = session.id ? `sigmatau export ${session.result?.name ?? "result.json"} --list` : "sigmatau app";
    return;
  }
  try {
    const { exportState, step } = session, file = step === "files" ? fileOptions() : {};
    const { command } = await config({ options, log: source.path ?? name, ...file });
    if (session.options === options && session.exportState === exportState && session.step === step) byId("command").textContent = command;
  } catch { /* the view shows the error */ }
}

/** What makes the result of the session again: a log with its options, a file, or an id of this server. */
function resultOrigin() {
  const { source, resultSource, name, options, id } = session;
  if (source) return { source, name, options };
  return resultSource ? { source: resultSource, name } : { id };
}

/** Show the command of a step if it is on screen; null shows the command of the session. */
function showCommandOf(step, text) {
  if (session.step !== step) return;
  if (text === null) showCommand();
  else byId("command").textContent = text;
}

function showState() {
  const { source, id, step } = session;
  const isReachable = { live: Boolean(session.about), open: true, columns: Boolean(source), result: Boolean(id), files: Boolean(id), compare: true, figure: Boolean(session.figure) };
  byId("step-figure").parentElement.hidden = !session.figure;
  for (const name of STEPS) {
    const stepButton = byId(`step-${name}`);
    stepButton.disabled = !isReachable[name];
    if (name === step) stepButton.setAttribute("aria-current", "step");
    else stepButton.removeAttribute("aria-current");
  }
  byId("undo").disabled = !canUndo();
  byId("redo").disabled = !canRedo();
  byId("file").replaceChildren(make("bdi", {}, session.name));
  document.title = session.name ? `${session.name} – sigmatau` : "sigmatau";
}

onChange((what) => {
  if (what === "opened" && session.opened?.kind !== "log") return openContent(session.opened, session.source, session.name);
  if (what === "result") rememberResult(session.id, session.result, resultOrigin());
  showState();
  if (what === "options" || what === "source" || what === "result") showCommand();
  if (what === "options") optionsChanged();
  if (what === "figure") figureChanged();
  if (what === "export") {
    showCommand();
    fileChanged();
  }
  return undefined;
});

/** Show a stored result, which has no log to analyse again. */
async function openResult(id, name = session.name, source = null) {
  try {
    const content = await fetchResult(id);
    begin(null, name);
    session.resultSource = source;
    setResult(id, content);
    await goTo("result");
  } catch (error) {
    showError(error);
  }
}

function keys(event) {
  const command = event.ctrlKey || event.metaKey, isText = event.target.matches?.("input[type=text], input[type=number], textarea");
  if (command && event.key === "Enter" && session.step === "columns") byId("analyse")?.click();
  else if (command && event.key.toLowerCase() === "z" && !isText) event.shiftKey ? redo() : undo();
  else if (command && event.key.toLowerCase() === "y" && !isText) redo();
  else return;
  event.preventDefault();
}

async function restore() {
  const stated = readFragment();
  if (!stated) return goTo(session.about.live ? "live" : "open");
  if (stated.step === "compare" && stated.compared) return restoreCompared(stated);
  if (stated.step === "figure" && figureFrom(stated.figure)) return restoreFigure(stated);
  if (!stated.source) return openResult(stated.result);
  forget();
  begin(stated.source, stated.name, stated.options, stated.exportState);
  if (["result", "files", "compare"].includes(stated.step)) {
    setStep("columns");
    showState();
    view.replaceChildren(make("p", { className: "none" }, "Analysing the log of this address…"));
    try {
      if (await analyse()) return goTo(stated.step === "compare" ? "result" : stated.step);
    } catch (error) {
      await goTo("columns");
      return showError(error);
    }
  }
  return goTo("columns");
}

/** Restore the clicked points and the session that an address states. */
function restoreFigure({ source, name, options, exportState, figure }) {
  forget();
  if (source) begin(source, name, options, exportState);
  beginFigure(figureFrom(figure));
  return goTo("figure");
}

/** Restore the comparison and the session that an address states. */
async function restoreCompared({ source, name, options, exportState, compared }) {
  const problems = [];
  forget();
  begin(source, name, options, exportState);
  setStep("compare");
  view.replaceChildren(make("p", { className: "none" }, "Restoring the comparison of this address…"));
  await restoreComparison(compared, addAgain, (error) => problems.push(error));
  const key = JSON.stringify([source, options]), current = source && allResults().find(({ from }) => JSON.stringify([from.source, from.options]) === key);
  if (current) setResult(current.key, await fetchResult(current.key));
  await goTo("compare");
  for (const error of problems) showError(error);
}

for (const name of STEPS) byId(`step-${name}`).addEventListener("click", () => goTo(name));
byId("undo").addEventListener("click", undo);
byId("redo").addEventListener("click", redo);
byId("copy-command").addEventListener("click", (event) => copy(byId("command").textContent, event.currentTarget));
addEventListener("keydown", keys);
addEventListener("hashchange", () => { if (readFragment()) restore(); });
document.querySelector(".skip").addEventListener("click", (event) => { event.preventDefault(); view.focus(); }); // a link would replace the state in the address

acceptDrops(async (file) => {
  if (session.step === "compare") return dropFile(file);
  if (session.step !== "open") await goTo("open");
  return openDropped(file);
});

try {
  session.about = await about();
  showState();
  const named = location.hash || session.about.live ? [] : (await files()).entries;
  if (named.length === 1 && named[0].kind !== "folder") await opened({ source: sourceOfEntry(named[0]), name: named[0].name, kind: named[0].kind }); // sigmatau app LOG
  else if (session.step === "open") await restore(); // otherwise the user has chosen a step meanwhile
} catch (error) {
  view.replaceChildren(errorBox(error));
}
