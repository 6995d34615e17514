// Several results of this session beside each other: curves in one figure a sensor, and the coefficients with their spread.

import { colour, make, setContent } from "./page.js";
import { drop, fill } from "./frame.js";
import { compare } from "./api.js";
import { bdi, checkbox, chip, errorBox } from "./dom.js";
import { deviation } from "./deviation.js";
import { raised } from "./summary.js";

const MOST_SHOWN = 6; // results of which each has a dash of its own
const DASHES = [undefined, [7, 3], [2, 3], [9, 3, 2, 3], [4, 4], [1, 5]];
const results = new Map(); // id → {name, charts, coefficients}, in the order in which they were made
const chosen = new Set();

/** Keep a result for comparisons. */
export function rememberResult(id, result) {
  if (results.has(id)) return;
  const options = Object.entries(result.options ?? {}).map(([name, value]) => `${name} ${typeof value === "object" ? JSON.stringify(value) : value}`).join(", ");
  results.set(id, { name: `${results.size + 1}: ${result.summary.title}${options ? `, ${options}` : ""}`, charts: result.charts, coefficients: result.summary.coefficients });
  chosen.add(id);
}

export const comparable = () => results.size;

/** Show the step. */
export function showCompare(view) {
  const table = make("div"), charts = make("div", { className: "charts" });
  const again = () => { drop(charts); charts.replaceChildren(); overlay(charts); return fillTable(table); };
  const boxes = [...results].map(([id, { name }], k) => {
    const box = checkbox(name, chosen.has(id), (on) => { on ? chosen.add(id) : chosen.delete(id); again(); });
    box.append(dashSwatch(k));
    return make("div", {}, box);
  });
  view.replaceChildren(
    make("div", { className: "head" }, make("div", {}, make("h1", {}, "Compare"), make("p", { className: "about" }, "Results of this session. Open another log or a stored result to add it."))),
    make("fieldset", {}, make("legend", {}, "Results"), ...boxes),
    make("section", {}, make("h2", {}, "Allan deviation"), charts),
    make("section", {}, make("h2", {}, "Coefficients"), table));
  return again();
}

function dashSwatch(k) {
  const canvas = make("canvas", { width: 60, height: 8, ariaHidden: "true", className: "dash" });
  const pen = canvas.getContext("2d");
  pen.strokeStyle = colour("ink");
  pen.lineWidth = 2;
  pen.setLineDash(DASHES[k % MOST_SHOWN] ?? []);
  pen.beginPath();
  pen.moveTo(0, 4);
  pen.lineTo(60, 4);
  pen.stroke();
  return canvas;
}

/** The curves of all chosen results: an axis has one colour, and a result one dash. */
function overlay(charts) {
  const shown = [...results].map(([id, result], k) => ({ id, k, ...result })).filter(({ id }) => chosen.has(id));
  if (!shown.length) return;
  const sensors = new Map(), channels = {};
  for (const { charts: found } of shown) for (const sensor of found.sensors) {
    const known = sensors.get(sensor.name);
    if (!known) sensors.set(sensor.name, { ...sensor, channels: [...sensor.channels] });
    else known.channels.push(...sensor.channels.filter((name) => !known.channels.includes(name)));
    for (const name of sensor.channels) channels[name] ??= found.channels[name];
  }
  setContent({ sensors: [...sensors.values()], channels });
  fill(charts, {
    ...deviation,
    id: "comparison",
    options: [{ name: "bands", text: "Intervals", on: () => false }, { name: "guides", text: "Slopes", on: () => false }],
    describe(sensor, state) {
      const lines = [];
      let described = null;
      for (const { k, charts: found } of shown) {
        const own = { ...sensor, channels: sensor.channels.filter((name) => found.channels[name]?.deviation) };
        setContent({ sensors: [own], channels: found.channels });
        const [part] = deviation.describe(own, { ...state, unit: state.unit, seen: state.seen, model: false, parts: false });
        for (const line of part?.lines ?? []) {
          const name = line.name, at = sensor.channels.findIndex((channel) => channel === name || channel.endsWith(`_${name}`));
          lines.push({ ...line, name: `${name} (${k + 1})`, dash: DASHES[k % MOST_SHOWN], points: false, colour: () => colour(`axis-${Math.max(at, 0) % 6}`) });
        }
        described ??= part ?? null;
      }
      setContent({ sensors: [...sensors.values()], channels });
      return described ? [{ ...described, lines }] : [];
    },
  });
}

async function fillTable(place) {
  const ids = [...results.keys()].filter((id) => chosen.has(id));
  if (ids.length < 2) {
    place.replaceChildren(make("p", { className: "none" }, "Choose two results or more."));
    return;
  }
  try {
    place.replaceChildren(coefficientTable(), make("h3", {}, "Repeatability of the runs"));
    const { text, differences } = await compare(ids);
    if (differences?.length) place.firstChild.before(differenceTable(differences));
    place.append(make("pre", { tabIndex: 0, role: "region", ariaLabel: "Repeatability", className: "comparison" }, text));
  } catch (error) {
    place.append(errorBox(error));
  }
}

/** The coefficients of the chosen results beside each other, a row a channel and term. */
function coefficientTable() {
  const shown = [...results.values()].filter((_, k) => chosen.has([...results.keys()][k]));
  const rows = new Map();
  shown.forEach(({ coefficients }, k) => {
    for (const { channel, rows: terms } of coefficients) for (const [term, value, interval, unit] of terms) {
      const key = `${channel} ${term}`;
      if (!rows.has(key)) rows.set(key, { channel, term, cells: shown.map(() => null), unit });
      rows.get(key).unit ||= unit;
      rows.get(key).cells[k] = { value, interval: /^\[|±/.test(interval) ? interval : "" };
    }
  });
  const body = [...rows.values()].map(({ channel, term, cells, unit }) => make("tr", {},
    make("th", { scope: "row" }, bdi(channel)), make("th", { scope: "row" }, term), make("td", {}, ...raised(unit)),
    ...cells.map((cell) => make("td", { className: "value" }, cell ? cell.value : "–", ...(cell?.interval ? [" ", make("span", { className: "interval" }, cell.interval)] : [])))));
  const numbers = [...results.keys()].map((id, k) => [id, k + 1]).filter(([id]) => chosen.has(id)).map(([, number]) => `result ${number}`);
  return make("div", { className: "scrolled", tabIndex: 0, role: "region", ariaLabel: "Coefficients of the results" },
    make("table", { className: "compared" }, make("thead", {}, make("tr", {}, ...["Channel", "Term", "Unit", ...numbers].map((name) => make("th", { scope: "col" }, name)))), make("tbody", {}, ...body)));
}

const VERDICTS = { same: ["same", "good"], differs: ["differs", "poor"], unknown: ["cannot tell", "partial"] };

/** Whether two results are of the same noise: the difference of each term with its interval. */
function differenceTable(differences) {
  const rows = differences.map(({ channel, term, text, verdict }) => make("tr", {}, make("th", { scope: "row" }, bdi(channel)), make("th", { scope: "row" }, term.replaceAll("_", " ")),
    make("td", {}, ...raised(text)), make("td", {}, chip(...(VERDICTS[verdict] ?? [verdict, "info"])))));
  return make("div", { className: "scrolled", tabIndex: 0, role: "region", ariaLabel: "Differences" },
    make("table", { className: "compared" }, make("caption", {}, "Difference, second result against the first"), make("thead", {}, make("tr", {}, ...["Channel", "Term", "Difference", "Verdict"].map((name) => make("th", { scope: "col" }, name)))), make("tbody", {}, ...rows)));
}
