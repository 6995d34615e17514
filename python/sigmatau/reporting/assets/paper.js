// On paper all figures are drawn, in light colours and as wide as the paper.

import { drawAll, figures } from "./frame.js";
import { plots, setPaper } from "./plot.js";
import { recolour } from "./theme.js";

const PAPER = 660; // width of a plot on A4 with margins of 15 mm [px]
let before = null;

function toPaper() {
  if (before !== null) return;
  before = document.documentElement.dataset.theme ?? "";
  setPaper(true);
  document.documentElement.dataset.theme = "light";
  drawAll();
  recolour();
  for (const { element, drawn, kind } of figures) {
    const wide = kind.id === "deviation" || kind.id === "density" || element.parentElement.children.length === 1;
    for (const { u, described } of drawn) u.setSize({ width: wide ? PAPER : PAPER / 2 - 22, height: described.height * (wide ? 1 : 0.8) });
  }
}

function toScreen() {
  if (before === null) return;
  if (before) document.documentElement.dataset.theme = before;
  else delete document.documentElement.dataset.theme;
  before = null;
  setPaper(false);
  for (const { u, place, described } of plots) u.setSize({ width: place.clientWidth, height: described.height });
  recolour();
}

addEventListener("beforeprint", toPaper);
addEventListener("afterprint", toScreen);
matchMedia("print").addEventListener("change", (event) => (event.matches ? toPaper() : toScreen()));
