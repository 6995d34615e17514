// Table of the columns of a log or a live record: use, unit and statistics of the values of each column.

import { make } from "./page.js";
import { bdi, button, chip, choice, debounce, field } from "./dom.js";
import { session } from "./session.js";
import { asPairs, assign, columnsFrom, COMMON, sensorName, setPair, setUnit, SIGNAL, signalName, topicChanges, UNITS } from "./channels.js";
import { sparkline } from "./sparkline.js";
import { text } from "./numbers.js";

const MOST_UNUSED = 4; // largest number of unused columns that are not folded away
const unfolded = new Set();

/** Controls for the rate, the topic and the content of all columns; `target` reads and changes the options. */
export function readingControls(opened, target) {
  const options = target.all(), { about: { labels } } = session;
  const rate = make("input", { type: "text", size: 10, value: typeof options.rate === "object" ? Object.entries(options.rate).map((pair) => pair.join("=")).join(",") : options.rate ?? "", placeholder: opened.rate_hz ? text(opened.rate_hz, 5) : "", onchange: () => target.change({ rate: rate.value.trim() }) });
  rate.dataset.focus = "rate";
  const input = choice("Content of the columns", [["rate", "rates"], ["increments", "increments per sample"], ["accumulated", "accumulated angle and velocity"]], options.input ?? "rate", (value) => target.change({ input: value === "rate" ? undefined : value }));
  input.dataset.focus = "input";
  const parts = [field(labels.rate, rate), field(labels.input, input)];
  if (opened.topics?.length) {
    parts.unshift(topicControl(opened.topics, target));
  }
  for (const [option, label, sensors] of [["scale", "Scale of", ["gyro", "accel"]]]) {
    const used = new Set(opened.columns.map((column) => column.channel).filter(Boolean).map(sensorName));
    for (const sensor of sensors.filter((name) => used.has(name))) {
      const value = make("input", { type: "text", size: 8, value: asPairs(options[option])[sensor] ?? "", placeholder: "1", onchange: () => setPair(target, option, sensor, value.value.trim()) });
      value.dataset.focus = `${option}-${sensor}`;
      parts.push(field(`${label} ${sensor}`, value));
    }
  }
  return make("div", { className: "row reading" }, ...parts);
}

/** Control for the topic that is read, in a file with several topics. */
function topicControl(topics, target) {
  const stated = String(target.all().topic ?? ""), read = topics.filter(({ chosen }) => chosen).map(({ name }) => name);
  const recognised = read.length ? `as recognised${stated ? "" : `: ${read.join(", ")}`}` : "not chosen yet";
  const entries = topics.map(({ name, rate_hz: rate }) => [name, `${name}${rate ? ` (${text(rate)} Hz)` : ""}`]);
  if (stated && !topics.some(({ name }) => name === stated)) entries.unshift([stated, stated]);
  const select = choice("Topic", [["", recognised], ...entries], stated, (topic) => target.change(topicChanges(topic)));
  select.dataset.focus = "topic";
  return field("Topic", select, read.length > 1 ? "Several topics are read. Changing the use of a column reads its topic alone." : "");
}

/** The table, with a row for each column. */
export function columnTable(opened, target) {
  const heads = ["#", "Column", "First values", "Values", "Use as", "Unit", "Statistics"];
  const used = opened.columns.filter((column) => column.channel), unused = opened.columns.filter((column) => !column.channel);
  const folded = used.length && unused.length > MOST_UNUSED && !unfolded.has(opened.source);
  const makeRow = (column) => columnRow(column, opened, target);
  const rows = (folded ? used : opened.columns).map(makeRow);
  const unfold = button(`Show ${unused.length} columns that are not used`, () => { unfolded.add(opened.source); unfold.hidden = true; made.querySelector("tbody").append(...unused.map(makeRow)); }, { hidden: !folded });
  const [first, ...further] = new Set(opened.columns.map(({ topic }) => topic));
  const caption = opened.topics.length > 1 && !further.length ? [make("p", { className: "about" }, "Columns of the topic ", bdi(first))] : [];
  const made = make("div", {}, ...caption, make("div", { className: "scrolled", tabIndex: 0, role: "region", ariaLabel: "Columns of the file" },
    make("table", { className: "column-table" },
      make("thead", {}, make("tr", {}, ...heads.map((head) => make("th", { scope: "col" }, head)))),
      make("tbody", {}, ...rows)),
    ...Object.entries(UNITS).map(([sensor, units]) => make("datalist", { id: `units-${sensor}` }, ...units.map((unit) => make("option", { value: unit }))))), unfold);
  return made;
}

const nameOfColumn = ({ name, number }) => name || `column ${number}`;

function columnRow(column, { columns, rate_hz: rate, topics }, target) {
  const shown = (value) => (typeof value === "number" ? (Number.isInteger(value) ? String(value) : text(value, 3)) : String(value ?? "–"));
  const cell = (label, ...children) => { const made = make("td", {}, ...children); made.dataset.label = label; return made; };
  return make("tr", { className: column.channel ? "" : "unused" },
    cell("#", String(column.number)),
    make("th", { scope: "row" }, bdi(nameOfColumn(column)), ...(column.topic && columns.some(({ topic }) => topic !== column.topic) ? [make("small", { className: "topic" }, bdi(column.topic))] : [])),
    cell("First values", bdi((column.values ?? []).slice(0, 2).map(shown).join(", "))),
    cell("Values", sparkline(column.spark ?? [], `Values of ${nameOfColumn(column)}`)),
    cell("Use as", roleChoice(column, columns, topics, target)),
    cell("Unit", ...(column.channel ? [unitField(column, columns, target)] : [])),
    cell("Statistics", ...valuesText(column, rate)));
}

function roleChoice(column, columns, topics, target) {
  const entries = [["", "not used"], ...COMMON.map((name) => [name, name.replace("_", " ")])];
  if (column.channel && !COMMON.includes(column.channel)) entries.push([column.channel, column.channel.replace(/^(gyro|accel)_/, "$1 ")]);
  entries.push([SIGNAL, "another signal"]);
  if (!column.channel && columnsFrom(columns, column, 3).length) entries.push(["gyro", "gyro x, y, z (3 columns)"], ["accel", "accel x, y, z (3 columns)"]);
  const select = choice(`Use of ${nameOfColumn(column)}`, entries, column.channel ?? "", (value) => assign(target, columns, column, value === SIGNAL ? signalName(column) : value, topics));
  select.dataset.focus = `role-${columns.indexOf(column)}`;
  return select;
}

function unitField(column, columns, target) {
  const sensor = sensorName(column.channel);
  const input = make("input", { type: "text", size: 8, value: column.unit ?? "", ariaLabel: `Unit of ${column.channel}`, placeholder: "missing", className: column.unit ? "" : "wanted" });
  if (UNITS[sensor]) input.setAttribute("list", `units-${sensor}`);
  input.onchange = debounce(() => setUnit(target, columns, column, input.value), 0);
  input.dataset.focus = `unit-${columns.indexOf(column)}`;
  const how = { stated: "stated", given: "given by you", guessed: "guessed" }[column.unit_how];
  return make("span", { className: "unit" }, input, ...(how ? [make("small", {}, how)] : []));
}

function valuesText(column, rate) {
  const parts = [];
  const unit = (column.unit_si ?? "").replace("^2", "²");
  if (column.mean_si !== null && column.mean_si !== undefined) parts.push(`mean ${text(column.mean_si, 4)} ${unit}`);
  if (column.peak_to_peak !== null && column.peak_to_peak !== undefined) parts.push(`peak to peak ${text(column.peak_to_peak)} ${unit}`);
  if (column.rate_hz && column.rate_hz !== rate) parts.push(`${text(column.rate_hz, 4)} Hz`);
  if (column.gaps) parts.push(`${column.gaps} gap${column.gaps > 1 ? "s" : ""}`);
  else if (column.missing) parts.push(`${column.missing} missing`);
  if (column.remark) parts.push(column.remark);
  return parts.length ? [make("span", { className: "says" }, parts.join(" · "))] : [];
}

const MEANS = { // by verdict on a mean: text and kind of its mark, advice
  gravity: ["gravity", "good", ""],
  gravity_removed: ["without gravity", "partial", " Gravity was subtracted; record the raw output of the sensor if possible."],
  not_gravity: ["not gravity", "partial", " Check units, scale and columns."],
  offset: ["offset", "good", ""],
  large_offset: ["large offset", "partial", " Check unit, scale and columns, and that the sensor is at rest."],
  other_unit: ["unit", "partial", ""],
};

/** The mean vector of a sensor: gravity, or the offset of a gyroscope, if unit and columns are right. */
export function meanLine({ quantity, length, expected, unit, verdict, likely }) {
  const isGyro = quantity === "angular_rate", size = (value, digits) => (isGyro ? `${text((value * 180) / Math.PI, digits)} deg/s` : `${text(value, digits)} ${unit.replace("^2", "²")}`);
  const fact = isGyro
    ? ` The mean of the gyroscope is ${size(length, 3)}; at rest it is the offset of the sensor, usually below ${size(expected, 3)}.`
    : ` The mean of the accelerometer is ${size(length, 4)}; gravity is ${size(expected, 3)}.`;
  const [mark, kind, advice] = MEANS[verdict];
  return make("p", { className: isGyro ? "rotation" : "gravity" }, chip(mark, kind), fact, likely ? ` The unit is probably ${likely.replace("^2", "²")}.` : advice);
}
