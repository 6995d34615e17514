// Time series of the record, or of a part: the smallest and the largest sample of each interval.

import { make, setContent, content } from "./page.js";
import { drop, fill, figures } from "./frame.js";
import { envelope } from "./api.js";
import { partControls } from "./parts.js";
import { seriesKind } from "./kinds.js";
import { errorBox } from "./dom.js";
import { sensorName } from "./channels.js";
import { session } from "./session.js";

const WIDTH = 1200; // number of intervals of a time series

/** Convert an envelope to the data of charts, for time series before an analysis. */
function asCharts(drawn) {
  const sensors = new Map(), channels = {};
  for (const [name, { t, low, high, unit }] of Object.entries(drawn.channels)) {
    const sensor = sensorName(name);
    if (!sensors.has(sensor)) sensors.set(sensor, { name: sensor, title: { gyro: "Gyroscope", accel: "Accelerometer" }[sensor] ?? sensor, units: [{ text: unit, factor: 1 }], channels: [] });
    sensors.get(sensor).channels.push(name);
    const step = t.length > 1 ? t[1] - t[0] : 1, from = t.length ? t[0] - step / 2 : 0;
    channels[name] = { series: { from, duration: step * t.length, bins: t.length, low, high, outside: [] } };
  }
  return { sensors: [...sensors.values()], channels };
}

/** Draw the record of a file before its analysis. */
export async function showRecord(place, source, options, signal) {
  let drawn;
  try {
    drawn = await envelope(source, options, { width: WIDTH }, signal);
  } catch (error) {
    if (error.name !== "AbortError") place.replaceChildren(errorBox(error));
    return;
  }
  if (signal.aborted) return;
  drop(place);
  setContent(asCharts(drawn));
  place.replaceChildren(...seriesSection());
}

/** Figures of the time series, with the controls of the chosen part. */
export function seriesSection() {
  const charts = make("div", { className: "charts" });
  const controls = partControls((from, to) => zoomSeries(charts, from, to));
  const kind = seriesKind((from, to) => controls.choose(from, to));
  fill(charts, { ...kind, drawn: (made) => { kind.drawn(made); for (const plot of made.drawn) plot.reset = () => showWhole(charts); } });
  return [controls.element, charts];
}

const seriesFigures = (charts) => [...figures].filter((figure) => charts.contains(figure.element));
const PARTS = ["from", "duration", "bins", "low", "high"]; // keys of a series that a finer envelope replaces

/** Zoom all time series to a part: at once with the intervals of the whole record, then with finer ones. */
async function zoomSeries(charts, from, to) {
  const zoomIn = () => { for (const figure of seriesFigures(charts)) for (const { u, described } of figure.drawn) u.setScale("x", { min: from / described.x.unit.size, max: to / described.x.unit.size }); };
  zoomIn();
  const data = content, { source, options } = session;
  if (!source) return;
  let drawn;
  try {
    drawn = await envelope(source, options, { from_s: from, to_s: to, width: WIDTH });
  } catch { /* the intervals of the whole record stay */ return; }
  if (content !== data || !charts.isConnected) return;
  const finer = asCharts(drawn).channels;
  for (const [name, { series: part }] of Object.entries(finer)) {
    const series = content.channels[name]?.series;
    if (!series || !part.bins) continue;
    series.whole ??= { ...Object.fromEntries(PARTS.map((key) => [key, series[key]])), end: series.end ?? series.from + series.duration };
    Object.assign(series, { ...Object.fromEntries(PARTS.map((key) => [key, part[key]])), end: series.whole.end });
  }
  for (const figure of seriesFigures(charts)) figure.draw();
  zoomIn();
}

/** Show the whole record again. */
function showWhole(charts) {
  for (const { series } of Object.values(content.channels)) if (series?.whole) { Object.assign(series, series.whole); delete series.whole; }
  for (const figure of seriesFigures(charts)) { figure.clear(); figure.draw(); }
}

export const hasSeries = () => Object.values(content?.channels ?? {}).some((channel) => channel.series);
