// Residuals: the measured Allan deviation over that of the model.

import { colour, content, make } from "./page.js";
import { rangeOf, text } from "./numbers.js";
import { colourOf, readValues, shortName } from "./frame.js";

export const residuals = {
  id: "residuals",
  title: "Residuals",
  has: (channel) => Boolean(channel.deviation?.model),
  height: () => 220,
  unit: false,
  options: [{ name: "bands", text: "Intervals", on: (sensor) => sensor.channels.length <= 6 }],
  describe(sensor, state) {
    const lines = [];
    for (const name of sensor.channels) {
      if (!residuals.has(content.channels[name]) || !state.seen.has(name)) continue;
      const { tau, adev, low, high, model } = content.channels[name].deviation;
      const over = (values) => values.map((value, k) => (value === null || !(model[k] > 0) ? null : value / model[k]));
      const line = { name: shortName(sensor, name), x: tau, y: over(adev), colour: colourOf(sensor, name), points: tau.length < 120, width: 1.2, read: true };
      if (state.bands) Object.assign(line, { low: over(low), high: over(high) });
      lines.push(line);
    }
    if (!lines.length) return [];
    const range = residualRange(lines);
    const ends = rangeOf(lines.flatMap((line) => line.x), true);
    lines.unshift({ name: "model", x: ends, y: [1, 1], colour: () => colour("soft"), width: 1, legend: false });
    return [{
      title: `Residuals, ${sensor.title}`, height: 220, lines,
      x: { label: "averaging time τ [s]", log: true, range: ends },
      y: { label: "ratio to the model", log: false, range },
    }];
  },
  readout: (point) => [make("b", {}, `τ = ${text(point.x)} s`), ...readValues(point, "of the model")],
};

/** From the smallest to the largest ratio with room for intervals, at most from 0 to 4. */
function residualRange(lines) {
  const values = lines.flatMap((line) => line.y).filter((value) => value !== null);
  const ends = lines.flatMap((line) => [...(line.low ?? []), ...(line.high ?? [])]).filter((value) => value !== null && value > 0.3 && value < 2.5);
  const low = Math.min(0.9, ...values, ...ends), high = Math.max(1.1, ...values, ...ends);
  return [Math.max(0, low - 0.04 * (high - low)), Math.min(4, high + 0.04 * (high - low))];
}
