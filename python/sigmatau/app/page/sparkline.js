// A small time series of a column: the smallest and the largest value of each interval.

const NS = "http://www.w3.org/2000/svg", WIDTH = 128, HEIGHT = 30;

/** An SVG of pairs [smallest, largest], which are null for an interval without a value. */
export function sparkline(pairs, label) {
  const svg = document.createElementNS(NS, "svg");
  svg.setAttribute("viewBox", `0 0 ${WIDTH} ${HEIGHT}`);
  svg.setAttribute("class", "spark");
  svg.setAttribute("role", "img");
  svg.setAttribute("aria-label", label);
  const finite = pairs.filter(([low, high]) => Number.isFinite(low) && Number.isFinite(high) && low !== null && high !== null);
  if (!finite.length) return svg;
  const smallest = Math.min(...finite.map(([low]) => low)), largest = Math.max(...finite.map(([, high]) => high));
  const span = largest - smallest, y = (value) => (span > 0 ? 2 + ((largest - value) / span) * (HEIGHT - 4) : HEIGHT / 2);
  const step = WIDTH / pairs.length;
  let path = "";
  pairs.forEach(([low, high], k) => {
    if (low === null || high === null) return;
    const [top, bottom] = [y(high), y(low)];
    path += `M${((k + 0.5) * step).toFixed(1)} ${(top - 0.6).toFixed(1)}V${(bottom + 0.6).toFixed(1)}`;
  });
  const line = document.createElementNS(NS, "path");
  line.setAttribute("d", path);
  line.setAttribute("stroke-width", Math.max(step * 0.8, 1).toFixed(1));
  svg.append(line);
  return svg;
}
