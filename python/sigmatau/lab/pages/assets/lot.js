// The page of a lot: curves of all units, values in the order of the units, sorting and search of the table.

const markedColour = (k) => `axis-${1 + (k % (MOST_COLOURS - 1))}`;
const faint = () => faded(colour("guide"), 0.35);

/** Draw the curves of all units in one stroke: a series for each of hundreds of units would make the page slow. */
function thinLines(u, { thin }) {
  const { ctx, bbox } = u, across = thin.x.map((value) => u.valToPos(value, "x", true));
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  ctx.beginPath();
  const { min, max } = u.scales.y, top = bbox.top, scale = bbox.height / (Math.log10(max) - Math.log10(min)), high = Math.log10(max);
  for (const row of thin.rows) {
    let down = false;
    row.forEach((value, k) => {
      if (value === null) { down = false; return; }
      const y = top + (high - value) * scale;
      if (down) ctx.lineTo(across[k], y);
      else ctx.moveTo(across[k], y);
      down = true;
    });
  }
  ctx.lineWidth = 0.5 * devicePixelRatio;
  ctx.strokeStyle = faint();
  ctx.stroke();
  ctx.restore();
}

/** Describe the curves of a channel. Only marked units have a line with a name; all others are thin lines. */
function describeCurves(panel) {
  const { tau, median, low, high, unit } = panel;
  const values = (row) => row.map((step, k) => (step === null ? null : median[k] * 10 ** (step / 1000)));
  const lines = [], middle = median.map(Math.log10);
  const rows = panel.rows.map((row) => row.map((step, k) => (step === null ? null : middle[k] + step / 1000))); // logarithms
  let smallest = Infinity, largest = -Infinity;
  for (const row of rows) for (const value of row) if (value !== null) { smallest = Math.min(smallest, value); largest = Math.max(largest, value); }
  lines.push({ name: "10 % to 90 % of the units", key: "median, 10–90 %", x: tau, y: median, low, high, colour: () => colour("axis-0"), width: 1.8, read: true });
  panel.limits.forEach(({ text: name, adev }) => lines.push({ name, key: "maximum", x: tau, y: adev, colour: () => colour("poor"), width: 1.2, dash: [6, 4], read: true, framed: false }));
  panel.marked.forEach((unit_, k) => {
    const index = panel.of.indexOf(unit_);
    if (index >= 0) lines.push({ name: content.units[unit_], x: tau, y: values(panel.rows[index]), colour: () => colour(markedColour(k)), width: 1.3, read: true });
  });
  return {
    title: `Allan deviation, ${panel.channel}`, height: 300, lines,
    thin: { x: tau, rows: rows.filter((_, k) => !panel.marked.includes(panel.of[k])) },
    x: { label: "averaging time τ [s]", log: true }, y: { label: `σ(τ) [${unit}]`, log: true, range: [10 ** (smallest - 0.08), 10 ** (largest + 0.08)] },
  };
}

function readCurves(panel) {
  return (point) => [make("b", {}, `τ = ${text(point.x)} s`), ...point.values.map(({ line, y, low, high }) => {
    const mark = make("b", {}, make("bdi", {}, line.low ? "median" : line.name));
    mark.style.color = line.colour();
    return make("span", {}, mark, ` ${text(y, 3)}${low === null ? "" : ` (10–90 %: ${text(low)} to ${text(high)})`} ${panel.unit}`);
  })];
}

/** Describe the values of a coefficient in the order of the units: points, their median, and the maximum. */
function describeValues(panel) {
  const last = Math.max(content.units.length, 2), lines = [], ends = [1, last];
  panel.channels.forEach((channel, k) => {
    const paint = () => channelColour(k, panel.channels.length);
    const usual = channel.at.map((unit, j) => (channel.outliers.includes(unit) ? null : channel.values[j]));
    lines.push({ name: channel.name, x: channel.at.map((unit) => unit + 1), y: channel.values, colour: paint, width: 0, points: true, read: true });
    lines.push({ name: "", key: channel.name, x: ends, y: [channel.median, channel.median], colour: paint, width: 0.8, dash: [2, 3] });
    if (usual.includes(null)) lines.push({ name: "", key: channel.name, x: channel.at.map((unit) => unit + 1), y: channel.values.map((value, j) => (usual[j] === null ? value : null)), colour: () => colour("poor"), width: 0, points: true });
  });
  panel.limits.forEach((limit) => lines.push({ name: "maximum", x: ends, y: [limit, limit], colour: () => colour("poor"), width: 1.2, dash: [6, 4], framed: panel.channels.some((channel) => Math.max(...channel.values) > limit / 3) }));
  const all = panel.channels.flatMap((channel) => channel.values);
  const isWide = Math.max(...all) > 8 * Math.min(...all);
  return { title: panel.title, height: 260, lines, x: { label: "unit, in order", range: [0.5, last + 0.5] }, y: { label: `[${panel.unit}]`, log: isWide } };
}

function readValues(panel) {
  return (point) => {
    const unit = Math.round(point.x) - 1;
    return [make("b", {}, make("bdi", {}, content.units[unit] ?? "")), ...point.values.filter(({ line, k }) => line.x[k] === unit + 1).map(({ line, y }) => {
      const mark = make("b", {}, make("bdi", {}, line.name));
      mark.style.color = line.colour();
      return make("span", {}, mark, ` ${text(y, 4)} ${panel.unit}`);
    })];
  };
}

for (const place of document.querySelectorAll("[data-lot]")) {
  if (place.dataset.lot === "curves") for (const panel of content.curves) {
    const legend = [["median, 10–90 %", "var(--axis-0)"], ...(panel.limits.length ? [["maximum", "var(--poor)"]] : []), ...panel.marked.map((unit, k) => [content.units[unit], `var(--${markedColour(k)})`])];
    labFigure(place, make("bdi", {}, panel.channel), 300, legend, () => describeCurves(panel), readCurves(panel));
  } else for (const panel of content.values) {
    const legend = panel.channels.map((channel, k) => [channel.name, panel.channels.length <= MOST_COLOURS ? `var(--axis-${k})` : "var(--soft)"]);
    if (panel.limits.length) legend.push(["maximum", "var(--poor)"]);
    labFigure(place, make("bdi", {}, panel.title), 260, legend, () => describeValues(panel), readValues(panel));
  }
}

// The heading of a column sorts the rows of the table, by number if its cells have numbers.
for (const head of document.querySelectorAll("table.units th[data-sort]")) {
  head.tabIndex = 0;
  const sort = () => {
    const body = head.closest("table").tBodies[0], k = head.cellIndex, up = head.getAttribute("aria-sort") !== "ascending";
    for (const other of head.parentElement.cells) other.removeAttribute("aria-sort");
    head.setAttribute("aria-sort", up ? "ascending" : "descending");
    const key = (row) => row.cells[k].dataset.key ?? row.cells[k].textContent;
    const rows = [...body.rows].map((row) => [key(row), row]), numbers = head.dataset.sort === "number";
    const order = (a, b) => (numbers ? (a === "") - (b === "") || Number(a) - Number(b) : a.localeCompare(b, undefined, { numeric: true }));
    rows.sort(([a], [b]) => (up ? order(a, b) : numbers && (a === "" || b === "") ? order(a, b) : order(b, a)));
    body.append(...rows.map(([, row]) => row));
  };
  head.addEventListener("click", sort);
  head.addEventListener("keydown", (event) => { if (event.key === "Enter" || event.key === " ") { event.preventDefault(); sort(); } });
}

// Only the units whose row contains all words of the search are shown.
const search = document.getElementById("search");
if (search) {
  const [input, count] = search.children, rows = [...document.querySelectorAll("table.units tbody tr")];
  const texts = rows.map((row) => `${row.cells[0].title} ${row.textContent}`.toLowerCase());
  search.hidden = false;
  input.addEventListener("input", () => {
    const words = input.value.toLowerCase().split(/\s+/).filter(Boolean);
    rows.forEach((row, k) => { row.hidden = !words.every((word) => texts[k].includes(word)); });
    count.textContent = words.length ? `${rows.filter((row) => !row.hidden).length} of ${rows.length} units` : "";
  });
}
