// Figures of the pages of the laboratory. They are drawn when they scroll into view; a legend shows and hides their lines.

const labFigures = [];
const MOST_COLOURS = 6;

/** Make a figure. `legend`: names and colours of the style sheet; a line belongs to the entry of its `key`, otherwise of its name. */
function labFigure(place, title, height, legend, describe, read) {
  const body = make("div", { className: "plot" }), readout = make("div", { className: "readout" });
  body.style.minHeight = `${height}px`;
  const zoomIn = make("button", { type: "button", title: "Zoom in" }, "+"), zoomOut = make("button", { type: "button", title: "Zoom out" }, "−");
  const all = make("button", { type: "button", title: "Show all" }, "Reset");
  const hidden = new Set();
  const entries = legendOf(legend, hidden, () => figure.plot && figure.redraw());
  const element = make("figure", {}, make("div", { className: "top" }, make("figcaption", {}, title), make("div", { className: "controls tools" }, zoomIn, zoomOut, all)), entries, body, readout);
  const hint = "Point to read, drag to zoom, double-click for all.";
  const figure = { element, plot: null };
  figure.draw = () => {
    if (!figure.plot) figure.redraw();
  };
  figure.redraw = () => {
    if (figure.plot) { plots.delete(figure.plot); figure.plot.u.destroy(); }
    const described = describe();
    for (const axis of ["x", "y"]) described[axis].range = fullRange(described, axis); // including hidden lines
    described.lines = described.lines.filter((line) => !hidden.has(line.key ?? line.name));
    described.onread = (point) => readout.replaceChildren(...(point ? read(point) : [hint]));
    figure.plot = draw(body, described);
    if (described.thin) (figure.plot.u.hooks.drawClear ??= []).push((u) => thinLines(u, described));
    readout.textContent = hint;
    zoomIn.onclick = () => zoom(figure.plot, 1 / 1.5);
    zoomOut.onclick = () => zoom(figure.plot, 1.5);
    all.onclick = () => figure.plot.reset();
  };
  place.append(element);
  labFigures.push(figure);
  labWatcher.observe(element);
}

/** Legend: a button for each name, in its colour, that hides and shows its lines. */
function legendOf(entries, hidden, changed) {
  return make("div", { className: "controls" }, ...entries.map(([name, paint]) => {
    const swatch = make("i");
    swatch.style.background = paint;
    const entry = make("button", { type: "button", className: "swatch", ariaPressed: "true" }, swatch, make("bdi", {}, name));
    entry.onclick = () => {
      hidden.has(name) ? hidden.delete(name) : hidden.add(name);
      entry.ariaPressed = String(!hidden.has(name));
      changed();
    };
    return entry;
  }));
}

const labWatcher = new IntersectionObserver((entries) => {
  for (const entry of entries) {
    if (!entry.isIntersecting) continue;
    labWatcher.unobserve(entry.target);
    requestIdle(() => labFigures.find((figure) => figure.element === entry.target).draw());
  }
}, { rootMargin: "400px" });

/** Run a task when the browser is idle, so that scrolling stays smooth. */
const requestIdle = window.requestIdleCallback ? (task) => requestIdleCallback(task, { timeout: 300 }) : (task) => setTimeout(task, 0);

// On paper, two figures share a line.
const HALF_PAPER = 310; // width of a plot on A4 [px]
onPrint(() => {
  for (const figure of labFigures) figure.draw();
  for (const { plot } of labFigures) plot.u.setSize({ width: HALF_PAPER, height: 0.8 * plot.described.height });
});
