// Charts of values with their intervals at ordered places, such as runs or months.

const MOST_PLACE_CHARACTERS = 12; // largest length of the name of a place below its tick

function describeIntervals(panel) {
  const places = panel.places.map((name) => (name.length > MOST_PLACE_CHARACTERS ? `${name.slice(0, MOST_PLACE_CHARACTERS - 1)}…` : name));
  const count = panel.series.length, ends = panel.series.flatMap(({ low, high, values }) => [...low, ...high, ...values]).filter((value) => value !== null);
  const lines = panel.series.map((series, k) => ({
    name: series.name, x: series.at.map((place) => place + 1 + 0.3 * (count > 1 ? k / (count - 1) - 0.5 : 0)), // channels are drawn next to each other
    y: series.values, low: series.low, high: series.high, bars: true, colour: () => channelColour(k, count), width: 0, points: true, read: true,
  }));
  const smallest = Math.min(...ends), isWide = smallest > 0 && Math.max(...ends) > 8 * smallest;
  return { title: panel.title, height: 280, lines, x: { label: panel.order, range: [0.5, panel.places.length + 0.5], places }, y: { label: `[${panel.unit}]`, log: isWide } };
}

function readIntervals(panel) {
  return (point) => {
    const place = Math.round(point.x);
    return [make("b", {}, make("bdi", {}, panel.places[place - 1] ?? "")), ...point.values.filter(({ line, k }) => Math.round(line.x[k]) === place).map(({ line, y, low, high }) => {
      const mark = make("b", {}, make("bdi", {}, line.name));
      mark.style.color = line.colour();
      return make("span", {}, mark, ` ${text(y, 4)}${low === null ? "" : ` [${text(low, 4)}, ${text(high, 4)}]`} ${panel.unit}`);
    })];
  };
}

for (const place of document.querySelectorAll("[data-values]")) {
  for (const panel of content.panels) {
    const legend = panel.series.map((series, k) => [series.name, panel.series.length <= MOST_COLOURS ? `var(--axis-${k})` : "var(--soft)"]);
    labFigure(place, make("bdi", {}, panel.title), 280, legend, () => describeIntervals(panel), readIntervals(panel));
  }
}
