// A running analysis: its stages on screen, and its cancellation.

import { make } from "./page.js";
import { analyze, result } from "./api.js";
import { announce, bdi, button, byId } from "./dom.js";
import { resultOfOptions, session, setResult } from "./session.js";

const STAGES = { read: "Reading the file", choose: "Selecting the part", check: "Checking the samples", mask: "Leaving out disturbances", curves: "Computing the curves", fit: "Fitting the coefficients", judge: "Testing the fits" };
let running = null; // AbortController of the running analysis

export const isRunning = () => running !== null;

/** Cancel the running analysis, if there is one. */
export function cancel() {
  running?.abort();
}

/** Analyse the file of the session with its options; an earlier result with these options is used again.
 *
 * Returns false if the analysis was cancelled or replaced by another one; throws if it failed.
 */
export async function analyse() {
  const earlier = resultOfOptions();
  if (earlier) {
    try {
      cancel();
      setResult(earlier, await result(earlier));
      return true;
    } catch { /* the server has removed it */ }
  }
  const made = await analyseFile(session.source, session.options, session.name);
  if (made) setResult(made.id, made.content);
  return Boolean(made);
}

/** Analyse a file. Returns its result as {id, content}, or null if it was cancelled or replaced by another analysis. */
export async function analyseFile(source, options, name) {
  cancel();
  const request = (running = new AbortController());
  const bar = showProgress(name);
  let announced = "";
  try {
    const id = await analyze(source, options, (job) => {
      if (request.signal.aborted) return;
      const stage = bar.update(job);
      if (stage && stage !== announced) announce((announced = stage));
    }, request.signal);
    const content = await result(id);
    if (request.signal.aborted) return null;
    announce("The analysis is done.");
    return { id, content };
  } catch (error) {
    if (error.name !== "AbortError") throw error;
    announce("The analysis was cancelled.");
    return null;
  } finally {
    if (running === request) {
      running = null;
      byId("progress").hidden = true;
    }
  }
}

function showProgress(name) {
  const list = make("ol", { className: "stages" }), elapsed = make("span", { className: "elapsed" });
  const panel = byId("progress");
  panel.replaceChildren(make("p", {}, make("strong", {}, "Analysing "), bdi(name), " ", elapsed), list, button("Cancel", cancel, { id: "cancel" }));
  panel.hidden = false;
  return {
    update({ state, stages, elapsed_s }) {
      elapsed.textContent = `${(elapsed_s ?? 0).toFixed(1)} s`;
      list.replaceChildren(...(stages ?? []).map((stage) => make("li", { className: stage.done ? "done" : "now" }, stageName(stage.name), ...(stage.done && stage.seconds >= 0.1 ? [` ${stage.seconds.toFixed(1)} s`] : []))));
      const now = (stages ?? []).find((stage) => !stage.done);
      return state === "waiting" ? "Waiting for another analysis" : now ? stageName(now.name) : "";
    },
  };
}

const stageName = (name) => STAGES[name] ?? name;
