// The settings of the page: sliders with their units, and the model in SI that they give.

import { make } from "./page.js";
import { setText } from "./chart.js";
import { text } from "./numbers.js";

const DEG = Math.PI / 180, HOUR = 3600, MICRO_G = 9.80665e-6;

/** By sensor: unit of the curve, of a saved record, of logs, and of each slider [text, size in SI]. */
export const SENSORS = {
  gyro: {
    name: "gyro", channel: "gyro_x", rate: ["deg/h", DEG / HOUR], file: ["deg/h", DEG / HOUR], logs: [["deg/s", DEG], ["rad/s", 1], ["deg/h", DEG / HOUR]],
    units: { Q: ["arcsec", DEG / HOUR], N: ["deg/√h", DEG / 60], B: ["deg/h", DEG / HOUR], K: ["deg/h/√h", DEG / HOUR / 60], R: ["deg/h/h", DEG / HOUR / HOUR], sigma: ["deg/h", DEG / HOUR] },
    names: { N: "Angle random walk", K: "Rate random walk", R: "Rate ramp" },
  },
  accel: {
    name: "accelerometer", channel: "accel_x", rate: ["µg", MICRO_G], file: ["m/s^2", 1], logs: [["m/s^2", 1], ["g", 9.80665], ["mg", 9.80665e-3]],
    units: { Q: ["mm/s", 1e-3], N: ["m/s/√h", 1 / 60], B: ["µg", MICRO_G], K: ["µg/√h", MICRO_G / 60], R: ["µg/h", MICRO_G / HOUR], sigma: ["µg", MICRO_G] },
    names: { N: "Velocity random walk", K: "Acceleration random walk", R: "Acceleration ramp" },
  },
};

/** The terms: letter of IEEE Std 952, slope of σ(τ), where its line is read [s], and the factor of the reading. */
export const TERMS = [
  { id: "Q", name: "Quantization noise", slope: -1, slopeText: "−1", tau: Math.sqrt(3), tauText: "√3 s", factor: 1, colour: "axis-3", paper: "Q_z in the paper", eq: "15" },
  { id: "N", name: "Random walk", slope: -0.5, slopeText: "−½", tau: 1, tauText: "1 s", factor: 1, colour: "axis-0", paper: "Q in the paper", eq: "17" },
  { id: "B", name: "Bias instability", slope: 0, slopeText: "0", tau: null, tauText: "flat part", factor: 1 / Math.sqrt((2 * Math.LN2) / Math.PI), colour: "axis-2", paper: "B in the paper", eq: "19" },
  { id: "K", name: "Rate random walk", slope: 0.5, slopeText: "+½", tau: 3, tauText: "3 s", factor: 1, colour: "axis-1", paper: "K in the paper", eq: "21" },
  { id: "R", name: "Rate ramp", slope: 1, slopeText: "+1", tau: Math.SQRT2, tauText: "√2 s", factor: 1, colour: "axis-4", paper: "R in the paper", eq: "23" },
];
export const PROCESS = { id: "sigma", colour: "process" };

/** Sliders: range in decades of the unit; `steps` are listed values instead. */
const RANGES = {
  gyro: { Q: [-2, 2], N: [-3, 1], B: [-2, 3], K: [-1, 4], R: [-1, 5], sigma: [-1, 3] },
  accel: { Q: [-3, 1], N: [-4, 0], B: [-1, 4], K: [0, 5], R: [0, 6], sigma: [0, 4] },
};
const OTHERS = { time: [0, 4], corner: [-0.5, 3], rate: [0, 3], hours: [-2, Math.log10(24)] };
export const MAX_SAMPLES = 1e6;

/** Settings of a button, in the units of a gyro; null: the term is off. */
export const PRESETS = {
  "All five terms": { Q: 3, N: 0.15, B: 12, K: 90, R: 600, sigma: null, order: 0, rate: 50, hours: 2 },
  "Tactical grade (HG1700)": { Q: 5.1154, N: 0.094, B: null, K: null, R: null, sigma: null, order: 0, rate: 100, hours: 2 },
  "MEMS": { Q: null, N: 0.3, B: 10, K: 60, R: null, sigma: null, order: 2, corner: 20, rate: 100, hours: 2 },
  "Hump of a Gauss–Markov process": { Q: null, N: 0.1, B: null, K: null, R: null, sigma: 30, time: 60, order: 0, rate: 20, hours: 4 },
};

export const settings = {
  sensor: "gyro", seed: 1, order: 0,
  value: { Q: 3, N: 0.15, B: 12, K: 90, R: 600, sigma: 20, time: 60, corner: 20, rate: 50, hours: 2 },
  on: { Q: true, N: true, B: true, K: true, R: true, sigma: false },
};

export const sensor = () => SENSORS[settings.sensor];
export const termName = (id) => sensor().names[id] ?? TERMS.find((term) => term.id === id).name;
export const unitOf = (id) => sensor().units[id];

/** The model in SI, in the order of crates/web/src/model.rs. */
export function modelNow() {
  const { value, on } = settings;
  const si = (id) => (on[id] ? value[id] * unitOf(id)[1] : 0);
  return [...TERMS.map((term) => si(term.id)), si("sigma"), value.time, settings.order, value.corner, 1 / value.rate];
}

/** Whether the model has noise, and not a ramp alone. */
export const hasNoise = () => Object.keys(settings.on).some((id) => id !== "R" && settings.on[id]);

/** Number of samples, at most `MAX_SAMPLES`. */
export function samplesNow() {
  return Math.min(MAX_SAMPLES, Math.max(512, Math.round(settings.value.hours * HOUR * settings.value.rate)));
}

let applied = settings.value.hours, wanted = applied;

/** Shorten the record to `MAX_SAMPLES`; a lower rate gives back the length that was set. */
export function limitLength() {
  const { value } = settings;
  if (value.hours !== applied) wanted = value.hours;
  const longest = Number((MAX_SAMPLES / value.rate / HOUR).toPrecision(3));
  applied = value.hours = Math.min(wanted, longest);
  return wanted > longest;
}

/** A length of time: "45 s", "2 min", "3.5 h", "12 d". */
export function timeText(seconds) {
  if (!Number.isFinite(seconds)) return "–";
  const [size, unit] = seconds < 100 ? [1, "s"] : seconds < 6000 ? [60, "min"] : seconds < 3e5 ? [HOUR, "h"] : [24 * HOUR, "d"];
  return `${text(seconds / size, 2)} ${unit}`;
}

function rangeOfSlider(id) {
  return OTHERS[id] ?? RANGES[settings.sensor][id];
}

const STEPS = 400;

/** Values of sliders have two or three digits, so that they can be repeated elsewhere. */
function rounded(value, id) {
  if (id !== "rate") return Number(value.toPrecision(3));
  const decade = 10 ** Math.floor(Math.log10(value) + 1e-9);
  return [1, 2, 5, 10].map((k) => k * decade).reduce((best, x) => (Math.abs(Math.log(x / value)) < Math.abs(Math.log(best / value)) ? x : best));
}

/** A slider with its letter, name, value and unit. `onchange` is called on each movement. */
export function slider(id, [name, title, note], onchange, { toggled = false, only = null } = {}) {
  const unit = () => ({ time: "s", corner: "Hz", rate: "Hz", hours: "h" })[id] ?? unitOf(id)[0];
  const range = make("input", { type: "range", min: 0, max: STEPS, step: 1, id: `slider-${id}` });
  const number = make("input", { type: "text", inputMode: "decimal", className: "number", ariaLabel: `${name}, value` });
  const suffix = make("span", { className: "unit" });
  const box = toggled ? make("input", { type: "checkbox", ariaLabel: `${name}: present` }) : null;
  const label = make("label", { htmlFor: range.id }, make("b", {}, name), ` ${title}`, make("small", {}, note));
  const row = make("div", { className: "slider" }, ...(box ? [box] : []), label,
    ...(only ? [make("button", { type: "button", className: "only", ariaLabel: `Only ${name}`, title: "Switch all other terms off; the filter stays", onclick: only }, "only")] : []),
    make("span", { className: "entry" }, number, suffix), range);

  /** Only what differs is written: the layout of the page stays valid. */
  function show() {
    const [low, high] = rangeOfSlider(id), value = settings.value[id], words = `${text(value)} ${unit()}`;
    const step = String(Math.round((STEPS * (Math.log10(value) - low)) / (high - low)));
    if (range.value !== step) range.value = step;
    if (range.getAttribute("aria-valuetext") !== words) range.setAttribute("aria-valuetext", words);
    if (document.activeElement !== number) {
      const shown = text(value, 4, 1e7);
      if (number.value !== shown) number.value = shown;
      number.removeAttribute("aria-invalid");
    }
    setText(suffix, unit());
    if (box) box.checked = settings.on[id];
    row.classList.toggle("off", Boolean(box) && !settings.on[id]);
  }
  range.addEventListener("input", () => {
    const [low, high] = rangeOfSlider(id);
    settings.value[id] = rounded(10 ** (low + ((high - low) * Number(range.value)) / STEPS), id);
    if (box) settings.on[id] = true;
    onchange(id);
  });
  number.addEventListener("change", () => {
    const typed = Number(number.value.trim().replace(",", ".")), [low, high] = rangeOfSlider(id);
    number.setAttribute("aria-invalid", String(!(typed > 0)));
    if (typed > 0) {
      settings.value[id] = Math.min(Math.max(typed, 10 ** low), 10 ** high);
      if (box) settings.on[id] = true;
      number.blur();
      onchange(id);
    }
  });
  box?.addEventListener("change", () => {
    settings.on[id] = box.checked;
    onchange(id);
  });
  return { row, show };
}

const KEYS = { Q: "quantization", N: "random_walk", B: "bias_instability", K: "rate_random_walk", R: "rate_ramp" };

/** The model as a file for the command line. */
export function modelFile() {
  const { value, on } = settings, plain = (words) => words.replace("√h", "sqrt(h)").replace("µ", "u");
  const lines = [`[channels.${sensor().channel}]`];
  for (const { id } of TERMS) if (on[id]) lines.push(`${KEYS[id]} = "${value[id]} ${plain(unitOf(id)[0])}"`);
  if (on.sigma) lines.push(`gauss_markov = [{ sigma = "${value.sigma} ${plain(unitOf("sigma")[0])}", time = "${value.time} s" }]`);
  if (settings.order && on.N) lines.push(`bandwidth = { order = ${settings.order}, corner = "${value.corner} Hz" }`);
  return `${lines.join("\n")}\n`;
}

/** Take the settings of a preset; values are converted to the units of the sensor. */
export function usePreset(name) {
  settings.sensor = "gyro";
  for (const [id, value] of Object.entries(PRESETS[name])) {
    if (id === "order") settings.order = value;
    else if (id in settings.on) {
      settings.on[id] = value !== null;
      if (value !== null) settings.value[id] = value;
    } else settings.value[id] = value;
  }
}

/** Middle values of another sensor. */
export function useSensor(name) {
  settings.sensor = name;
  const values = name === "gyro" ? PRESETS["All five terms"] : { Q: 0.05, N: 0.01, B: 15, K: 150, R: 500, sigma: 30 };
  for (const id of Object.keys(settings.on)) if (values[id]) settings.value[id] = values[id];
}
