// Stability: the dynamic Allan deviation as a map, each averaging time over its median of all windows.

import { content, make } from "./page.js";
import { text, timeUnit } from "./numbers.js";
import { shortName } from "./frame.js";
import { decoded, recordEnd } from "./series.js";

const MOST = 2; // ratio at the ends of the colours

export const map = {
  id: "map",
  title: "Stability",
  has: (channel) => Boolean(channel.map),
  height: () => 280,
  unit: false,
  axes: false,
  options: [],
  choices(made) {
    const names = made.sensor.channels.filter((name) => content.channels[name].map);
    made.state.shown = names[0];
    if (names.length < 2) return [mapLegend()];
    const select = make("select", { ariaLabel: "Axis", onchange: () => { made.state.shown = names[select.selectedIndex]; made.draw(); } }, ...names.map((name) => make("option", {}, shortName(made.sensor, name))));
    return [select, mapLegend()];
  },
  describe(sensor, state) {
    const { times, tau, window: length, log10, least, most } = content.channels[state.shown].map;
    const unit = timeUnit(recordEnd()), step = times.length > 1 ? times[1] - times[0] : length;
    const values = decoded(log10), rows = tau.length, within = (ratio, j) => ratio > least[j] && ratio < most[j];
    const medians = tau.map((_, j) => median(times.map((_, i) => values[i * rows + j]).filter((value) => value !== null)));
    const x = [...times.map((t) => (t - step / 2) / unit.size), (times[times.length - 1] + step / 2) / unit.size];
    const between = tau.slice(1).map((t, k) => Math.sqrt(t * tau[k]));
    const y = rows > 1 ? [tau[0] ** 2 / between[0], ...between, tau[rows - 1] ** 2 / between[rows - 2]] : [tau[0] / 1.2, tau[0] * 1.2];
    const differs = values.some((value, k) => value !== null && !within(10 ** (value - medians[k % rows]), k % rows));
    return [{
      title: `Stability, ${state.shown}`, height: 280, lines: [], note: differs ? "" : "No window differs by more than chance explains.",
      cells: { x, y, values: values.map((value, k) => (value === null ? null : 10 ** (value - medians[k % rows]))), colour: (ratio, j) => ratioColour(within(ratio, j) ? 1 : ratio) },
      x: { label: `time, middle of a window of ${text(length / timeUnit(2 * length).size)} ${timeUnit(2 * length).text} [${unit.text}]`, unit, log: false, range: [x[0], x[x.length - 1]] },
      y: { label: "averaging time τ [s]", log: true, range: [y[0], y[rows]] },
    }];
  },
  readout(point, sensor, state, { cells, x }) {
    const rows = cells.y.length - 1;
    const i = cells.x.findLastIndex((edge) => edge <= point.x), j = cells.y.findLastIndex((edge) => edge <= point.y);
    const value = i >= 0 && i < cells.x.length - 1 && j >= 0 && j < rows ? cells.values[i * rows + j] : null;
    return [make("b", {}, `t = ${text(point.x)} ${x.unit.text}, τ = ${text(point.y)} s`), make("span", {}, value === null ? "missing" : `${text(value)} times the median`)];
  },
};

function median(values) {
  const ordered = [...values].sort((a, b) => a - b), half = ordered.length >> 1;
  return ordered.length % 2 ? ordered[half] : (ordered[half - 1] + ordered[half]) / 2;
}

/** Blue below the median, red above: the same for any colour vision by lightness on either side of a light middle. */
function ratioColour(ratio) {
  const share = Math.max(-1, Math.min(1, Math.log(ratio) / Math.log(MOST)));
  const end = share < 0 ? [33, 102, 172] : [178, 54, 30], middle = [244, 243, 240];
  const mixed = middle.map((value, k) => Math.round(value + (end[k] - value) * Math.abs(share)));
  return `rgb(${mixed.join(" ")})`;
}

function mapLegend() {
  const bar = make("span", { className: "bar" });
  bar.style.cssText = `display:inline-block;width:7rem;height:.8rem;border-radius:.2rem;background:linear-gradient(to right, ${[1 / MOST, 0.75, 1, 1.33, MOST].map(ratioColour).join(", ")})`;
  return make("span", { style: "display:inline-flex;gap:.4rem;align-items:center" }, `½`, bar, `2 times the median`);
}
