// The clicked points of a figure: a plain state that is never changed in place, its coordinates, and the request made of it.

import { parsed } from "./dom.js";

export const TICKS = ["x1", "x2", "y1", "y2"];
export const MIN_POINTS = 10; // smallest number of points of a curve: 8 are fitted, and the last ones are above a third of the shortest record
const TOUCH = 3; // error of a finger over that of a mouse
const SHARPNESS = 0.5; // smallest error of a click on a picture of pixels [pixels]
const LEVELLED = 1.25; // error of a picture that was turned over that of a straight one: the angle has an error too
const MOST_TURN = 45; // largest turn to each side [degrees]
const USUAL = { gyro: "deg/h", accel: "ug", signal: "" };

/** State of a figure. A place is [x, y, error] in pixels of the picture; `source` is {path} or {file}; `size` is that of the picture that was clicked, null before. */
export function newFigure(source, name) {
  return {
    source, name, page: null, size: null, ticks: Object.fromEntries(TICKS.map((key) => [key, { place: null, value: "" }])), curves: [{ name: "", points: [] }],
    kind: "gyro", unit: USUAL.gyro, content: "deviation", linear: "", error: "", rate: "", hours: "", turn: 0,
  };
}

/** The state of an address, in which any part may be damaged; null if it names no file. */
export function figureFrom(stated) {
  const isFile = typeof stated?.source?.path === "string" || typeof stated?.source?.file === "string";
  if (!isFile) return null;
  const figure = newFigure(stated.source, String(stated.name ?? "figure"));
  const place = (value) => (Array.isArray(value) && value.length === 3 && value.every(Number.isFinite) ? value : null);
  for (const key of TICKS) figure.ticks[key] = { place: place(stated.ticks?.[key]?.place), value: String(stated.ticks?.[key]?.value ?? "") };
  if (Array.isArray(stated.curves) && stated.curves.length) figure.curves = stated.curves.map((curve) => ({ name: String(curve?.name ?? ""), points: Array.isArray(curve?.points) ? curve.points.filter(place) : [] }));
  for (const key of ["kind", "unit", "content", "linear", "error", "rate", "hours"]) if (typeof stated[key] === "string") figure[key] = stated[key];
  if (!(figure.kind in USUAL)) figure.kind = "gyro";
  if (Number.isInteger(stated.page)) figure.page = stated.page;
  if (Array.isArray(stated.size) && stated.size.length === 2 && stated.size.every(Number.isFinite)) figure.size = stated.size;
  figure.turn = boundedTurn(Number(stated.turn) || 0);
  return figure;
}

/** A changed copy of a state. */
export function changed(figure, change) {
  const copy = structuredClone(figure);
  change(copy);
  return copy;
}

export const boundedTurn = (turn) => Math.min(Math.max(Math.round(turn * 100) / 100, -MOST_TURN), MOST_TURN);

/** Choose the kind of the sensor, with its usual unit. */
export const withKind = (figure, kind) => changed(figure, (copy) => { copy.kind = kind; copy.unit = USUAL[kind]; });

/** The next part to click: "x1" to "y2" without a place, otherwise the curve "c0", "c1" … */
export const nextTarget = (figure) => TICKS.find((key) => !figure.ticks[key].place) ?? `c${figure.curves.length - 1}`;

export const curveIndex = (target) => Number(target.slice(1));
export const isCurve = (target) => target.startsWith("c");

/** The name of a curve for display. */
export const curveName = (figure, k) => figure.curves[k].name || (figure.curves.length > 1 ? `curve ${k + 1}` : figure.kind);

/** The place of a mark: a tick "x1", or the point "c0:3" of a curve. */
export function placeOf(figure, key) {
  if (!isCurve(key)) return figure.ticks[key].place;
  const [curve, point] = key.slice(1).split(":").map(Number);
  return figure.curves[curve]?.points[point] ?? null;
}

export function withPlace(figure, key, place) {
  return changed(figure, (copy) => {
    if (!isCurve(key)) copy.ticks[key].place = place;
    else {
      const [curve, point] = key.slice(1).split(":").map(Number);
      copy.curves[curve].points[point] = place;
    }
  });
}

export function without(figure, key) {
  return changed(figure, (copy) => {
    if (!isCurve(key)) copy.ticks[key].place = null;
    else {
      const [curve, point] = key.slice(1).split(":").map(Number);
      copy.curves[curve].points.splice(point, 1);
    }
  });
}

/** Error of a click: a pixel of the screen at the zoom of the picture, or that of a finger. [pixels of the picture] */
export const clickError = (zoom, isTouch) => Number(((isTouch ? TOUCH : 1) / (zoom * (globalThis.visualViewport?.scale ?? 1))).toPrecision(3));

/** Default of the clicking error: the largest of all clicks. [pixels of the picture] */
export function defaultError(figure, { isVector }) {
  const places = [...TICKS.map((key) => figure.ticks[key].place), ...figure.curves.flatMap(({ points }) => points)].filter(Boolean);
  const largest = Math.max(isVector ? 0 : SHARPNESS, ...places.map(([, , error]) => error));
  return Number((largest * (figure.turn ? LEVELLED : 1)).toPrecision(2));
}

/** Turn a place about the middle of the picture, as it is displayed. */
export function turnedPlace([x, y], turn, { width, height }) {
  const [c, s] = [Math.cos((turn * Math.PI) / 180), Math.sin((turn * Math.PI) / 180)], [dx, dy] = [x - width / 2, y - height / 2];
  return [width / 2 + c * dx - s * dy, height / 2 + s * dx + c * dy];
}

/** The turn that makes the ticks of the two axes level and upright, those of the longer axis with more weight; null without ticks. */
export function levelTurn({ ticks }) {
  let sum = 0, weight = 0;
  for (const [first, second, upright] of [["x1", "x2", 0], ["y1", "y2", Math.PI / 2]]) {
    const [a, b] = [ticks[first].place, ticks[second].place];
    if (!a || !b) continue;
    const [dx, dy] = [b[0] - a[0], b[1] - a[1]], angle = Math.atan2(dy, dx) + upright;
    sum += (dx * dx + dy * dy) * Math.atan2(Math.sin(angle), Math.cos(angle));
    weight += dx * dx + dy * dy;
  }
  return weight ? boundedTurn((-180 / Math.PI) * (sum / weight)) : null;
}

/** What is missing before the curves can be computed, in words; empty if nothing is. */
export function missing(figure) {
  const unplaced = TICKS.filter((key) => !figure.ticks[key].place), unnamed = TICKS.filter((key) => !figure.ticks[key].value.trim());
  if (unplaced.length) return `Ticks to click: ${unplaced.map(tickName).join(", ")}.`;
  if (unnamed.length) return `Values to type: ${unnamed.map(tickName).join(", ")}.`;
  const short = figure.curves.findIndex(({ points }, k) => points.length < MIN_POINTS && (points.length || !k));
  if (short >= 0) return `Points of ${curveName(figure, short)}: ${figure.curves[short].points.length} of ${MIN_POINTS} or more.`;
  return "";
}

export const tickName = (key) => `${key[0]}${key[1] === "1" ? "₁" : "₂"}`;

/** The request for the curves. A field that is not a number is sent as typed, for the message of the server. */
export function requestBody(figure, picture) {
  const number = (text) => (text.trim() ? parsed(text) ?? text : null);
  const coordinates = (place) => turnedPlace(place, figure.turn, picture);
  const axis = (way, k) => [`${way}1`, `${way}2`].map((key) => [coordinates(figure.ticks[key].place)[k], figure.ticks[key].value]);
  return {
    curves: figure.curves.filter(({ points }) => points.length).map(({ name, points }) => ({ name: name.trim() || (figure.kind === "signal" ? "signal" : ""), points: points.map(coordinates) })),
    x_axis: axis("x", 0), y_axis: axis("y", 1), linear: figure.linear || null, unit: figure.unit, content: figure.content,
    point_error: number(figure.error) ?? defaultError(figure, picture), rate: number(figure.rate), hours: number(figure.hours),
  };
}
