// One plot from a description, by uPlot.
//
// A description has axes `x` and `y`, and what is drawn:
//   lines   [{name, x, y, low, high, colour, dash, width, points, read}]  low and high make a band; read: in the readout
//           bars: true if low and high are bars at the points
//           interval {low, high}: what is read and saved of a band that is drawn in part
//   spans   [[from, to]] of x that are shaded
//           tag: its name, written beside its steeper end
//   marks   [{x, colour, text}] triangles on the x axis
//   guides  true: lines of the slopes -1, -1/2, 1/2, 1 through the point that is read
//   cells   {x, y, values, colour, text} a map; x and y are edges, values by rows of x
//   note    a text in the middle of the plot
//   height  in pixels
// An axis has {label, log, range}; also `name` for a label that is not drawn, `least` characters of its ticks, and `places`,
// the names of 1, 2, 3 ….

import { colour } from "./page.js";
import { linearTicks, logTicks, rangeOf, tickTexts } from "./numbers.js";

export const plots = new Set();
let onPaper = false; // while the page is printed, widths are those of the paper

export function setPaper(is) {
  onPaper = is;
}

export function draw(place, described) {
  const columns = described.lines.map((line) => tableOf(line));
  const data = columns.length ? uPlot.join(columns) : [[described.x.range[0], described.x.range[1]]];
  const series = [{}], bands = [];
  for (const line of described.lines) {
    if (line.y) series.push(styled(line, line.width ?? 1.6, line.points));
    if (line.low) {
      if (!line.bars) bands.push({ series: [series.length + 1, series.length], fill: () => faded(line.colour(), line.y ? 0.18 : 0.75) });
      const edge = line.y ? 0 : 0.8;
      series.push(styled(line, edge), styled(line, edge));
    }
  }
  let held = false; // while a range is dragged, the cursor is where the mouse is
  const options = {
    width: Math.max(place.clientWidth, 200),
    height: described.height,
    legend: { show: false },
    padding: [8, 12, 0, 0],
    scales: { x: scaleOf(described, "x"), y: scaleOf(described, "y") },
    axes: [axisOf(described, "x"), axisOf(described, "y")],
    series, bands,
    cursor: { drag: { x: true, y: true, uni: 30, setScale: false }, points: { show: false }, y: !described.cells, move: (u, left, top) => (held ? [left, top] : snapped(u, described, left, top)) },
    hooks: {
      drawClear: [(u) => under(u, described)],
      draw: [(u) => over(u, described)],
      setSelect: [(u) => select(u, described)],
      setCursor: [(u) => described.onread?.(u.cursor.left < 0 ? null : nearest(u, described))],
    },
  };
  const u = new uPlot(options, data, place);
  const made = { u, place, described, reset: () => reset(u, described) };
  keyboard(made);
  plots.add(made);
  new ResizeObserver(() => !onPaper && u.width !== place.clientWidth && place.clientWidth && u.setSize({ width: place.clientWidth, height: described.height })).observe(place);
  u.over.addEventListener("mousedown", () => { held = true; addEventListener("mouseup", () => { held = false; }, { once: true, capture: true }); }, true);
  // A tap has no movement that uPlot follows.
  u.over.addEventListener("click", (event) => u.setCursor({ left: event.offsetX, top: event.offsetY }));
  u.over.addEventListener("dblclick", (event) => { event.stopImmediatePropagation(); made.reset(); }, true);
  return made;
}

function tableOf(line) {
  const table = [line.x];
  if (line.y) table.push(line.y);
  if (line.low) table.push(line.low, line.high);
  return table;
}

function styled(line, width, points = false) {
  return {
    label: line.name, stroke: () => line.colour(), width, dash: line.dash, spanGaps: line.gaps !== true,
    points: points ? { show: true, size: 4.5, fill: () => line.colour(), width: 0 } : { show: false },
  };
}

/** A colour with a share of opacity; canvases of older browsers know no color-mix. */
function faded(css, alpha) {
  if (css.startsWith("hsl")) return css.replace(")", ` / ${alpha})`);
  return css + Math.round(alpha * 255).toString(16).padStart(2, "0");
}

/** Values of a description along an axis, for its range. */
function valuesOf(described, axis) {
  const found = [];
  for (const line of described.lines) {
    if (axis === "x") found.push(line.x);
    else if (line.framed !== false) for (const edge of [line.y, line.low, line.high]) if (edge) found.push(edge);
  }
  return found.flat();
}

export function fullRange(described, axis) {
  return described[axis].range ?? rangeOf(valuesOf(described, axis), described[axis].log);
}

function scaleOf(described, axis) {
  const [low, high] = fullRange(described, axis);
  const log = described[axis].log;
  return { time: false, distr: log ? 3 : 1, log: 10, auto: false, min: low, max: high, range: (_, a, b) => [a ?? low, b ?? high] };
}

function axisOf(described, axis) {
  const { label, log, least = 3, places } = described[axis];
  const ticks = (u, _, low, high) => (log ? logTicks(low, high) : linearTicks(low, high, axis === "x" ? 6 : yTicks(described)));
  return {
    label: label || undefined, labelSize: label ? 24 : 0, labelGap: 0, size: axis === "x" ? 34 : (u, values) => 18 + 7.2 * Math.max(least, ...(values ?? []).map((v) => v.length)),
    font: "12px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif",
    stroke: () => colour("soft"), grid: { stroke: () => colour("grid"), width: 1 }, ticks: { stroke: () => colour("line"), width: 1, size: 5 },
    splits: ticks, filter: (_, splits) => splits, values: (_, splits) => (places ? splits.map((place) => places[place - 1] ?? "") : tickTexts(splits, log)),
  };
}

export function yTicks({ height }) {
  return Math.max(4, Math.round(height / 45));
}

function reset(u, described) {
  u.batch(() => {
    for (const axis of ["x", "y"]) {
      const [min, max] = fullRange(described, axis);
      u.setScale(axis, { min, max });
    }
  });
}

/** What lies under the lines: shaded spans, and the cells of a map. */
function under(u, { spans, cells }) {
  const { ctx, bbox } = u;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  if (spans) {
    ctx.fillStyle = colour("outside");
    for (const [from, to] of spans) {
      const left = u.valToPos(from, "x", true), right = u.valToPos(to, "x", true);
      ctx.fillRect(left, bbox.top, Math.max(right - left, devicePixelRatio), bbox.height);
    }
  }
  if (cells) {
    eachCell(cells, (x0, x1, y0, y1, value, row) => {
      const left = u.valToPos(x0, "x", true), right = u.valToPos(x1, "x", true);
      const top = u.valToPos(y1, "y", true), bottom = u.valToPos(y0, "y", true);
      ctx.fillStyle = cells.colour(value, row);
      ctx.fillRect(Math.floor(left), Math.floor(top), Math.ceil(right) - Math.floor(left), Math.ceil(bottom) - Math.floor(top));
    });
  }
  ctx.restore();
}

/** The intervals of the points of a line. */
function bars(u, { x, low, high, colour: paint }) {
  const { ctx, bbox } = u;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  ctx.beginPath();
  x.forEach((value, k) => {
    if (low[k] === null || high[k] === null) return;
    const across = u.valToPos(value, "x", true);
    ctx.moveTo(across, u.valToPos(low[k], "y", true));
    ctx.lineTo(across, u.valToPos(high[k], "y", true));
  });
  ctx.strokeStyle = paint();
  ctx.lineWidth = 1.4 * devicePixelRatio;
  ctx.stroke();
  ctx.restore();
}

export function eachCell(cells, visit) {
  const rows = cells.y.length - 1;
  for (let i = 0; i + 1 < cells.x.length; i++)
    for (let j = 0; j < rows; j++) {
      const value = cells.values[i * rows + j];
      if (value !== null) visit(cells.x[i], cells.x[i + 1], cells.y[j], cells.y[j + 1], value, j);
    }
}

/** What lies over the lines: marks on the x axis, and guides of the slopes. */
function over(u, described) {
  const { ctx, bbox } = u;
  ctx.save();
  for (const line of described.lines) if (line.bars) bars(u, line);
  for (const mark of described.marks ?? []) {
    const x = u.valToPos(mark.x, "x", true), size = 5 * devicePixelRatio, bottom = bbox.top + bbox.height;
    if (x < bbox.left || x > bbox.left + bbox.width) continue;
    ctx.fillStyle = mark.colour();
    ctx.beginPath();
    ctx.moveTo(x, bottom - 2 * size);
    ctx.lineTo(x - size, bottom);
    ctx.lineTo(x + size, bottom);
    ctx.fill();
  }
  for (const guide of guidesOf(u, described)) {
    ctx.strokeStyle = ctx.fillStyle = colour("guide");
    ctx.lineWidth = devicePixelRatio;
    ctx.setLineDash([2 * devicePixelRatio, 4 * devicePixelRatio]);
    ctx.beginPath();
    ctx.moveTo(u.valToPos(guide.x[0], "x", true), u.valToPos(guide.y[0], "y", true));
    ctx.lineTo(u.valToPos(guide.x[1], "x", true), u.valToPos(guide.y[1], "y", true));
    ctx.stroke();
    ctx.font = `${11 * devicePixelRatio}px system-ui, sans-serif`;
    ctx.textAlign = "right";
    ctx.fillText(guide.text, u.valToPos(guide.x[1], "x", true) - 3, u.valToPos(guide.y[1], "y", true) - 4);
  }
  ctx.setLineDash([]);
  if (described.note) {
    ctx.font = `${13 * devicePixelRatio}px system-ui, sans-serif`;
    ctx.textAlign = "center";
    ctx.fillStyle = "#3d4a5c"; // on the light middle of a map, also in the dark theme
    ctx.strokeStyle = "#f4f3f0";
    ctx.lineWidth = 5 * devicePixelRatio;
    ctx.lineJoin = "round";
    ctx.strokeText(described.note, bbox.left + bbox.width / 2, bbox.top + bbox.height / 2, bbox.width - 10);
    ctx.fillText(described.note, bbox.left + bbox.width / 2, bbox.top + bbox.height / 2, bbox.width - 10);
  }
  ctx.font = `600 ${11 * devicePixelRatio}px system-ui, sans-serif`;
  ctx.lineWidth = 3 * devicePixelRatio;
  ctx.lineJoin = "round";
  const toX = (x) => u.valToPos(x, "x", true), toY = (y) => u.valToPos(y, "y", true);
  for (const tag of tagsOf(u, described, toX, toY, 13 * devicePixelRatio)) {
    ctx.textAlign = tag.isFirst ? "left" : "right";
    ctx.strokeStyle = colour("raised");
    ctx.fillStyle = tag.colour();
    const x = tag.x + (tag.isFirst ? 6 : -6) * devicePixelRatio;
    ctx.strokeText(tag.text, x, tag.y);
    ctx.fillText(tag.text, x, tag.y);
  }
  ctx.restore();
}

const MOST_TAGS = 8; // names of lines in a plot that can be told apart

/** Where the names of lines are written: beside the higher end of what is seen of a line, none over another. */
export function tagsOf({ scales: { x: xs, y: ys } }, { lines }, toX, toY, height) {
  const tagged = lines.filter((line) => line.tag && line.y);
  if (tagged.length > MOST_TAGS) return [];
  const tags = [];
  for (const line of tagged) {
    const shown = line.x.map((_, k) => k).filter((k) => line.y[k] !== null && line.x[k] >= xs.min && line.x[k] <= xs.max && line.y[k] >= ys.min && line.y[k] <= ys.max);
    if (!shown.length) continue;
    const first = shown[0], last = shown[shown.length - 1], isFirst = line.y[first] > line.y[last];
    const k = isFirst ? first : last;
    tags.push({ text: line.tag, colour: line.colour, isFirst, x: toX(line.x[k]), y: toY(line.y[k]) - 0.4 * height });
  }
  tags.sort((a, b) => a.y - b.y);
  for (const isFirst of [true, false]) {
    let before = -Infinity;
    for (const tag of tags.filter((one) => one.isFirst === isFirst)) {
      tag.y = Math.max(tag.y, before + height);
      before = tag.y;
    }
  }
  const top = toY(ys.max) + height; // below the edge of the plot
  for (const tag of tags) tag.y = Math.max(tag.y, top);
  return tags;
}

const SLOPES = [[-1, "−1"], [-0.5, "−½"], [0, "0"], [0.5, "+½"], [1, "+1"]];

/** Lines of the slopes of the noise terms through the lowest point of the first curve, over the part that is seen. */
export function guidesOf(u, { guides, lines }) {
  if (!guides) return [];
  const line = lines.find((one) => one.read && one.y);
  if (!line) return [];
  let at = 0;
  line.y.forEach((value, k) => { if (value !== null && value < line.y[at]) at = k; });
  const { x: xs, y: ys } = u.scales, [px, py] = [line.x[at], line.y[at]];
  return SLOPES.map(([slope, name]) => {
    let from = xs.min, to = xs.max;
    const cross = (y) => px * (y / py) ** (1 / slope);
    if (slope < 0) { from = Math.max(from, cross(ys.max)); to = Math.min(to, cross(ys.min)); }
    if (slope > 0) { from = Math.max(from, cross(ys.min)); to = Math.min(to, cross(ys.max)); }
    return { x: [from, to], y: [py * (from / px) ** slope, py * (to / px) ** slope], text: name };
  }).filter((one) => one.x[1] > one.x[0]);
}

/** What is read at the cursor: x, and of each line that is read its nearest value with its interval. */
function nearest(u, described) {
  const x = u.posToVal(u.cursor.left, "x");
  if (described.cells) return { x, y: u.posToVal(u.cursor.top, "y"), values: [] };
  const values = [];
  let at = x;
  for (const line of described.lines) {
    if (!line.read) continue;
    const k = closest(line.x, x, described.x.log);
    if (k < 0) continue;
    at = line.x[k];
    const { low, high } = line.interval ?? line;
    values.push({ line, k, y: line.y?.[k] ?? null, low: low?.[k] ?? null, high: high?.[k] ?? null });
  }
  return { x: at, values };
}

/** Where the crosshair is drawn: on the point that is read which is nearest to the mouse. */
function snapped(u, described, left, top) {
  if (described.cells || left < 0) return [left, top];
  let place = [left, top], least = Infinity;
  for (const line of described.lines) {
    const k = line.read ? closest(line.x, u.posToVal(left, "x"), described.x.log) : -1;
    if (k < 0) continue;
    const across = u.valToPos(line.x[k], "x"), value = line.y?.[k] ?? null;
    const height = value === null ? top : u.valToPos(value, "y"), off = Math.abs(height - top);
    if (across < 0 || across > u.over.clientWidth || off >= least) continue;
    least = off;
    place = [across, Math.min(Math.max(height, 0), u.over.clientHeight)];
  }
  return place;
}

export function closest(xs, x, log) {
  let best = -1, least = Infinity;
  for (let k = 0; k < xs.length; k++) {
    const off = log ? Math.abs(Math.log(xs[k] / x)) : Math.abs(xs[k] - x);
    if (off < least) { least = off; best = k; }
  }
  return best;
}

const CLOSEST = 1e-5, FARTHEST = 3; // of the full range: the resolution of a packed series, and where curves are still seen

/** A range that is neither closer nor farther than can be read, as {min, max}; null if it is. */
function limited(described, axis, min, max) {
  const to = described[axis].log ? Math.log : Number, [low, high] = fullRange(described, axis).map(to);
  const share = (to(max) - to(min)) / (high - low);
  return share >= CLOSEST && share <= FARTHEST ? { min, max } : null;
}

/** Zoom by a factor about the middle of what is seen, or about the point that is read. */
export function zoom({ u, described }, factor) {
  u.batch(() => {
    for (const axis of ["x", "y"]) {
      const log = described[axis].log, to = log ? Math.log : Number, back = log ? Math.exp : Number;
      const { min, max } = u.scales[axis];
      const place = axis === "x" ? u.cursor.left : u.cursor.top;
      const centre = place >= 0 ? to(u.posToVal(place, axis)) : (to(min) + to(max)) / 2;
      const ends = limited(described, axis, back(centre - (centre - to(min)) * factor), back(centre + (to(max) - centre) * factor));
      if (ends) u.setScale(axis, ends);
    }
  });
}

/** What is seen of each axis that is zoomed, with the label of the axis, which has its unit. */
export function zoomOf({ u, described }) {
  return ["x", "y"].flatMap((axis) => {
    const { min, max } = u.scales[axis], [low, high] = fullRange(described, axis);
    return min === low && max === high ? [] : [{ axis, label: described[axis].label, min, max }];
  });
}

export function zoomTo({ u, described }, ranges) {
  for (const { axis, label, min, max } of ranges) if (described[axis].label === label) u.setScale(axis, { min, max });
}

/** Zoom to what was dragged over: of an axis along which it is the whole plot, the range stays. */
function select(u, described) {
  const { left, top, width, height } = u.select;
  const range = [u.posToVal(left, "x"), u.posToVal(left + width, "x")];
  if (described.onselect && width > 2) described.onselect(...range);
  else zoomToSelection(u, described);
  if (width > 2 && width < u.over.clientWidth) described.onrange?.(...range);
  u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
}

function zoomToSelection(u, described) {
  const { left, top, width, height } = u.select;
  u.batch(() => {
    for (const [axis, from, to, size, whole] of [["x", left, left + width, width, u.over.clientWidth], ["y", top + height, top, height, u.over.clientHeight]]) {
      if (!(size > 0) || size >= whole) continue;
      const ends = limited(described, axis, u.posToVal(from, axis), u.posToVal(to, axis));
      if (ends) u.setScale(axis, ends);
    }
  });
}

/** Arrow keys move the point that is read, + and - zoom, 0 and Escape show all. */
function keyboard(plot) {
  const { u, place, described } = plot;
  place.tabIndex = 0;
  place.setAttribute("role", "img");
  place.setAttribute("aria-label", `${described.title}. Arrow keys move the point that is read, plus and minus zoom, 0 shows all.`);
  place.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const step = event.shiftKey ? 10 : 1;
    if (event.key === "ArrowLeft") move(plot, -step);
    else if (event.key === "ArrowRight") move(plot, step);
    else if (event.key === "+" || event.key === "=") zoom(plot, 1 / 1.5);
    else if (event.key === "-") zoom(plot, 1.5);
    else if (event.key === "0" || event.key === "Escape") plot.reset();
    else return;
    event.preventDefault();
  });
  place.addEventListener("blur", () => u.setCursor({ left: -10, top: -10 }));
}

function move({ u, described }, steps) {
  const line = described.lines.find((one) => one.read);
  const seen = line ? line.x.filter((x) => x >= u.scales.x.min && x <= u.scales.x.max) : [];
  if (!seen.length) return;
  const now = u.cursor.left >= 0 ? closest(seen, u.posToVal(u.cursor.left, "x"), described.x.log) : steps > 0 ? -1 : seen.length;
  const k = Math.min(Math.max(now + steps, 0), seen.length - 1);
  const value = line.y?.[line.x.indexOf(seen[k])] ?? null;
  u.setCursor({ left: u.valToPos(seen[k], "x"), top: value === null ? u.over.clientHeight / 2 : u.valToPos(value, "y") });
}
