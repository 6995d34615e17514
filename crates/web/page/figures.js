// The figures: deviation, density, record and error, from the model at once and from the record when it is there.

import { chartIn, rangeAround } from "./chart.js";
import { denseSizes, frequenciesOf } from "./core.js";
import { modelNow, PROCESS, samplesNow, sensor, settings, TERMS } from "./settings.js";
import { make } from "./page.js";
import { text } from "./numbers.js";

const PARTS = [...TERMS, PROCESS];
const DASH = [5, 4];

/** What the page has of the present record: its curve, density, estimate. */
export const shown = { curve: null, density: null, envelope: null, fit: null, log: null };

/** Relative error of a deviation by eq. (26): N samples, clusters of n. */
export const errorOfPaper = (samples, size) => 1 / Math.sqrt(2 * (samples / size - 1));

export const byId = (id) => document.getElementById(id);

/** All figures. `call`: the core of this page. */
export function figures(call) {
  const unit = () => sensor().rate;
  const nearest = (xs, x) => xs.reduce((best, value, k) => (Math.abs(Math.log(value / x)) < Math.abs(Math.log(xs[best] / x)) ? k : best), 0);
  const seconds = { label: () => "Averaging time τ [s]", log: true };
  let model = null, curve = null, density = null, limits = null;

  const deviation = chartIn(byId("deviation"), {
    title: "Allan deviation", x: seconds, y: { label: () => `σ(τ) [${unit()[0]}]`, log: true },
    hint: "Point at the curve, or focus it and press ← →, to read it.",
    at(tau) {
      const k = nearest(curve.tau, tau), parts = [`τ = ${text(curve.tau[k])} s`];
      if (!shown.log) parts.push(`model ${text(curve.all[k])} ${unit()[0]}`);
      if (shown.curve) {
        const j = nearest(shown.curve.tau, tau);
        if (Math.abs(Math.log(shown.curve.tau[j] / tau)) < 0.3) parts.push(`record ${text(shown.curve.adev[j])}${shown.curve.low ? ` [${text(shown.curve.low[j])}, ${text(shown.curve.high[j])}]` : ""} at ${text(shown.curve.tau[j])} s`);
      }
      return parts.join(" · ");
    },
  });
  const spectrum = chartIn(byId("density"), {
    title: "Power spectral density", x: { label: () => "Frequency f [Hz]", log: true }, y: { label: () => `S(f), two-sided [(${unit()[0]})²/Hz]`, log: true },
    hint: "Slopes: Q +2, N 0, B −1, K −2; R has none.",
    at(f) {
      const k = nearest(density.f, f), value = shown.log ? null : density.all[k];
      return `f = ${text(density.f[k])} Hz${value === null ? "" : ` · S = ${text(value)} (${unit()[0]})²/Hz · √S = ${text(Math.sqrt(value))} ${unit()[0]}/√Hz`}`;
    },
  });
  const record = chartIn(byId("record"), {
    title: "Record", x: { label: () => `Time [${lengthUnit()[0]}]`, log: false }, y: { label: () => `Rate [${unit()[0]}]`, log: false },
    hint: "Smallest and largest sample of each stretch.",
    at: (t) => `t = ${text(t)} ${lengthUnit()[0]}`,
  });
  const error = chartIn(byId("error"), {
    title: "Relative error of a deviation", x: seconds, y: { label: () => "Error of σ(τ) [%]", log: true },
    hint: "Relative standard error, one sigma.",
    at(tau) {
      if (!limits) return "";
      const k = nearest(limits.tau, tau);
      return `τ = ${text(limits.tau[k])} s: eq. (26) ${text(limits.paper[k], 2)} %, exact ${text(limits.exact[k], 2)} %`;
    },
  });

  const samples = () => shown.log?.samples.length ?? samplesNow();
  const tau0 = () => shown.log?.tau0 ?? 1 / settings.value.rate;
  function lengthUnit() {
    const length = samples() * tau0();
    return length > 7200 ? ["h", 3600] : length > 600 ? ["min", 60] : ["s", 1];
  }

  /** The curves of the model, from closed forms. */
  function drawModel() {
    model = modelNow();
    if (shown.log) model[9] = shown.log.tau0;
    const n = samples(), size = unit()[1];
    const sizes = denseSizes(n), avar = call("avar", model, sizes), count = sizes.length;
    const row = (values, k, length) => values.subarray(k * length, (k + 1) * length);
    const rooted = (values) => Float64Array.from(values, (value) => Math.sqrt(value) / size);
    curve = { tau: sizes.map((m) => m * tau0()), all: rooted(row(avar, 0, count)), parts: PARTS.map((_, k) => rooted(row(avar, k + 1, count))) };
    const f = frequenciesOf(n, tau0()), psd = call("psd", model, f);
    const scaled = (values) => Float64Array.from(values, (value) => value / size ** 2);
    density = { f, all: scaled(row(psd, 0, f.length)), parts: PARTS.map((_, k) => scaled(row(psd, k + 1, f.length))) };
  }

  const isOn = (part) => (part === PROCESS ? settings.on.sigma : settings.on[part.id]);
  let frozen = null; // range of the deviation while a line is dragged
  let byHand = () => null;

  function drawDeviation() {
    if (!curve) return;
    const measured = shown.curve, hand = byHand();
    const values = [...(shown.log ? [] : curve.all), ...(measured ? measured.adev : []), ...(hand ? [hand.read] : [])];
    const y = frozen ?? rangeAround(values, true, 2);
    const x = [curve.tau[0] / 1.15, curve.tau.at(-1) * 1.15];
    if (hand) { x[0] = Math.min(x[0], hand.tau / 1.15); x[1] = Math.max(x[1], hand.tau * 1.15); }
    const lines = [], marks = [];
    if (!shown.log) {
      if (byId("show-parts").checked)
        PARTS.forEach((part, k) => {
          if (!isOn(part)) return;
          lines.push({ x: curve.tau, y: curve.parts[k], colour: part.colour, width: 1.3, dash: DASH });
          const at = part.slope > 0 || part === PROCESS ? nearestIn(curve.tau, curve.parts[k], y, -1) : nearestIn(curve.tau, curve.parts[k], y, 1);
          if (at !== null) marks.push({ x: curve.tau[at], y: curve.parts[k][at], text: part === PROCESS ? "G–M" : `${part.id}  ${part.slopeText}`, colour: part.colour, align: part.slope > 0 || part === PROCESS ? "right" : "left" });
        });
      lines.push({ x: curve.tau, y: curve.all, colour: "ink", width: 2.2 });
    }
    if (shown.fit?.curve && !shown.log) lines.push({ ...shown.fit.curve, colour: "link", width: 1.6, dash: [2, 3] });
    const points = measured ? [{ x: measured.tau, y: measured.adev, low: measured.low, high: measured.high, colour: "link" }] : [];
    if (hand) {
      lines.push({ x, y: x.map((t) => hand.read * (t / hand.tau) ** hand.slope), colour: "poor", width: 2 });
      marks.push({ x: hand.tau, y: hand.read, text: hand.text, colour: "poor", ring: true });
    }
    deviation.set({ x, y, lines, points, marks });
  }

  function drawDensity() {
    if (!density) return;
    const all = shown.log ? [] : density.all, measured = shown.density;
    const y = rangeAround([...all, ...(measured ? measured.s : [])], true, 2), lines = [];
    if (!shown.log) {
      if (byId("show-parts").checked)
        PARTS.forEach((part, k) => { if (isOn(part) && part.id !== "R") lines.push({ x: density.f, y: density.parts[k], colour: part.colour, width: 1.3, dash: DASH }); });
      lines.push({ x: density.f, y: density.all, colour: "ink", width: 2.2 });
    }
    const points = measured ? [{ x: measured.f, y: measured.s, colour: "link", size: 2 }] : [];
    spectrum.set({ x: [density.f[0] / 1.15, density.f.at(-1) * 1.15], y, lines, points });
  }

  function drawRecord() {
    if (!shown.envelope) return;
    const values = shown.envelope.map((value) => value / unit()[1]), span = (samples() * tau0()) / lengthUnit()[1];
    record.set({ x: [0, span], y: rangeAround(values, false), stretches: { values, span, colour: "axis-0" } });
  }

  /** Eq. (26) beside the exact error of the noise of the model. */
  function drawError(sizes, freedom) {
    if (!freedom) return;
    const usable = sizes.map((m, k) => [m, freedom[3 * k]]).filter(([m]) => m <= samples() / 2);
    limits = { tau: usable.map(([m]) => m * tau0()), paper: usable.map(([m]) => 100 * errorOfPaper(samples(), m)), exact: usable.map(([, edf]) => 100 / Math.sqrt(2 * edf)) };
    const y = rangeAround([...limits.paper, ...limits.exact], true, 1.5);
    error.set({ x: [limits.tau[0] / 1.15, limits.tau.at(-1) * 1.15], y, lines: [{ x: limits.tau, y: limits.paper, colour: "axis-1", dash: DASH }, { x: limits.tau, y: limits.exact, colour: "axis-0" }] });
  }

  return {
    deviation, drawModel, drawDeviation, drawDensity, drawRecord, drawError, samples, tau0,
    model: () => model, curve: () => curve, density: () => density, limits: () => limits,
    columns: () => Math.max(200, Math.min(1200, (record.width() || 800) - 80)),
    freeze(range) { frozen = range; },
    setByHand(source) { byHand = source; },
  };
}

/** Index of the first point in a range from one end of a line; null if there is none. */
function nearestIn(xs, ys, [low, high], step) {
  const from = step > 0 ? 1 : xs.length - 2;
  for (let k = from; k >= 0 && k < xs.length; k += step) if (ys[k] > low && ys[k] < high * 0.8) return k;
  return null;
}

/** A legend of lines: [colour, text, dashed]. */
export function legend(entries) {
  return make("p", { className: "legend keys" }, ...entries.map(([name, words, dashed]) =>
    make("span", {}, make("i", { style: `border-top: 3px ${dashed ? "dashed" : "solid"} var(--${name})` }), words)));
}
