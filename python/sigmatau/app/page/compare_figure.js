// Figure of the results, datasheets and models that are switched on. Colour shows the axis, the dash shows the result.

import { colour, make, setContent } from "./page.js";
import { drop, fill, shortName } from "./frame.js";
import { deviation } from "./deviation.js";
import { shownResults, shownSpecifications } from "./comparison.js";

const DASHES = [undefined, [7, 3], [2, 3], [9, 3, 2, 3], [4, 4], [1, 5]];
const WIDE_DASHES = [[10, 4], [3, 3], [12, 3, 3, 3]]; // dashes of datasheets and models, whose lines are wider
const chooseDash = (list, number) => list[number % list.length];

/** Sample of the line of a result or a specification, for the legend. */
export function swatch(each) {
  const canvas = make("canvas", { width: 60, height: 8, ariaHidden: "true", className: "dash" }), pen = canvas.getContext("2d");
  pen.strokeStyle = colour("ink");
  pen.lineWidth = each.number ? 2 : 4;
  pen.setLineDash((each.number ? chooseDash(DASHES, each.number - 1) : chooseDash(WIDE_DASHES, each.order)) ?? []);
  pen.beginPath();
  pen.moveTo(0, 4);
  pen.lineTo(60, 4);
  pen.stroke();
  return canvas;
}

/** Draw a figure for each sensor. */
export function drawComparison(place) {
  drop(place);
  place.replaceChildren();
  const drawn = [...shownResults(), ...shownSpecifications()];
  if (!drawn.length) return place.append(make("p", { className: "none" }, "All curves are switched off."));
  const merged = mergedCharts(drawn);
  setContent(merged);
  fill(place, {
    ...deviation,
    id: "comparison",
    options: [{ name: "bands", text: "Intervals", on: () => false }, { name: "guides", text: "Slopes", on: () => false }],
    describe(sensor, state) {
      const parts = shownResults().map((result) => resultLines(result, sensor, state));
      setContent(merged);
      const lines = parts.flatMap(([, each]) => each);
      const limits = lines.length ? [Math.min(...lines.map(({ x }) => x[0])), Math.max(...lines.map(({ x }) => x[x.length - 1]))] : null;
      lines.push(...shownSpecifications().flatMap((each) => specificationLines(each, sensor, state, limits)));
      if (!lines.length) return [];
      const described = parts.map(([part]) => part).find(Boolean) ?? axesOnly(sensor, state);
      return [{ ...described, guides: state.guides, lines }];
    },
  });
  return undefined;
}

/** Merge the sensors and channels of all charts; a channel that several charts have is that of the first. */
function mergedCharts(drawn) {
  const sensors = new Map(), channels = {};
  for (const { charts } of drawn) for (const sensor of charts.sensors) {
    if (!sensors.has(sensor.name)) sensors.set(sensor.name, { ...sensor, channels: [] });
    const { channels: names } = sensors.get(sensor.name);
    names.push(...sensor.channels.filter((name) => !names.includes(name)));
    for (const name of sensor.channels) channels[name] ??= charts.channels[name];
  }
  return { sensors: [...sensors.values()], channels };
}

/** Describe a figure of a single result, and its lines with the dash and the number of the result. */
function resultLines({ number, charts }, sensor, state) {
  const names = sensor.channels.filter((name) => charts.channels[name]?.deviation);
  const alone = { ...sensor, channels: names };
  setContent({ sensors: [alone], channels: charts.channels });
  const [described] = deviation.describe(alone, { ...state, unit: state.unit, seen: state.seen, model: false, parts: false });
  const lines = (described?.lines ?? []).map((line) => {
    const place = sensor.channels.findIndex((channel) => shortName(sensor, channel) === line.name);
    return { ...line, name: `${line.name} (${number})`, dash: chooseDash(DASHES, number - 1), points: false, colour: () => colour(`axis-${Math.max(place, 0) % 6}`) };
  });
  return [described, lines];
}

/** Curves of a datasheet or a model within the averaging times of the results; axes with equal curves share a line. */
function specificationLines({ name, charts, order }, sensor, state, limits) {
  const axes = new Map();
  for (const channel of sensor.channels) {
    const curve = charts.channels[channel]?.deviation;
    if (!curve || !state.seen.has(channel)) continue;
    const key = curve.adev.join();
    if (!axes.has(key)) axes.set(key, { curve, names: [] });
    axes.get(key).names.push(shortName(sensor, channel));
  }
  return [...axes.values()].map(({ curve: { tau, adev }, names }) => {
    const label = axes.size > 1 ? `${name} ${names.join(" ")}` : name;
    const inside = tau.map((_, place) => place).filter((place) => !limits || (tau[place] >= limits[0] * 0.8 && tau[place] <= limits[1] * 1.25));
    return { name: label, x: inside.map((place) => tau[place]), y: inside.map((place) => adev[place] / state.unit.factor), colour: () => colour("ink"), width: 2.4, dash: chooseDash(WIDE_DASHES, order), read: true, tag: label };
  });
}

function axesOnly(sensor, state) {
  return {
    title: `Allan deviation, ${sensor.title}`, height: 360,
    x: { label: "averaging time τ [s]", log: true }, y: { label: `Allan deviation σ(τ) [${state.unit.text}]`, log: true },
  };
}
