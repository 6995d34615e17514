// Saving a figure: SVG from its description and what is seen of it, PNG from that, and its numbers as CSV.

import { colour, make } from "./page.js";
import { linearTicks, logTicks, tickTexts } from "./numbers.js";
import { eachCell, guidesOf, tagsOf, yTicks } from "./plot.js";

const WIDTH = 760, LEFT = 78, RIGHT = 16, TOP = 14, BOTTOM = 46;

function fileName(made, ending) {
  const name = document.title.replace(/ – noise report$/, "").replace(/[^\p{L}\p{N}._-]+/gu, "-").slice(0, 60);
  return `${name || "report"}-${made.kind.id}-${made.sensor.name.replace(/[^\p{L}\p{N}_-]+/gu, "-").slice(0, 30)}.${ending}`;
}

export function save(blob, name) {
  const link = make("a", { href: URL.createObjectURL(blob), download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

export function saveSvg(made) {
  made.visible = true;
  if (!made.drawn.length) made.draw();
  save(new Blob([svgOf(made)], { type: "image/svg+xml" }), fileName(made, "svg"));
}

export function savePng(made) {
  made.visible = true;
  if (!made.drawn.length) made.draw();
  const svg = svgOf(made), picture = new Image();
  picture.onload = () => {
    const canvas = make("canvas", { width: picture.width * 2, height: picture.height * 2 });
    canvas.getContext("2d").drawImage(picture, 0, 0, canvas.width, canvas.height);
    canvas.toBlob((blob) => save(blob, fileName(made, "png")), "image/png");
  };
  picture.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(svg)}`;
}

export function saveCsv(made) {
  const { kind, sensor, state } = made;
  const quoted = (value) => (/[",\n\r]/.test(value) ? `"${value.replaceAll('"', '""')}"` : value);
  const safe = (value) => quoted(/^[=+\-@\t]/.test(value) ? `'${value}` : value); // no formula of a spreadsheet
  const number = (value) => (value === null || value === undefined ? "" : String(value));
  const rows = [];
  for (const described of kind.describe(sensor, state)) {
    const head = ["series", described.x.name ?? described.x.label, described.y.label, "low", "high"];
    if (!rows.length || rows[0].join() !== head.map(safe).join()) rows.push(head.map(safe));
    for (const line of described.lines) {
      const { low, high } = line.interval ?? line;
      line.x.forEach((x, k) => {
        if (line.y && line.y[k] === null) return;
        rows.push([safe(line.name), number(x), number(line.y?.[k]), number(low?.[k]), number(high?.[k])]);
      });
    }
    if (described.cells) {
      const { x, y, values } = described.cells;
      for (let i = 0; i + 1 < x.length; i++) for (let j = 0; j + 1 < y.length; j++)
        rows.push([safe(described.title), number((x[i] + x[i + 1]) / 2), number(Math.sqrt(y[j] * y[j + 1])), number(values[i * (y.length - 1) + j]), ""]);
    }
  }
  save(new Blob([rows.map((row) => row.join(",")).join("\n") + "\n"], { type: "text/csv" }), fileName(made, "csv"));
}

/** The figure as it is seen: title, plots one below the other, and a legend. */
function svgOf(made) {
  const named = new Map();
  let top = 34;
  const parts = made.drawn.map(({ u, described }) => {
    for (const line of described.lines) if (line.legend !== false && !named.has(line.name)) named.set(line.name, line);
    const part = plotSvg(u, described, top);
    top += described.height + 8;
    return part;
  });
  let x = LEFT, legend = "";
  top += 6;
  for (const [name, line] of named) {
    const width = 34 + 6.6 * name.length;
    if (x + width > WIDTH) { x = LEFT; top += 18; }
    const dash = line.dash ? ` stroke-dasharray="${line.dash.join(" ")}"` : "";
    legend += `<path d="M${x} ${top}h20" stroke="${line.colour()}" stroke-width="${line.y ? 2 : 5}"${dash}/><text x="${x + 25}" y="${top + 4}" fill="${colour("ink")}">${escaped(name)}</text>`;
    x += width;
  }
  const title = `${document.title.replace(/ – noise report$/, "").slice(0, 70)} · ${made.kind.title}, ${made.sensor.title}`;
  const height = top + 20;
  return `<svg xmlns="http://www.w3.org/2000/svg" width="${WIDTH}" height="${height}" viewBox="0 0 ${WIDTH} ${height}" font-family="Helvetica, Arial, 'DejaVu Sans', sans-serif" font-size="12" fill="none">`
    + `<rect width="100%" height="100%" fill="${colour("ground")}"/><text x="${LEFT}" y="22" font-size="14" font-weight="600" fill="${colour("ink")}">${escaped(title)}</text>${parts.join("")}${legend}</svg>`;
}

function escaped(text) {
  // Control characters are not part of XML.
  return text.replace(/[&<>"]/g, (c) => `&#${c.charCodeAt(0)};`).replace(/[\u0000-\u0008\u000b\u000c\u000e-\u001f\ufffe\uffff]/g, "?");
}

let clips = 0;

function plotSvg(u, described, top) {
  const width = WIDTH - LEFT - RIGHT, height = described.height - TOP - BOTTOM;
  const map = (axis, from, to) => {
    const log = described[axis].log, f = log ? Math.log : Number, { min, max } = u.scales[axis];
    return (value) => from + ((to - from) * (f(value) - f(min))) / (f(max) - f(min));
  };
  const X = map("x", LEFT, LEFT + width), Y = map("y", top + TOP + height, top + TOP);
  const digits = (value) => Math.round(value * 100) / 100;
  const at = (x, y) => `${digits(X(x))} ${digits(Math.min(Math.max(Y(y), -1e4), 1e4))}`;
  const ink = colour("soft"), id = `clip${(clips += 1)}`;
  let axes = "";
  for (const axis of ["x", "y"]) {
    const { log, label } = described[axis], { min, max } = u.scales[axis];
    const ticks = (log ? logTicks(min, max) : linearTicks(min, max, axis === "x" ? 6 : yTicks(described))).filter((tick) => tick >= min && tick <= max);
    const texts = tickTexts(ticks, log);
    ticks.forEach((tick, k) => {
      if (axis === "x") axes += `<path d="M${digits(X(tick))} ${top + TOP}v${height}" stroke="${colour("grid")}"/><text x="${digits(X(tick))}" y="${top + TOP + height + 17}" text-anchor="middle" fill="${ink}">${escaped(texts[k])}</text>`;
      else axes += `<path d="M${LEFT} ${digits(Y(tick))}h${width}" stroke="${colour("grid")}"/><text x="${LEFT - 7}" y="${digits(Y(tick)) + 4}" text-anchor="end" fill="${ink}">${escaped(texts[k])}</text>`;
    });
    const [x, y] = axis === "x" ? [LEFT + width / 2, top + described.height - 10] : [16, top + TOP + height / 2];
    axes += `<text x="${x}" y="${y}" text-anchor="middle" fill="${ink}"${axis === "y" ? ` transform="rotate(-90 ${x} ${y})"` : ""}>${escaped(label)}</text>`;
  }
  let drawn = "";
  if (described.cells) eachCell(described.cells, (x0, x1, y0, y1, value, row) => {
    drawn += `<rect x="${digits(X(x0))}" y="${digits(Y(y1))}" width="${digits(X(x1) - X(x0) + 0.3)}" height="${digits(Y(y0) - Y(y1) + 0.3)}" fill="${described.cells.colour(value, row)}"/>`;
  });
  for (const [from, to] of described.spans ?? []) drawn += `<rect x="${digits(X(from))}" y="${top + TOP}" width="${Math.max(digits(X(to) - X(from)), 1)}" height="${height}" fill="${colour("outside")}"/>`;
  for (const guide of guidesOf(u, described)) drawn += `<path d="M${at(guide.x[0], guide.y[0])}L${at(guide.x[1], guide.y[1])}" stroke="${colour("guide")}" stroke-dasharray="2 4"/>`;
  for (const line of described.lines) {
    for (const [begin, end] of stretches(line)) {
      const points = line.x.slice(begin, end);
      if (line.low) {
        const there = points.map((x, k) => [x, line.low[begin + k], line.high[begin + k]]).filter(([, low, high]) => low !== null && high !== null);
        const up = there.map(([x, , high]) => at(x, high)), down = there.map(([x, low]) => at(x, Math.max(low, described.y.log ? u.scales.y.min / 10 : low))).reverse();
        if (there.length) drawn += `<path d="M${[...up, ...down].join("L")}Z" fill="${line.colour()}" fill-opacity="${line.y ? 0.18 : 0.75}"/>`;
      }
      if (!line.y) continue;
      const dash = line.dash ? ` stroke-dasharray="${line.dash.join(" ")}"` : "";
      drawn += `<path d="M${points.map((x, k) => at(x, line.y[begin + k])).join("L")}" stroke="${line.colour()}" stroke-width="${line.width ?? 1.6}"${dash}/>`;
      if (line.points) drawn += points.map((x, k) => `<circle cx="${digits(X(x))}" cy="${digits(Y(line.y[begin + k]))}" r="2.2" fill="${line.colour()}"/>`).join("");
    }
  }
  for (const tag of tagsOf(u, described, X, Y, 13))
    drawn += `<text x="${digits(tag.x + (tag.isFirst ? 6 : -6))}" y="${digits(tag.y)}" font-size="11" font-weight="600" text-anchor="${tag.isFirst ? "start" : "end"}" fill="${tag.colour()}" stroke="${colour("ground")}" stroke-width="3" paint-order="stroke">${escaped(tag.text)}</text>`;
  if (described.note) drawn += `<text x="${LEFT + width / 2}" y="${top + TOP + height / 2}" text-anchor="middle" fill="#3d4a5c">${escaped(described.note)}</text>`;
  for (const mark of described.marks ?? []) drawn += `<path d="M${digits(X(mark.x))} ${top + TOP + height - 10}l-5 10h10z" fill="${mark.colour()}"/>`;
  return `<clipPath id="${id}"><rect x="${LEFT}" y="${top + TOP}" width="${width}" height="${height}"/></clipPath>${axes}<g clip-path="url(#${id})">${drawn}</g><rect x="${LEFT}" y="${top + TOP}" width="${width}" height="${height}" stroke="${colour("line")}"/>`;
}

/** Runs of points that have a value. */
function stretches(line) {
  const found = [], values = line.y ?? line.low;
  let begin = -1;
  values.forEach((value, k) => {
    if (value !== null && begin < 0) begin = k;
    if (value === null && begin >= 0 && line.gaps === true) { found.push([begin, k]); begin = -1; }
  });
  if (line.gaps !== true && begin >= 0) {
    const kept = values.map((value, k) => [value, k]).filter(([value]) => value !== null).map(([, k]) => k);
    return kept.length ? [[kept[0], kept[kept.length - 1] + 1]] : [];
  }
  if (begin >= 0) found.push([begin, values.length]);
  return found;
}
