// Lines of the five slopes on a curve. A handle moves each along the curve, by the pointer or by the arrow keys.

import { make } from "./page.js";
import { closest } from "./plot.js";
import { text } from "./numbers.js";

const NS = "http://www.w3.org/2000/svg";
export const SIGNS = { "-1": "−1", "-0.5": "−½", 0: "0", 0.5: "+½", 1: "+1" };

/** Draw the lines on a plot.
 *
 * tau, adev: the curve, in the unit of the plot
 * terms: [{name, label, slope, colour}]
 * moved(term, k): called after a handle was moved to point k of the curve
 *
 * Returns {place(name, k), hide(name), describe(name, text, refused)}.
 */
export function drawSlopes(plot, tau, adev, terms, moved) {
  const { u } = plot, lines = new Map();
  const svg = document.createElementNS(NS, "svg");
  svg.setAttribute("class", "slopes");
  svg.setAttribute("aria-hidden", "true");
  u.over.append(svg);
  for (const term of terms) lines.set(term.name, makeLine(term));

  function makeLine(term) {
    const line = document.createElementNS(NS, "line");
    line.setAttribute("stroke", term.colour());
    svg.append(line);
    const handle = make("div", { className: "handle", tabIndex: 0, hidden: true }, SIGNS[term.slope]);
    handle.style.setProperty("--paint", term.colour());
    handle.setAttribute("role", "slider");
    handle.setAttribute("aria-label", `Averaging time of the line of ${term.label}, slope ${SIGNS[term.slope]}`);
    handle.setAttribute("aria-valuemin", "0");
    handle.setAttribute("aria-valuemax", String(tau.length - 1));
    u.over.append(handle);
    const made = { term, line, handle, k: null };
    const go = (k) => { const next = Math.min(Math.max(k, 0), tau.length - 1); if (next !== made.k) { set(made, next); moved(term, next); } };
    handle.addEventListener("keydown", (event) => {
      const steps = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -5, PageUp: 5, Home: -tau.length, End: tau.length }[event.key];
      if (steps === undefined) return;
      event.preventDefault();
      event.stopPropagation();
      go(made.k + steps);
    });
    for (const kind of ["mousedown", "click", "dblclick"]) handle.addEventListener(kind, (event) => event.stopPropagation());
    handle.addEventListener("pointerdown", (event) => { event.preventDefault(); handle.focus(); handle.setPointerCapture(event.pointerId); handle.classList.add("dragged"); });
    handle.addEventListener("pointermove", (event) => {
      if (!handle.hasPointerCapture(event.pointerId)) return;
      go(closest(tau, u.posToVal(event.clientX - u.over.getBoundingClientRect().left, "x"), true));
    });
    for (const kind of ["pointerup", "pointercancel"]) handle.addEventListener(kind, () => handle.classList.remove("dragged"));
    return made;
  }

  function set(made, k) {
    made.k = k;
    made.handle.setAttribute("aria-valuenow", String(k));
    made.handle.setAttribute("aria-valuetext", `τ = ${text(tau[k])} s`);
    position(made);
  }

  function position({ term, line, handle, k }) {
    handle.hidden = k === null;
    line.style.display = k === null ? "none" : "";
    if (k === null) return;
    const { min, max } = u.scales.x, value = (t) => adev[k] * (t / tau[k]) ** term.slope;
    const ends = [min, max].map((t) => [u.valToPos(t, "x"), u.valToPos(value(t), "y")]);
    if (!ends.flat().every(Number.isFinite)) return; // the plot has no scales yet; its first drawing calls this again
    ["x1", "y1", "x2", "y2"].forEach((name, j) => line.setAttribute(name, ends[j >> 1][j % 2].toFixed(1)));
    const x = u.valToPos(tau[k], "x"), y = u.valToPos(adev[k], "y");
    handle.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
    handle.hidden = x < 0 || x > u.over.clientWidth || y < 0 || y > u.over.clientHeight;
  }

  (u.hooks.draw ??= []).push(() => { for (const made of lines.values()) position(made); });
  return {
    place: (name, k) => set(lines.get(name), k),
    hide: (name) => { lines.get(name).k = null; position(lines.get(name)); },
    describe: (name, words, refused) => {
      const { handle, k, line } = lines.get(name);
      handle.classList.toggle("refused", refused);
      line.classList.toggle("refused", refused);
      handle.setAttribute("aria-valuetext", `τ = ${text(tau[k])} s: ${words}`);
    },
  };
}

/** The point of a curve whose slope is closest to that of a term, where its line is drawn first. */
export function pointOfSlope(tau, adev, slope) {
  let best = 0, smallest = Infinity;
  for (let k = 0; k < tau.length; k++) {
    const a = Math.max(k - 1, 0), b = Math.min(k + 1, tau.length - 1);
    if (b <= a || !(adev[a] > 0) || !(adev[b] > 0)) continue;
    const off = Math.abs(Math.log(adev[b] / adev[a]) / Math.log(tau[b] / tau[a]) - slope) + (k < 2 || k > 0.75 * tau.length ? 0.15 : 0);
    if (off < smallest) { smallest = off; best = k; }
  }
  return best;
}
