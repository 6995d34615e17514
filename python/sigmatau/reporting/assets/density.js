// Power spectral density: the measured one with its interval, the model, and the lines that were fitted.

import { content, make } from "./page.js";
import { text } from "./numbers.js";
import { colourOf, readValues, shortName } from "./frame.js";
import { hasModel } from "./deviation.js";

export const density = {
  id: "density",
  title: "Power spectral density",
  has: (channel) => Boolean(channel.density),
  height: () => 340,
  unitText: (unit) => (unit === "1" ? "1/Hz" : unit.length === 1 ? `${unit}²/Hz` : `(${unit})²/Hz`),
  options: [
    { name: "bands", text: "Intervals", on: (sensor) => sensor.channels.length <= 6 },
    { name: "model", text: "Model", on: () => true, needs: hasModel },
    { name: "marks", text: "Lines", on: () => true, needs: (sensor) => sensor.channels.some((name) => content.channels[name].density?.lines?.length) },
  ],
  describe(sensor, state) {
    const lines = [], marks = [];
    for (const name of sensor.channels) {
      const found = content.channels[name].density;
      if (!found || !state.seen.has(name)) continue;
      const inUnit = (values) => values.map((value) => (value === null ? null : value / state.unit.factor ** 2));
      const main = { name: shortName(sensor, name), x: found.frequency, y: inUnit(found.density), colour: colourOf(sensor, name), width: 1.2, read: true };
      if (state.bands) Object.assign(main, { low: inUnit(found.low), high: inUnit(found.high) });
      lines.push(main);
      if (state.model && found.model)
        lines.push({ name: "fitted model", legend: sensor.channels[0] === name, x: found.frequency, y: inUnit(found.model.map((value, k) => (found.frequency[k] > (found.highest ?? Infinity) ? null : value))), colour: colourOf(sensor, name), width: 1.4, dash: [6, 4], framed: false });
      if (state.marks) for (const line of found.lines ?? []) marks.push({ x: line, colour: colourOf(sensor, name) });
    }
    if (!lines.length) return [];
    return [{
      title: `Power spectral density, ${sensor.title}`, height: 340, lines, marks,
      x: { label: "frequency [Hz]", log: true },
      y: { label: `density, two-sided [${density.unitText(state.unit.text)}]`, log: true },
    }];
  },
  readout: (point, sensor, state) => [make("b", {}, `f = ${text(point.x)} Hz`), ...readValues(point, density.unitText(state.unit.text))],
};
