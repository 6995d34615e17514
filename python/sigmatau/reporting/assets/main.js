// The page: its sections, and copying.

import { fill } from "./frame.js";
import { make } from "./page.js";
import { deviation } from "./deviation.js";
import { density } from "./density.js";
import { residuals } from "./residuals.js";
import { series } from "./series.js";
import { map } from "./map.js";

/** The axes of a sensor have one axis of time: they are zoomed together; below them is the option that analyses the range alone. */
function showWindow(from, to, { element, drawn }, { x }) {
  for (const { u } of drawn) u.setScale("x", { min: from, max: to });
  const place = 10 ** Math.floor(Math.log10(((to - from) * x.unit.size) / 200)); // the resolution of the picture
  const seconds = (value) => `${Number((Math.round(Math.max(0, value * x.unit.size) / place) * place).toPrecision(9))}s`;
  const option = make("code", {}, `--window ${seconds(from)}:${seconds(to)}`);
  const button = make("button", { type: "button", className: "quiet", onclick: () => copy(button, option) }, "Copy");
  element.querySelector(".window")?.remove();
  element.append(make("p", { className: "window" }, "To analyse this part alone: ", option, button));
}

function resetTogether({ element, drawn }) {
  const resets = drawn.map((plot) => plot.reset);
  for (const plot of drawn) plot.reset = () => { for (const reset of resets) reset(); element.querySelector(".window")?.remove(); };
}

const KINDS = { deviation, density, residuals, series: { ...series, hint: "Point to read, drag to zoom and for the option of a part, double-click for all.", onrange: showWindow, drawn: resetTogether }, map };
for (const place of document.querySelectorAll("[data-chart]")) fill(place, KINDS[place.dataset.chart]);

async function copy(button, source) {
  let done = true;
  try {
    await navigator.clipboard.writeText(source.textContent);
  } catch {
    // A page from a file may not write to the clipboard: the text is selected, and copied by the older command.
    getSelection().selectAllChildren(source);
    done = document.execCommand("copy");
  }
  button.textContent = done ? "Copied" : "Selected";
  setTimeout(() => { button.textContent = "Copy"; }, 1500);
}

for (const button of document.querySelectorAll(".copy")) {
  button.hidden = false;
  button.addEventListener("click", () => copy(button, button.parentElement.querySelector("pre")));
}
