// The figures: deviation, density, record and error, from the model at once and from the record when it is there.

import { chartIn, rangeAround } from "./chart.js";
import { denseSizes, frequenciesOf } from "./core.js";
import { hasNoise, modelNow, PROCESS, samplesNow, sensor, settings, TERMS } from "./settings.js";
import { foldedNoise } from "./sampled.js";
import { make } from "./page.js";
import { text } from "./numbers.js";

const PARTS = [...TERMS, PROCESS];
const DASH = [5, 4], DOTS = [2, 3];

/** What the page has of the present record: its curve, density, estimate; `folded`: what it holds of the filtered white noise. */
export const shown = { curve: null, density: null, envelope: null, fit: null, log: null, folded: { white: 0, corner: null } };

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
      // The model is read at the τ of the point of the record, if one is close.
      const measured = shown.curve, j = measured ? nearest(measured.tau, tau) : -1;
      const isPoint = j >= 0 && Math.abs(Math.log(measured.tau[j] / tau)) < 0.3;
      const read = isPoint ? measured.tau[j] : curve.tau[nearest(curve.tau, tau)], parts = [`τ = ${text(read)} s`];
      if (!shown.log) parts.push(`model ${text(valueOfCurve(curve.tau, curve.all, read))} ${unit()[0]}`);
      if (isPoint) parts.push(`record ${text(measured.adev[j])} [${text(measured.low[j])}, ${text(measured.high[j])}] ${unit()[0]}`);
      return parts.join(" · ");
    },
  });
  const spectrum = chartIn(byId("density"), {
    title: "Power spectral density", x: { label: () => "Frequency f [Hz]", log: true }, y: { label: () => `S(f), two-sided [(${unit()[0]})²/Hz]`, log: true },
    hint: "Slopes: Q +2, N 0, B −1, K −2. R is no noise and has no density: its drift raises the points at low f. Eq. (24), 1/f³, belongs to a flicker acceleration. Two-sided: a one-sided density is twice as high.",
    at(f) {
      const k = nearest(density.f, f), value = shown.log ? null : density.all[k];
      return `f = ${text(density.f[k])} Hz${value === null ? "" : ` · S = ${text(value)} (${unit()[0]})²/Hz · √S = ${text(Math.sqrt(value))} ${unit()[0]}/√Hz`}`;
    },
  });
  const record = chartIn(byId("record"), {
    title: "Record", x: { label: () => `Time [${lengthUnit()[0]}]`, log: false }, y: { label: () => `Rate [${unit()[0]}]`, log: false },
    hint: "The record has more samples than the screen has columns: each bar reaches from the smallest to the largest sample of its column.",
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
    shown.folded = foldedNoise(call, model);
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
    const flat = !shown.log && settings.on.B ? [curve.parts[2].at(-1) / 1.25] : []; // room for the line of B
    const values = [...(shown.log ? [] : curve.all), ...flat, ...(measured ? measured.adev : []), ...(hand ? [hand.read] : [])];
    const y = frozen ?? rangeAround(values, true, 2);
    const x = [curve.tau[0] / 1.15, curve.tau.at(-1) * 1.15];
    if (hand) { x[0] = Math.min(x[0], hand.tau / 1.15); x[1] = Math.max(x[1], hand.tau * 1.15); }
    const lines = [], marks = [];
    if (!shown.log) {
      if (byId("show-parts").checked)
        PARTS.forEach((part, k) => {
          if (!isOn(part)) return;
          lines.push({ x: curve.tau, y: curve.parts[k], colour: part.colour, width: 1.3, dash: DASH });
          // A label is below its line, where the curve of all noise is not: near its lower end, or at the left end of a flat line.
          const rises = part.slope > 0 || part === PROCESS, places = placesIn(curve.tau, curve.parts[k], y, rises || part.slope === 0);
          if (places.length) marks.push({ places, text: part === PROCESS ? "G–M" : `${part.id}  ${part.slopeText}`, colour: part.colour, align: rises || part.slope === 0 ? "left" : "right", below: true });
        });
      lines.push({ x: curve.tau, y: curve.all, colour: "ink", width: 2.2 });
    }
    if (shown.fit?.curve && !shown.log) lines.push({ ...shown.fit.curve, colour: "record", width: 1.8, dash: DOTS });
    const points = measured ? [{ x: measured.tau, y: measured.adev, low: measured.low, high: measured.high, colour: "record" }] : [];
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
    const points = measured ? [{ x: measured.f, y: measured.s, colour: "record", size: 2 }] : [];
    const note = !shown.log && !hasNoise() ? ["A ramp is no noise: it has no density.", "Eq. (24), 1/f³, belongs to a flicker acceleration.", "There is no noise to estimate."] : null;
    spectrum.set({ x: [density.f[0] / 1.15, density.f.at(-1) * 1.15], y, lines, points, note });
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

/** The points of a line in a range, from its left end if it rises or is flat, else from its right end. */
function placesIn(xs, ys, [low, high], rises) {
  const inner = Array.from(xs, (x, k) => [x, ys[k]]).slice(1, -1).filter(([, y]) => y > 1.8 * low && y < 0.8 * high);
  return rises ? inner : inner.reverse();
}

/** The value of a curve at τ, along a power law between its points. */
function valueOfCurve(taus, values, tau) {
  const k = Math.max(1, Math.min(taus.length - 1, taus.findIndex((each) => each >= tau)));
  const share = Math.log(tau / taus[k - 1]) / Math.log(taus[k] / taus[k - 1]);
  return values[k - 1] * (values[k] / values[k - 1]) ** share;
}

/** A legend of lines: [colour, text, style of the line]. */
export function legend(entries) {
  return make("p", { className: "legend keys" }, ...entries.map(([name, words, style = "solid"]) =>
    make("span", {}, make("i", { style: `border-top: 3px ${style} var(--${name})` }), words)));
}
