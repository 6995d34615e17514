// Time series: every stretch from its smallest to its largest sample, and what was not analysed.

import { content, make } from "./page.js";
import { linearTicks, text, tickTexts, timeUnit, unpacked } from "./numbers.js";
import { fullRange, yTicks } from "./plot.js";
import { colourOf, readValues, shortName } from "./frame.js";

/** End of the last series: all have one axis of time, from the beginning of the record. [s] */
export function recordEnd() {
  return Math.max(0, ...Object.values(content.channels).map((channel) => (channel.series ? channel.series.end ?? channel.series.from + channel.series.duration : 0)));
}

/** Where the axis of time begins: of a live record, of which the last minutes are shown, at the first of them. [s] */
export function recordStart() {
  return Math.min(...Object.values(content.channels).map((channel) => channel.series?.start ?? 0));
}

export const series = {
  id: "series",
  title: "Time series",
  has: (channel) => Boolean(channel.series),
  height: (sensor, state) => 128 * Math.min(state.seen.size, 12) + 22,
  options: [{ name: "outside", text: "Not analysed", on: () => true }],
  describe(sensor, state) {
    const start = recordStart(), end = recordEnd();
    const found = sensor.channels.filter((name) => content.channels[name].series && state.seen.has(name)).map((name, k, all) => {
      const { from: begin, duration, bins, low, high, outside } = content.channels[name].series;
      const unit = timeUnit(end), x = Array.from({ length: bins }, (_, k) => (begin + ((k + 0.5) * duration) / bins) / unit.size);
      const inUnit = (values) => values.map((value) => (value === null ? null : value / state.unit.factor));
      return {
        title: `Time series, ${name}`, height: k + 1 < all.length ? 128 : 150,
        lines: [{ name: shortName(sensor, name), x, low: inUnit(decoded(low)), high: inUnit(decoded(high)), colour: colourOf(sensor, name), gaps: true, read: true }],
        spans: state.outside ? outside.map(([from, to]) => [from / unit.size, to / unit.size]) : [],
        x: { name: `time [${unit.text}]`, label: k + 1 < all.length ? "" : `time [${unit.text}]`, unit, log: false, range: [start / unit.size, end / unit.size] },
        y: { label: `${shortName(sensor, name).slice(0, 12)} [${state.unit.text}]`, log: false },
      };
    });
    // One axis of time below the other: as wide as the longest text on the left.
    const longest = Math.max(0, ...found.flatMap((one) => tickTexts(linearTicks(...fullRange(one, "y"), yTicks(one)), false)).map((tick) => tick.length));
    for (const one of found) one.y.least = longest;
    return found;
  },
  readout: (point, sensor, state, { x }) => [make("b", {}, `t = ${text(point.x, 5)} ${x.unit.text}`), ...readValues(point, state.unit.text)],
};

const decodedSeries = new WeakMap();

export function decoded(packed) {
  if (Array.isArray(packed)) return packed;
  if (!decodedSeries.has(packed)) decodedSeries.set(packed, unpacked(packed));
  return decodedSeries.get(packed);
}
