// A text log that is dropped on the page: its columns, and the command that analyses it. Nothing leaves the machine.

import { make } from "./page.js";
import { text } from "./numbers.js";
import { sensor, SENSORS, settings } from "./settings.js";

const MAX_BYTES = 3e8, MIN_ROWS = 512, MAX_HEAD = 200;
const GAP = 1.9, MAX_GAPS = 0.1; // shortest gap in steps, largest share of gaps among the steps
const TIME = /^(t|time|timestamp|stamp|sec|secs|seconds|.*time.*)\b/i;
const TIME_UNITS = [[1, "s"], [1e3, "ms"], [1e6, "µs"], [1e9, "ns"]];

/** Split a line at its separator; runs of blanks are one. */
function fieldsOf(line, separator) {
  return separator === " " ? line.trim().split(/\s+/) : line.split(separator).map((field) => field.trim());
}

function separatorOf(line) {
  return [";", "\t", ","].find((separator) => line.includes(separator)) ?? " ";
}

/** The columns of a text: {names, columns}. Throws a message for a line that is not a row of the table. */
export function tableOf(content) {
  const lines = content.split(/\r\n|\n|\r/);
  while (lines.length && !lines[lines.length - 1].trim()) lines.pop();
  const isComment = (line) => /^\s*(#|%|\/\/|$)/.test(line);
  let first = -1, separator = ",", comma = false;
  for (let k = 0; k < Math.min(lines.length, MAX_HEAD) && first < 0; k++) {
    if (isComment(lines[k])) continue;
    separator = separatorOf(lines[k]);
    comma = separator !== "," && /\d,\d/.test(lines[k]);
    const fields = fieldsOf(lines[k], separator);
    if (fields.every((field) => field !== "" && Number.isFinite(numberOf(field, comma)))) first = k;
  }
  if (first < 0) throw new Error("No row of numbers was found. The command below reads more formats.");
  const count = fieldsOf(lines[first], separator).length;
  let header = lines.slice(0, first).reverse().find((line) => line.trim());
  header = header ? fieldsOf(header.replace(/^\s*(#|%|\/\/)\s*/, ""), separator) : [];
  const names = Array.from({ length: count }, (_, k) => (header.length === count && header[k] ? header[k].replaceAll('"', "") : `column ${k + 1}`));
  const columns = names.map(() => new Float64Array(lines.length - first));
  let rows = 0;
  for (let k = first; k < lines.length; k++) {
    if (isComment(lines[k])) continue;
    const fields = fieldsOf(lines[k], separator);
    if (fields.length !== count) throw new Error(`Line ${k + 1} has ${fields.length} values, not ${count}. The command below shows what to do.`);
    for (let j = 0; j < count; j++) {
      const value = numberOf(fields[j], comma);
      if (fields[j] === "" || !Number.isFinite(value)) throw new Error(`Line ${k + 1}: “${fields[j].slice(0, 20)}” is not a number. The command below shows what to do.`);
      columns[j][rows] = value;
    }
    rows++;
  }
  if (rows < MIN_ROWS) throw new Error(`The log has ${rows} rows. At least ${MIN_ROWS} are needed.`);
  return { names, columns: columns.map((column) => column.subarray(0, rows)) };
}

function numberOf(field, comma) {
  return Number(comma ? field.replace(",", ".") : field);
}

/**
 * The step of times without gaps, and the gaps: steps of at least 1.9 times the median one. Where those are a tenth of all, they are
 * the digits of the times, and the mean step is taken.
 */
function stepsOf(times) {
  const steps = Float64Array.from({ length: times.length - 1 }, (_, k) => times[k + 1] - times[k]);
  const mean = (times[times.length - 1] - times[0]) / steps.length, bound = GAP * steps.slice().sort()[steps.length >> 1];
  let gaps = 0, longest = 0, first = 0, sum = 0;
  steps.forEach((step, k) => {
    if (step < bound) { sum += step; return; }
    if (!gaps) first = times[k] - times[0];
    gaps++;
    longest = Math.max(longest, step);
  });
  if (gaps >= MAX_GAPS * steps.length) return { step: mean, gaps: 0, longest: 0, first: 0 };
  return { step: sum / (steps.length - gaps), gaps, longest, first };
}

/** The column of time, its rate and its gaps, if there is one. */
export function timeOf({ names, columns }) {
  const index = names.findIndex((name, k) => TIME.test(name) && columns[k].every((value, j, all) => j === 0 || value >= all[j - 1]));
  if (index < 0) return null;
  const column = columns[index], { step, gaps, longest, first } = stepsOf(column);
  if (!(step > 0)) return null;
  const named = TIME_UNITS.find(([, unit]) => new RegExp(`[\\[(_ ](${unit}|${unit.replace("µ", "u")})[\\])]?$`).test(names[index]));
  // Without a unit in the name: the largest one that gives a rate of at least 0.5 Hz.
  const [size, unit] = named ?? TIME_UNITS.find(([each]) => step / each <= 2) ?? TIME_UNITS[3];
  return { index, rate: Number((size / step).toPrecision(6)), unit, gaps, longest: longest / size, first: first / size };
}

function gapsInWords(time) {
  if (!time?.gaps) return "";
  const first = `${text(time.first, 4)} s after the start`, longest = `${text(time.longest, 3)} s`;
  const words = time.gaps === 1 ? `A gap of ${longest}, ${first}` : `${time.gaps} gaps, the first ${first}, the longest ${longest}`;
  return ` ${words}: the parts are joined here, which changes the curve.`;
}

const quoted = (word) => (/^[\w./:=,+^-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`);

/** The command that analyses the log. */
export function commandOf({ name, column, unit, rate, timed }) {
  const words = ["sigmatau", "analyze", quoted(name)];
  if (!timed) words.push("--rate", String(rate));
  words.push("--channels", quoted(`${sensor().channel}=${column}`), "--unit", quoted(`${settings.sensor}=${unit}`));
  return words.join(" ");
}

/** The place where a log is dropped or chosen. `onlog` is called with {name, samples, tau0, id}, or null for none. */
export function logReader(place, onlog) {
  const input = make("input", { type: "file", id: "file", accept: ".csv,.txt,.dat,.tsv,.log,text/*" });
  const controls = make("div", { className: "controls" }), message = make("p", { role: "status" }), command = make("pre", { tabIndex: 0, hidden: true });
  const copyButton = make("button", { type: "button", className: "copy quiet", hidden: true, onclick: copy }, "Copy");
  const box = make("div", { className: "drop" }, make("label", { htmlFor: "file" }, "Drop a text log here, or choose a file: "), input);
  place.append(box, message, controls, make("div", { className: "command" }, command, copyButton));
  let table = null, name = "", time = null, reads = 0;

  async function copy() {
    try {
      await navigator.clipboard.writeText(command.textContent);
      copyButton.textContent = "Copied";
    } catch {
      getSelection().selectAllChildren(command);
      copyButton.textContent = "Press Ctrl+C";
    }
    setTimeout(() => { copyButton.textContent = "Copy"; }, 1500);
  }

  /** Without a log, the page has its simulated record; the message comes first. */
  function fail(words) {
    onlog(null);
    message.textContent = words;
    message.className = "box poor";
    document.body.classList.add("refused");
    scrollTo({ top: 0 });
  }

  function clear() {
    message.className = "";
    document.body.classList.remove("refused");
  }

  function showCommand(words) {
    command.textContent = words;
    command.hidden = copyButton.hidden = false;
  }

  async function read(file) {
    name = file.name;
    controls.replaceChildren();
    clear();
    command.hidden = copyButton.hidden = true;
    try {
      if (file.size > MAX_BYTES) throw new Error("The log is larger than 300 MB. The command below reads it.");
      message.textContent = `Reading ${name} …`;
      table = tableOf(await file.text());
      time = timeOf(table);
    } catch (error) {
      showCommand(`sigmatau analyze ${quoted(name)}`);
      fail(error.message);
      return;
    }
    ask();
  }

  function ask() {
    const kinds = make("select", { ariaLabel: "Sensor" }, ...Object.entries(SENSORS).map(([key, { name: words }]) => make("option", { value: key }, words)));
    kinds.value = settings.sensor;
    const columns = make("select", { ariaLabel: "Column" }, ...table.names.flatMap((words, k) => (k === time?.index ? [] : [make("option", { value: k }, words)])));
    const units = make("select", { ariaLabel: "Unit" });
    const rate = make("input", { type: "text", inputMode: "decimal", className: "number", ariaLabel: "Sampling rate in Hz", value: String(time?.rate ?? "") });
    const fill = () => units.replaceChildren(...sensor().logs.map(([words]) => make("option", { value: words }, words)));
    const take = () => {
      const hertz = Number(rate.value.replace(",", "."));
      if (!(hertz > 0)) {
        command.hidden = copyButton.hidden = true;
        fail(`${name}: no column of time was found. Give the sampling rate above zero in the box “Rate [Hz]”.`);
        return;
      }
      const size = sensor().logs.find(([words]) => words === units.value)[1], column = table.columns[Number(columns.value)];
      const gap = gapsInWords(time);
      clear();
      message.textContent = `${name}: ${column.length.toLocaleString("en")} rows at ${text(hertz, 5)} Hz${time ? ` (from ${table.names[time.index]} in ${time.unit})` : ""}.${gap} Not checked here: no coefficients. The command checks the record and fits them.`;
      showCommand(commandOf({ name, column: table.names[Number(columns.value)], unit: units.value, rate: hertz, timed: time !== null && hertz === time.rate }));
      reads++;
      onlog({ name, samples: Float64Array.from(column, (value) => value * size), tau0: 1 / hertz, id: `log ${reads}` });
    };
    kinds.addEventListener("change", () => { settings.sensor = kinds.value; fill(); take(); });
    for (const control of [columns, units, rate]) control.addEventListener("change", take);
    fill();
    const back = make("button", { type: "button", onclick: () => { controls.replaceChildren(); message.textContent = ""; clear(); command.hidden = copyButton.hidden = true; input.value = ""; onlog(null); } }, "Back to the simulated record");
    const labelled = (words, control) => make("label", {}, words, " ", control);
    controls.replaceChildren(labelled("Sensor", kinds), labelled("Column", columns), labelled("Unit", units), labelled("Rate [Hz]", rate), back);
    take();
  }

  input.addEventListener("click", () => { input.value = ""; }); // so that the same file can be chosen again
  input.addEventListener("change", () => { if (input.files.length) read(input.files[0]); });
  for (const kind of ["dragover", "dragenter"]) document.addEventListener(kind, (event) => { event.preventDefault(); box.classList.add("over"); });
  document.addEventListener("dragleave", (event) => { if (!event.relatedTarget) box.classList.remove("over"); });
  document.addEventListener("drop", (event) => {
    event.preventDefault();
    box.classList.remove("over");
    if (event.dataTransfer.files.length) read(event.dataTransfer.files[0]);
  });
}
