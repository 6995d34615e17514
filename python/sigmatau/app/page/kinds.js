// The charts of the report, linked: the point under the pointer is marked in the others, and a drag over time chooses a part.

import { make } from "./page.js";
import { deviation } from "./deviation.js";
import { density } from "./density.js";
import { residuals } from "./residuals.js";
import { series } from "./series.js";
import { map } from "./map.js";
import { AT_PEAK, follow, showPoint } from "./overlays.js";
import { text } from "./numbers.js";

const HEIGHT = 285; // height of an Allan deviation that a laptop shows together with the coefficients above it [pixels]

/** Link the plots of a kind of chart by the axis that they share with others: "tau", "f" or "t". */
function linked(kind, axis, changes = {}, height = {}) {
  return {
    ...kind,
    describe: (sensor, state) => kind.describe(sensor, state).map((described) => Object.assign(described, { link: axis }, height)),
    onread: (point, made, described) => {
      const value = point === null ? null : axis === "f" ? AT_PEAK / point.x : point.x * (described.x.unit?.size ?? 1);
      showPoint(axis === "f" ? "tau" : axis, value, described);
    },
    drawn: follow,
    ...changes,
  };
}

export const linkedKinds = {
  deviation: linked(deviation, "tau", { height: () => HEIGHT }, { height: HEIGHT }),
  density: linked(density, "f", {
    readout: (point, sensor, state) => [...density.readout(point, sensor, state), make("span", {}, `marked in the Allan deviation: τ = 0.371/f = ${text(AT_PEAK / point.x)} s`)],
  }),
  residuals: linked(residuals, "tau"),
  map: linked(map, "t"),
};

/** Time series of the last minutes of a live record. */
export const liveSeries = { ...series, options: [], hint: "Point to read, drag to zoom, double-click for all." };

/** Time series on which a drag chooses a part: `choose(from, to)` in seconds. */
export function seriesKind(choose) {
  return linked(series, "t", {
    hint: "Drag to choose a part, + and − to zoom, double-click for all.",
    onselect: (from, to, { x }) => choose(from * x.unit.size, to * x.unit.size),
  });
}
