// Allan deviation: curves with intervals, the fitted model, its terms, and lines of the slopes.

import { content, make } from "./page.js";
import { text } from "./numbers.js";
import { colourOf, readValues, shortName } from "./frame.js";

export const hasModel = (sensor) => sensor.channels.some((name) => content.channels[name].deviation?.model);

export const deviation = {
  id: "deviation",
  title: "Allan deviation",
  has: (channel) => Boolean(channel.deviation),
  height: () => 360,
  options: [
    { name: "bands", text: "Intervals", on: (sensor) => sensor.channels.length <= 6 },
    { name: "model", text: "Model", on: () => true, needs: hasModel },
    { name: "parts", text: "Terms", on: (sensor) => sensor.channels.length === 1, needs: hasModel },
    { name: "guides", text: "Slopes", on: () => false },
  ],
  describe(sensor, state) {
    const lines = [];
    for (const name of sensor.channels) {
      if (!content.channels[name].deviation || !state.seen.has(name)) continue;
      const { tau, adev, low, high, model, parts, from, to } = content.channels[name].deviation;
      const inUnit = (values) => values.map((value) => (value === null ? null : value / state.unit.factor));
      const main = { name: shortName(sensor, name), x: tau, y: inUnit(adev), colour: colourOf(sensor, name), points: tau.length < 120, read: true };
      if (state.bands) {
        // At the longest times an interval may reach over decades: drawn, it is cut where the curve can no longer be read.
        main.interval = { low: inUnit(low), high: inUnit(high) };
        main.low = low.map((value, k) => Math.max(value ?? 0, 0.1 * adev[k]) / state.unit.factor);
        main.high = high.map((value, k) => Math.min(value ?? Infinity, 10 * adev[k]) / state.unit.factor);
      }
      lines.push(main);
      if (state.model && model) lines.push(...modelLines(sensor, name, tau, inUnit(model), from, to));
      if (state.parts && parts) {
        const least = Math.min(...main.y) / 4;
        for (const [label, values] of Object.entries(parts))
          lines.push({ name: sensor.channels.length > 1 ? `${shortName(sensor, name)}: ${label}` : label, x: tau, y: inUnit(values).map((value) => (value < least ? null : value)), colour: colourOf(sensor, name), width: 0.9, dash: [1, 3], framed: false, tag: state.seen.size === 1 ? label : undefined });
      }
    }
    if (!lines.length) return [];
    return [{
      title: `Allan deviation, ${sensor.title}`, height: 360, guides: state.guides, lines,
      x: { label: "averaging time τ [s]", log: true },
      y: { label: `Allan deviation σ(τ) [${state.unit.text}]`, log: true },
    }];
  },
  readout: (point, sensor, state) => [make("b", {}, `τ = ${text(point.x)} s`), ...readValues(point, state.unit.text)],
};

/** The model, dashed over the averaging times of the fit, dotted before and after; the parts share a point. */
function modelLines(sensor, name, tau, values, from, to) {
  const inside = (k) => k >= 0 && k < tau.length && tau[k] >= from * (1 - 1e-9) && tau[k] <= to * (1 + 1e-9);
  const fitted = values.map((value, k) => (inside(k) ? value : null));
  const first = tau.findIndex((_, k) => inside(k)), last = tau.length - 1 - [...tau].reverse().findIndex((_, k) => inside(tau.length - 1 - k));
  const shared = { x: tau, colour: colourOf(sensor, name), width: 1.4, legend: sensor.channels[0] === name, framed: false };
  const lines = [{ ...shared, name: "fitted model", y: fitted, dash: [6, 4] }];
  if (first > 0) lines.push({ ...shared, name: "model, not fitted", legend: false, y: values.map((value, k) => (k <= first ? value : null)), dash: [2, 3] });
  if (first >= 0 && last < tau.length - 1) lines.push({ ...shared, name: "model, not fitted", legend: false, y: values.map((value, k) => (k >= last ? value : null)), dash: [2, 3] });
  return lines;
}
