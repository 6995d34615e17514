// On paper all figures are drawn, in light colours and as wide as the paper.

import { plots, setPaper } from "./plot.js";
import { recolour } from "./theme.js";

const page = document.documentElement;
const drawings = []; // what draws the figures of the page
let before = null;

/** Say how the figures are drawn for paper: `drawFigures` makes all of them, in their sizes. */
export function onPrint(drawFigures) {
  drawings.push(drawFigures);
}

function toPaper() {
  if (before !== null) return;
  before = page.dataset.theme ?? "";
  setPaper(true);
  page.dataset.theme = "light";
  for (const drawFigures of drawings) drawFigures();
  recolour();
}

function toScreen() {
  if (before === null) return;
  if (before) page.dataset.theme = before;
  else delete page.dataset.theme;
  before = null;
  setPaper(false);
  for (const { u, place, described } of plots) u.setSize({ width: place.clientWidth, height: described.height });
  recolour();
}

addEventListener("beforeprint", toPaper);
addEventListener("afterprint", toScreen);
matchMedia("print").addEventListener("change", (event) => (event.matches ? toPaper() : toScreen()));
