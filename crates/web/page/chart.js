// A chart on a canvas that is drawn anew in each frame: logarithmic or linear axes, lines, points with intervals, a cursor.

import { colour, make } from "./page.js";
import { linearTicks, logTicks, tickTexts } from "./numbers.js";

const WIDE_MARGIN = 62, TITLE_WIDTH = 30; // left of the axis [px]
const FONT = "12px system-ui, sans-serif";
const charts = [];
let palette = {}, palettes = 0;

const NAMES = ["ink", "soft", "grid", "line", "raised", "guide", "link", "poor", "axis-0", "axis-1", "axis-2", "axis-3", "axis-4", "record", "process"];

/** Read the colours of the style sheet again, and draw all charts. */
export function recolourCharts() {
  palette = Object.fromEntries(NAMES.map((name) => [name, colour(name)]));
  palettes++;
  for (const chart of charts) chart.draw();
}

export const paint = (name) => palette[name] ?? name;

/** Set a text if it is another one: the layout of the page stays valid. */
export function setText(element, words) {
  if (element.textContent !== words) element.textContent = words;
}

/** Whole decades around positive values, or a linear range that ends at fifths of a power of ten: it seldom changes. */
export function rangeAround(values, log, least = 1) {
  let low = Infinity, high = -Infinity;
  for (const value of values) {
    if (!Number.isFinite(value) || (log && value <= 0)) continue;
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  if (low > high) return log ? [0.1, 10] : [-1, 1];
  if (!log) {
    const room = 0.02 * (high - low) || 1, step = 10 ** Math.floor(Math.log10(high - low + 2 * room)) / 5;
    return [step * Math.floor((low - room) / step), step * Math.ceil((high + room) / step)];
  }
  const ends = [Math.floor(2 * Math.log10(low)) / 2, Math.ceil(2 * Math.log10(high)) / 2];
  while (ends[1] - ends[0] < least) ends[1] += 0.5;
  return ends.map((end) => 10 ** end);
}

/**
 * A chart in a place. `about`: title, labels of the axes, whether they are logarithmic, height, and what is said of a point
 * of its axis. `content` of `set`: x and y ranges, lines, points, stretches (smallest and largest sample by column), marks, a note
 * for a chart without a line.
 */
export function chartIn(place, about) {
  const canvas = make("canvas", { tabIndex: 0, role: "img" });
  const readout = make("p", { className: "readout", ariaLive: "off" });
  const frame = make("canvas", { className: "frame", ariaHidden: "true" }); // axes, below; drawn when they change
  place.append(frame, canvas, readout);
  const onFrame = frame.getContext("2d"), context = canvas.getContext("2d");
  const MARGIN = { left: WIDE_MARGIN, right: 12, top: 10, bottom: 40 };
  let content = { x: [0.1, 10], y: [0.1, 10] }, width = 0, height = 0, cursor = null, scale = 0, framed = "";

  const to = (log) => (log ? Math.log : Number), back = (log) => (log ? Math.exp : Number);
  const along = (value, [low, high], log) => (to(log)(value) - to(log)(low)) / (to(log)(high) - to(log)(low));
  const toX = (value) => MARGIN.left + (width - MARGIN.left - MARGIN.right) * along(value, content.x, about.x.log);
  const toY = (value) => height - MARGIN.bottom - (height - MARGIN.top - MARGIN.bottom) * along(value, content.y, about.y.log);
  const valueAt = (share, [low, high], log) => back(log)(to(log)(low) + share * (to(log)(high) - to(log)(low)));
  const fromX = (x) => valueAt((x - MARGIN.left) / (width - MARGIN.left - MARGIN.right), content.x, about.x.log);
  const fromY = (y) => valueAt((height - MARGIN.bottom - y) / (height - MARGIN.top - MARGIN.bottom), content.y, about.y.log);

  function axes() {
    const key = [content.x, content.y, about.x.label(), about.y.label(), width, height, scale, palettes].join();
    if (key === framed) return;
    framed = key;
    onFrame.setTransform(scale, 0, 0, scale, 0, 0);
    onFrame.clearRect(0, 0, width, height);
    onFrame.font = FONT;
    onFrame.lineWidth = 1;
    const xs = about.x.log ? logTicks(...content.x) : linearTicks(...content.x, Math.max(3, Math.round(width / 110)));
    const ys = about.y.log ? logTicks(...content.y) : linearTicks(...content.y, Math.max(3, Math.round(height / 60)));
    const texts = tickTexts(ys, about.y.log);
    MARGIN.left = Math.max(WIDE_MARGIN, TITLE_WIDTH + Math.max(...texts.map((words) => onFrame.measureText(words).width)));
    onFrame.strokeStyle = paint("grid");
    onFrame.fillStyle = paint("soft");
    onFrame.beginPath();
    for (const x of xs) { onFrame.moveTo(toX(x), MARGIN.top); onFrame.lineTo(toX(x), height - MARGIN.bottom); }
    for (const y of ys) { onFrame.moveTo(MARGIN.left, toY(y)); onFrame.lineTo(width - MARGIN.right, toY(y)); }
    onFrame.stroke();
    onFrame.textAlign = "center";
    const every = Math.ceil((xs.length * 48) / (width - MARGIN.left));
    tickTexts(xs, about.x.log).forEach((text, k) => { if (k % every === 0) onFrame.fillText(text, toX(xs[k]), height - MARGIN.bottom + 16); });
    onFrame.textAlign = "right";
    texts.forEach((text, k) => onFrame.fillText(text, MARGIN.left - 6, toY(ys[k]) + 4));
    onFrame.textAlign = "center";
    onFrame.fillText(about.x.label(), (MARGIN.left + width - MARGIN.right) / 2, height - 6);
    onFrame.save();
    onFrame.translate(12, (MARGIN.top + height - MARGIN.bottom) / 2);
    onFrame.rotate(-Math.PI / 2);
    onFrame.fillText(about.y.label(), 0, 0);
    onFrame.restore();
  }

  function stroke({ x, y, colour: name, width: thick = 2, dash = [] }) {
    context.strokeStyle = paint(name);
    context.lineWidth = thick;
    context.setLineDash(dash);
    context.beginPath();
    let pen = false;
    for (let k = 0; k < x.length; k++) {
      if (!(y[k] > 0) && about.y.log) { pen = false; continue; }
      if (pen) context.lineTo(toX(x[k]), toY(y[k]));
      else context.moveTo(toX(x[k]), toY(y[k]));
      pen = true;
    }
    context.stroke();
    context.setLineDash([]);
  }

  function dots({ x, y, low, high, colour: name, size = 2.6 }) {
    context.strokeStyle = context.fillStyle = paint(name);
    context.lineWidth = 1.4;
    context.beginPath();
    for (let k = 0; low && k < x.length; k++) { context.moveTo(toX(x[k]), toY(low[k])); context.lineTo(toX(x[k]), toY(high[k])); }
    context.stroke();
    context.beginPath();
    for (let k = 0; k < x.length; k++) { context.moveTo(toX(x[k]) + size, toY(y[k])); context.arc(toX(x[k]), toY(y[k]), size, 0, 7); }
    context.fill();
  }

  /** Bars from the smallest to the largest sample, on whole pixels: many times faster than lines. */
  function stretches({ values, span, colour: name }) {
    const count = values.length / 2, snapped = (x) => Math.round(x * scale) / scale;
    context.fillStyle = paint(name);
    for (let k = 0; k < count; k++) {
      const left = snapped(toX((k / count) * span)), right = snapped(toX(((k + 1) / count) * span));
      const top = toY(values[2 * k + 1]), bottom = toY(values[2 * k]);
      context.fillRect(left, snapped(top), Math.max(right - left, 1 / scale), Math.max(snapped(bottom - top), 1 / scale));
    }
  }

  function marks() {
    if (!content.marks?.length) return;
    context.font = `600 ${FONT}`;
    const boxes = []; // of the texts: left, right, base
    for (const { text, colour: name, align = "left", below = false, ring = false, ...mark } of content.marks) {
      const span = context.measureText(text).width;
      const boxAt = ([x, y]) => { const start = toX(x) + (align === "left" ? 8 : -8 - span); return [start, start + span, toY(y) + (below ? 15 : -6)]; };
      const isFree = ([start, end, base]) => boxes.every(([a, b, c]) => end < a - 4 || start > b + 4 || Math.abs(base - c) > 15);
      const places = mark.places ?? [[mark.x, mark.y]], [x, y] = places.find((each) => isFree(boxAt(each))) ?? places[0];
      if (x < content.x[0] || x > content.x[1] || y < content.y[0] || y > content.y[1]) continue;
      context.fillStyle = context.strokeStyle = paint(name);
      if (ring) {
        context.lineWidth = 2;
        context.beginPath();
        context.arc(toX(x), toY(y), 5, 0, 7);
        context.stroke();
      }
      const box = boxAt([x, y]), [left, , base] = box;
      boxes.push(box);
      context.textAlign = "left";
      context.strokeStyle = paint("raised");
      context.lineWidth = 3;
      context.strokeText(text, left, base);
      context.fillText(text, left, base);
    }
  }

  /** Lines of text in the middle. */
  function note(lines) {
    context.font = FONT;
    context.fillStyle = paint("ink");
    context.textAlign = "center";
    lines.forEach((words, k) => context.fillText(words, (MARGIN.left + width - MARGIN.right) / 2, height / 2 + 18 * (k - lines.length / 2)));
  }

  function draw() {
    if (!width) return;
    context.setTransform(scale, 0, 0, scale, 0, 0);
    context.clearRect(0, 0, width, height);
    axes();
    context.save();
    context.beginPath();
    context.rect(MARGIN.left, MARGIN.top, width - MARGIN.left - MARGIN.right, height - MARGIN.top - MARGIN.bottom);
    context.clip();
    if (content.stretches) stretches(content.stretches);
    for (const line of content.lines ?? []) stroke(line);
    if (content.note) note(content.note);
    for (const points of content.points ?? []) dots(points);
    marks();
    if (cursor !== null) {
      context.strokeStyle = paint("soft");
      context.lineWidth = 1;
      context.beginPath();
      context.moveTo(toX(cursor), MARGIN.top);
      context.lineTo(toX(cursor), height - MARGIN.bottom);
      context.stroke();
    }
    context.restore();
    setText(readout, cursor === null ? about.hint : about.at(cursor));
    onplaced();
  }

  function fit() {
    const ratio = devicePixelRatio || 1, { clientWidth, clientHeight } = canvas;
    if (clientWidth === width && clientHeight === height && scale === ratio) return;
    [width, height, scale] = [clientWidth, clientHeight, ratio];
    framed = ""; // a canvas of another size is empty
    for (const each of [frame, canvas]) {
      each.width = Math.round(width * scale);
      each.height = Math.round(height * scale);
    }
    draw();
  }

  function place_(value) {
    cursor = value === null ? null : Math.min(Math.max(value, content.x[0]), content.x[1]);
    draw();
  }
  canvas.addEventListener("pointermove", (event) => place_(fromX(event.offsetX)));
  canvas.addEventListener("pointerleave", () => place_(null));
  canvas.addEventListener("blur", () => place_(null));
  canvas.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (event.key === "Escape") place_(null);
    else if (step) {
      const share = cursor === null ? 0.5 : along(cursor, content.x, about.x.log);
      place_(valueAt(share + step * (event.shiftKey ? 0.1 : 0.01), content.x, about.x.log));
      event.preventDefault();
    }
  });
  canvas.setAttribute("aria-label", `${about.title}. Left and right arrow keys move the cursor.`);
  let onplaced = () => {};
  new ResizeObserver(fit).observe(canvas);
  const chart = {
    canvas, draw, toX, toY, fromX, fromY,
    set(next) { content = next; draw(); },
    range: () => content,
    width: () => width,
    placed(action) { onplaced = action; },
  };
  charts.push(chart);
  return chart;
}
