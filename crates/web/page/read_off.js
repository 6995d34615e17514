// Reading off by hand: a line with the slope of a term that is laid on the curve, and the coefficient that it reads.

import { make } from "./page.js";
import { setText } from "./chart.js";
import { text } from "./numbers.js";
import { sensor, settings, termName, TERMS, unitOf } from "./settings.js";
import { shown } from "./figures.js";

const STEP = 1.02; // ratio of heights for a press of a key

/** Readings by term, in the unit of its slider. */
export const readings = new Map();

/** The line on the deviation figure. `onread` is called after each movement. */
export function lineByHand(figures, place, onread) {
  const { deviation } = figures;
  let term = null, anchor = null; // the line passes through the anchor, {tau, value} in units of the curve
  const handle = make("button", { type: "button", className: "handle", role: "slider", hidden: true });
  const says = make("p", { className: "says", role: "status" });
  const buttons = new Map(TERMS.map((each) => [each.id, make("button", { type: "button", ariaPressed: "false", onclick: () => choose(each.id === term?.id ? null : each) }, `${each.id}  ${each.slopeText}`)]));
  place.append(make("div", { className: "row", role: "group", ariaLabel: "Line of a term" }, make("span", {}, "Line of slope"), ...buttons.values()), says);
  deviation.canvas.parentElement.append(handle);

  /** Where the line is read, and its value there. */
  function reading() {
    const tau = term.tau ?? anchor.tau;
    return { tau, read: anchor.value * (tau / anchor.tau) ** term.slope };
  }

  /** The coefficient that the line reads, in the unit of its slider. */
  function coefficient() {
    const { tau, read } = reading();
    // σ in SI at τ: N = σ(1)·√1 s; of the others the power of their reading time is 1 in units of seconds.
    const si = read * sensor().rate[1] * term.factor;
    const atOne = { Q: tau / Math.sqrt(3), N: Math.sqrt(tau), B: 1, K: Math.sqrt(3 / tau), R: Math.SQRT2 / tau }[term.id];
    return (si * atOne) / unitOf(term.id)[1];
  }

  /** The point of the curve whose slope is nearest to that of the line. */
  function start() {
    const { tau, all } = figures.curve();
    const [xs, ys] = shown.log ? [shown.curve?.tau ?? tau, shown.curve?.adev ?? all] : [tau, all];
    let best = 0, least = Infinity;
    for (let k = 1; k + 1 < xs.length; k++) {
      const slope = Math.log(ys[k + 1] / ys[k - 1]) / Math.log(xs[k + 1] / xs[k - 1]), off = Math.abs(slope - term.slope);
      if (off < least) { least = off; best = k; }
    }
    return { tau: xs[best], value: ys[best] * 1.6 }; // above the curve: it is laid by the reader
  }

  function choose(next) {
    term = next;
    for (const [id, button] of buttons) button.setAttribute("aria-pressed", String(id === term?.id));
    handle.hidden = !term;
    if (term) {
      anchor = start();
      handle.setAttribute("aria-label", `Line of slope ${term.slopeText}, ${termName(term.id)}. Up and down arrow keys move it.`);
    }
    draw();
  }

  function draw() {
    figures.drawDeviation();
    say();
  }

  /** A reading counts once the line was moved. */
  function moved() {
    readings.set(term.id, coefficient());
    draw();
    onread();
  }

  function say() {
    if (!term) {
      setText(says, "Choose a line. Drag it by its handle onto the part of the curve with its slope: its height at τ = 1 s is N, at 3 s K, at √3 s Q, at √2 s R; the flat part over 0.664 is B.");
      return;
    }
    const value = coefficient(), { tau, read } = reading(), units = unitOf(term.id)[0];
    const where = term.id === "B" ? "on the flat part" : `at τ = ${term.tauText}`;
    const chosen = settings.value[term.id], ratio = value / chosen, percent = Math.round(100 * (ratio - 1));
    const truth = settings.on[term.id] && !shown.log ? ` That is ${text(ratio, 3)} times the chosen ${text(chosen)} (${percent < 0 ? "−" : "+"}${Math.abs(percent)} %).` : "";
    const factor = value / read, by = factor < 1 ? `÷ ${text(1 / factor, 4)}` : `× ${text(factor, 4)}`;
    const hours = term.id === "B" || settings.sensor !== "gyro" ? "" : " The paper reads at 1 h, 3 h, √3 h and √2 h, because its axis is in hours.";
    setText(says, `${text(read)} ${sensor().rate[0]} ${where}: ${term.id} = ${text(read)} ${by} = ${text(value)} ${units}, eq. (${term.eq}).${truth}${hours}`);
    handle.setAttribute("aria-valuetext", `${term.id} = ${text(value)} ${units}, at τ = ${text(tau)} s`);
    handle.setAttribute("aria-valuenow", String(Number(value.toPrecision(3))));
  }

  function position() {
    if (!term) return;
    const { canvas } = deviation;
    handle.style.transform = `translate(${(canvas.offsetLeft + deviation.toX(anchor.tau)).toFixed(1)}px, ${(canvas.offsetTop + deviation.toY(anchor.value)).toFixed(1)}px)`;
  }
  deviation.placed(position);
  figures.setByHand(() => term && { ...reading(), slope: term.slope, text: `${term.id} read at ${term.tauText}` });

  handle.addEventListener("pointerdown", (event) => {
    event.preventDefault();
    handle.focus();
    handle.setPointerCapture(event.pointerId);
    figures.freeze(deviation.range().y);
  });
  handle.addEventListener("pointermove", (event) => {
    if (!handle.hasPointerCapture(event.pointerId)) return;
    const box = deviation.canvas.getBoundingClientRect(), { x, y } = deviation.range();
    const within = (value, [low, high]) => Math.min(Math.max(value, low), high);
    anchor = { tau: within(deviation.fromX(event.clientX - box.left), x), value: within(deviation.fromY(event.clientY - box.top), y) };
    moved();
  });
  for (const kind of ["pointerup", "pointercancel"]) handle.addEventListener(kind, () => { figures.freeze(null); figures.drawDeviation(); });
  handle.addEventListener("keydown", (event) => {
    const step = event.shiftKey ? STEP ** 5 : STEP;
    if (event.key === "ArrowUp") anchor.value *= step;
    else if (event.key === "ArrowDown") anchor.value /= step;
    else return;
    event.preventDefault();
    moved();
  });
  choose(null);
  return { refresh: () => { if (term && readings.has(term.id)) moved(); else say(); } };
}
