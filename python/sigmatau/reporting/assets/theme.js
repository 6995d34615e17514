// The theme of the page: that of the system, until it is chosen.

import { plots } from "./plot.js";

const root = document.documentElement, dark = matchMedia("(prefers-color-scheme: dark)");
const themeButton = document.getElementById("theme");
const isDark = () => (root.dataset.theme ? root.dataset.theme === "dark" : dark.matches);
const colourings = [];

/** Do something whenever the colours change. */
export function onRecolour(action) {
  colourings.push(action);
}

export function recolour() {
  themeButton.textContent = isDark() ? "Light" : "Dark";
  for (const action of colourings) action();
  for (const { u } of plots) u.redraw(false, true);
}

themeButton.hidden = false;
themeButton.addEventListener("click", () => { root.dataset.theme = isDark() ? "light" : "dark"; recolour(); });
dark.addEventListener("change", recolour);
recolour();
