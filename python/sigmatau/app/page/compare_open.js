// Adding files to a comparison: a log is analysed, and questions about it are asked in this step.

import { make } from "./page.js";
import { open, result as fetchResult } from "./api.js";
import { announce, bdi, button, errorBox, isEmpty, nameOfPath } from "./dom.js";
import { addSpecification, addStore, rememberResult } from "./comparison.js";
import { offerDatasheet } from "./compare_sources.js";
import { analyseFile } from "./jobs.js";
import { sendFile, showFolder } from "./open_view.js";
import { questionBox } from "./question.js";

let addDropped = () => {};

/** Add a file that was dropped on the step. */
export const dropFile = (file) => addDropped(file);

/** Control that adds files; `changed` is called after a file was added, `inColumns` opens a log in step 2, `inFigure` a figure. */
export function fileAdder(changed, inColumns, inFigure) {
  const place = make("div", { className: "adding", ariaLive: "polite" }), list = make("div", { className: "folder" });
  const chooser = make("input", { type: "file", className: "unseen", id: "compare-chooser", tabIndex: -1, ariaLabel: "File to compare", onchange: () => { if (chooser.files[0]) send(chooser.files[0]); } });
  const folder = make("details", { ontoggle: () => { if (folder.open) showFolder(list, null, add); } }, make("summary", {}, "Files in the opened folders"), list);
  const send = (file) => sendFile(file, place, add);
  addDropped = send;

  async function add({ source, name, options = {} }) {
    place.replaceChildren(make("p", { className: "none" }, "Reading ", bdi(name), "…"));
    try {
      const done = await addFile({ source, name, options }, inFigure, (question, opened) => ask(question, opened, { source, name, options }));
      if (!done) return;
      folder.open = false;
      place.replaceChildren();
      announce(`${name} was added`);
      changed();
    } catch (error) {
      if (error.hints?.length) ask(error, null, { source, name, options });
      else place.replaceChildren(errorBox(error));
    }
  }

  function ask(question, opened, { source, name, options }) {
    const change = (changes) => add({ source, name, options: Object.fromEntries(Object.entries({ ...options, ...changes }).filter(([, value]) => !isEmpty(value))) });
    folder.open = false;
    place.replaceChildren(
      make("p", {}, make("b", {}, bdi(name))),
      questionBox(question, opened, { all: () => options, change }),
      make("p", { className: "row" }, button("Choose the columns in step 2", () => inColumns({ source, name, options })), button("Do not add it", () => place.replaceChildren())));
    place.querySelector("button")?.focus();
  }

  return [make("h2", {}, "Add a file"),
    make("p", { className: "about" }, "A log (it is analysed), a result, a store, a noise model, a datasheet, or the figure of one, whose curve is clicked."),
    make("p", { className: "row" }, button("Choose a file…", () => chooser.click(), { id: "add-file" }), chooser, make("span", { className: "about" }, "or drop it anywhere on this page")), place, folder];
}

/** Add the content of a file to the comparison. Returns whether it was added; `inFigure` opens a figure, `ask` is called with a question about a log. */
async function addFile({ source, name, options }, inFigure, ask) {
  const content = await open(source, options);
  if (content.kind === "session") return addFile({ source: { path: content.log }, name: nameOfPath(content.log), options: content.options }, inFigure, ask);
  if (content.kind === "figure") {
    inFigure({ source, name });
    return false;
  }
  if (content.kind === "result") rememberResult(content.result, await fetchResult(content.result), { source, name });
  else if (content.kind === "store") addStore(source, name, content);
  else if (content.kind === "model") await addSpecification(source);
  else if (content.kind === "datasheet") offerDatasheet(source, name);
  else if (content.question) {
    ask(content.question, content);
    return false;
  } else return Boolean(await addLog({ source, name, options }));
  return true;
}

/** Analyse a log and add its result. Returns its key. */
async function addLog({ source, name, options }) {
  const made = await analyseFile(source, options, name);
  if (made) rememberResult(made.id, made.content, { source, name, options });
  return made?.id;
}

/** Restore a result that an address states. A log is analysed again, because it can have changed. Returns the key of the result. */
export async function addAgain({ source, name, options, id }) {
  if (options) return addLog({ source, name, options });
  const key = id ?? (await open(source, {})).result;
  rememberResult(key, await fetchResult(key), id ? { id } : { source, name });
  return key;
}
