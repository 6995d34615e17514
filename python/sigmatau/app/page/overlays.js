// Marks that are drawn over plots: a line at the point under the pointer of a linked plot, and the chosen part of the record.

import { plots } from "./plot.js";
import { make } from "./page.js";

/** Product of frequency and averaging time at which a sinusoid adds most to the Allan deviation: sin⁴(πfτ)/(πfτ)² is largest. */
export const AT_PEAK = 0.371;

let point = null; // {axis: "tau" or "t", value} under the pointer
let part = null; // chosen part of the record {from, to} [s]

/** Mark a point of one plot in all other plots with the same axis; null removes the mark. */
export function showPoint(axis, value, origin) {
  point = value === null ? null : { axis, value };
  for (const plot of plots) if (plot.described.link) placePoint(plot, plot.described === origin);
}

/** Mark the chosen part of the record in all plots over time; null removes the mark. */
export function showPart(chosen) {
  part = chosen;
  for (const plot of plots) if (plot.described.link === "t") placePart(plot);
}

/** Mark new plots, and again whenever they are drawn with other scales. */
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
