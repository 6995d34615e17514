// The page: its sections, and copying.

import { fill } from "./frame.js";
import { deviation } from "./deviation.js";
import { density } from "./density.js";
import { residuals } from "./residuals.js";
import { series } from "./series.js";
import { map } from "./map.js";

const KINDS = { deviation, density, residuals, series, map };
for (const place of document.querySelectorAll("[data-chart]")) fill(place, KINDS[place.dataset.chart]);

// Copying the values for a filter.
for (const button of document.querySelectorAll(".copy")) {
  button.hidden = false;
  button.addEventListener("click", async () => {
    const source = button.parentElement.querySelector("pre");
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
  });
}
