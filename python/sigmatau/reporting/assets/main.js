// The page: its sections, the theme, copying, printing.

const KINDS = { deviation, density, residuals, series, map };
for (const place of document.querySelectorAll("[data-chart]")) fill(place, KINDS[place.dataset.chart]);

// Theme: that of the system, until it is chosen.
const root = document.documentElement, dark = matchMedia("(prefers-color-scheme: dark)");
const themeButton = document.getElementById("theme");
const isDark = () => (root.dataset.theme ? root.dataset.theme === "dark" : dark.matches);

function recolour() {
  themeButton.textContent = isDark() ? "Light" : "Dark";
  for (const one of figures) one.sync?.();
  for (const { u } of plots) u.redraw(false, true);
}

themeButton.hidden = false;
themeButton.addEventListener("click", () => { root.dataset.theme = isDark() ? "light" : "dark"; recolour(); });
dark.addEventListener("change", recolour);
recolour();

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

// On paper all figures are drawn, in light colours and as wide as the paper.
const PAPER = 660; // width of a plot on A4 with margins of 15 mm [px]
let before = null;

function toPaper() {
  if (before !== null) return;
  before = root.dataset.theme ?? "";
  onPaper = true;
  root.dataset.theme = "light";
  drawAll();
  recolour();
  for (const { element, drawn, kind } of figures) {
    const wide = kind.id === "deviation" || kind.id === "density" || element.parentElement.children.length === 1;
    for (const { u, described } of drawn) u.setSize({ width: wide ? PAPER : PAPER / 2 - 22, height: described.height * (wide ? 1 : 0.8) });
  }
}

function toScreen() {
  if (before === null) return;
  if (before) root.dataset.theme = before;
  else delete root.dataset.theme;
  before = null;
  onPaper = false;
  for (const { u, place, described } of plots) u.setSize({ width: place.clientWidth, height: described.height });
  recolour();
}

addEventListener("beforeprint", toPaper);
addEventListener("afterprint", toScreen);
matchMedia("print").addEventListener("change", (event) => (event.matches ? toPaper() : toScreen()));
