// What is laid over plots without drawing them again: lines at a point that is read elsewhere, and the part that is chosen.

import { plots } from "./plot.js";
import { make } from "./page.js";

/** Averaging time at which the Allan deviation answers most to a sinusoid of a frequency: sin⁴(πfτ)/(πfτ)² is largest. */
export const AT_PEAK = 0.371;

let point = null; // {axis: "tau" or "t", value} that is read in one plot
let part = null; // {from, to} of the record that is chosen [s]

/** Show the point that is read in one plot in all others with the same axis; null hides it. */
export function showPoint(axis, value, origin) {
  point = value === null ? null : { axis, value };
  for (const plot of plots) if (plot.described.link) placePoint(plot, plot.described === origin);
}

/** Show which part of the record is chosen, in all plots over time; null hides it. */
export function showPart(chosen) {
  part = chosen;
  for (const plot of plots) if (plot.described.link === "t") placePart(plot);
}

/** Follow the scales of new plots. */
export function follow(made) {
  for (const plot of made.drawn) {
    (plot.u.hooks.draw ??= []).push(() => { placePart(plot); placePoint(plot, false); });
    placePart(plot);
  }
}

function placePoint(plot, isOrigin) {
  const { u, described } = plot;
  let x = null;
  if (point && !isOrigin) {
    if (described.link === point.axis) x = point.value / (described.x.unit?.size ?? 1);
    else if (described.link === "f" && point.axis === "tau") x = AT_PEAK / point.value;
  }
  const start = x === null ? -1 : u.valToPos(x, "x");
  const line = x === null ? plot.pointLine : (plot.pointLine ??= added(u, "linked"));
  if (!line) return;
  line.hidden = !(start >= 0 && start <= u.over.clientWidth);
  line.style.transform = `translateX(${start}px)`;
}

function placePart(plot) {
  if (plot.described.link !== "t") return;
  if (!part) {
    if (plot.partArea) plot.partArea.hidden = true;
    return;
  }
  const { u, described } = plot, size = described.x.unit?.size ?? 1;
  const area = (plot.partArea ??= added(u, "chosen"));
  const start = Math.max(u.valToPos(part.from / size, "x"), 0), end = Math.min(u.valToPos(part.to / size, "x"), u.over.clientWidth);
  area.hidden = end <= start;
  area.style.transform = `translateX(${start}px)`;
  area.style.width = `${Math.max(end - start, 1)}px`;
}

function added(u, className) {
  const element = make("div", { className });
  u.over.append(element);
  return element;
}
