// The page: sliders change the curves at once, the record in a worker, and the estimate a moment later in another.

import { make } from "./page.js";
import { recolourCharts, setText } from "./chart.js";
import { coreOf, denseSizes, frequenciesOf, moduleOf, workerOf } from "./core.js";
import { byId, figures, legend, shown } from "./figures.js";
import { lineByHand, readings } from "./read_off.js";
import { estimateOf, showEstimate, tally, verdictText } from "./results.js";
import { questionOf, showErrors, showPlan } from "./lengths.js";
import { foldedNoise, samplesForCoefficients } from "./sampled.js";
import { hasNoise, limitLength, modelFile, modelNow, PRESETS, samplesNow, sensor, settings, slider, termName, TERMS, timeText, unitOf, usePreset, useSensor, MAX_SAMPLES } from "./settings.js";
import { text } from "./numbers.js";
import { logReader } from "./log.js";

const QUIET = 200; // time without a change after which the record is estimated [ms]

/** Time of the work in each frame, for measurements. [ms] */
const frames = [];

function themeButton() {
  const root = document.documentElement, dark = matchMedia("(prefers-color-scheme: dark)"), button = byId("theme");
  const isDark = () => (root.dataset.theme ? root.dataset.theme === "dark" : dark.matches);
  const apply = () => { button.textContent = isDark() ? "Light" : "Dark"; recolourCharts(); };
  button.addEventListener("click", () => { root.dataset.theme = isDark() ? "light" : "dark"; apply(); });
  dark.addEventListener("change", apply);
  apply();
}

function start(module) {
  const call = coreOf(module), script = byId("worker").textContent;
  const drawn = figures(call);
  const recorder = workerOf(module, script, onanswer, { rests: true }), estimator = workerOf(module, script, onanswer);
  const planner = workerOf(module, script, onanswer);
  let number = 0, timer = 0, moving = false, limits = null; // the last answer with the errors of the deviations
  let asks = 0; // number of the last question on a length
  let sent = "", asked = null, isLimited = false; // the log that the workers have; what the plan was asked for
  const stale = new Set(); // what the next frame draws: "model", "record", "density"

  const request = () => ({ number, model: drawn.model() ?? modelNow(), samples: drawn.samples(), seed: settings.seed, log: shown.log });

  /** Draw something in the next frame. */
  function draw(what) {
    if (!stale.size) requestAnimationFrame(frame);
    stale.add(what);
  }

  /** A change of the settings: the curves in the next frame. */
  function change() {
    number++;
    if (!moving) for (const worker of [estimator, planner]) worker.stop(); // they have a core while nothing moves
    moving = true;
    isLimited = limitLength();
    draw("model");
    clearTimeout(timer);
    timer = setTimeout(estimate, QUIET);
  }

  function frame() {
    const begun = performance.now();
    if (stale.has("model")) {
      if (!shown.log) shown.fit = shown.density = null;
      for (const { show } of sliders.values()) show();
      drawn.drawModel();
      askRecord();
      showState();
    }
    drawn.drawDeviation();
    if (stale.has("model") || stale.has("density")) drawn.drawDensity();
    if (stale.has("record")) drawn.drawRecord();
    stale.clear();
    frames.push(performance.now() - begun);
  }

  /** A log is sent once; a simulated record is made after each change. */
  function askRecord() {
    if (shown.log && shown.log.id === sent) return;
    sent = shown.log?.id ?? "";
    recorder.ask("record", { ...request(), columns: drawn.columns() });
    if (shown.log) estimator.ask("density", request());
  }

  /** Eq. (26) beside the exact error; not in each frame of a movement. */
  function drawErrors() {
    if (!limits) return;
    drawn.drawError(limits.sizes, limits.freedom);
    showErrors(byId("errors"), drawn);
  }

  function estimate() {
    moving = false;
    if (shown.log) return;
    drawErrors();
    if (hasNoise()) estimator.ask("estimate", request());
    else shown.fit = { failed: true };
    showEstimate(byId("coefficients"));
    byId("verdict").textContent = verdictText();
    askPlan();
  }

  function askPlan() {
    byId("model-file").textContent = modelFile();
    byId("model-commands").textContent = `sigmatau plan model.toml --term bias_instability --rate ${settings.value.rate} --hours ${settings.value.hours}\nsigmatau simulate model.toml --rate ${settings.value.rate} --hours ${settings.value.hours} --seed 1 -o log.csv`;
    const question = questionOf(byId("plan-tau"), byId("plan-error"), drawn.tau0()), { tau, error, problem } = question;
    byId("plan-state").textContent = problem ?? "Computing …";
    byId("plan-state").className = problem ? "wrong" : "";
    if (problem) {
      byId("plan").replaceChildren();
      asks++; // an answer on its way is no longer wanted
      byId("plan").removeAttribute("aria-busy");
      return;
    }
    asked = { ...question, ask: ++asks, coefficients: samplesForCoefficients(call, modelNow(), error) };
    byId("plan").setAttribute("aria-busy", "true");
    planner.stop();
    planner.ask("plan", { number, ask: asks, model: modelNow(), size: Math.round(tau / drawn.tau0()), error });
  }

  function onanswer(answer) {
    if (answer.kind === "record" && !answer.failed) {
      const size = sensor().rate[1], tau0 = drawn.tau0(), adev = answer.adev.map((value) => value / size);
      shown.curve = { tau: answer.sizes.map((m) => m * tau0), adev, ...intervalsOf(adev, answer.freedom) };
      shown.envelope = answer.envelope ?? shown.envelope;
      draw("record");
      limits = answer;
      if (!moving) drawErrors();
    }
    if (answer.number !== number) return;
    if (answer.kind === "plan" && answer.ask !== asks) return;
    if (answer.kind === "plan") {
      byId("plan").removeAttribute("aria-busy");
      byId("plan-state").textContent = answer.failed ? "The length could not be computed." : "";
    }
    if (answer.kind === "plan" && !answer.failed) showPlan(byId("plan"), { ...asked, ...answer });
    if (answer.kind === "estimate" || answer.kind === "density") {
      const size = sensor().rate[1];
      shown.samples = drawn.samples();
      if (answer.density) {
        const f = answer.density.filter((_, k) => k % 2 === 0), s = answer.density.filter((_, k) => k % 2).map((value) => value / size ** 2);
        shown.density = { f, s };
      }
      if (answer.kind === "estimate") {
        shown.fit = answer.failed || !answer.values ? { failed: true } : { estimate: estimateOf([...answer.values]), time: answer.time, values: [...answer.values] };
        if (shown.fit.estimate) {
          shown.fit.curve = fittedCurve(shown.fit.estimate);
          byId("tally").textContent = tally(shown.fit.estimate);
        }
        showEstimate(byId("coefficients"));
        byId("verdict").textContent = verdictText();
      }
      draw("density");
    }
    if (answer.kind === "samples") save(answer.rate);
  }

  /** The ends of the 95 % intervals of deviations. */
  function intervalsOf(adev, freedom) {
    const ends = (side) => adev.map((value, k) => (freedom ? value * freedom[3 * k + side] : value));
    return { low: ends(1), high: ends(2) };
  }

  /** The Allan deviation of the estimated coefficients. */
  function fittedCurve({ terms, processes, lowPass }) {
    const sizes = denseSizes(drawn.samples()), tau0 = drawn.tau0(), total = new Float64Array(sizes.length);
    const add = (values) => values.forEach((value, k) => { total[k] += value; });
    const of = (model) => call("avar", model, sizes).subarray(0, sizes.length);
    const model = [...TERMS.map(({ id }) => terms[id].model), 0, 1, lowPass?.order ?? 0, lowPass?.corner ?? 1, tau0];
    if (lowPass && model[1] > 0) model[1] *= model[1] / foldedNoise(call, model).white; // N before the sampler
    add(of(model));
    for (const { sigma, time } of processes) add(of([0, 0, 0, 0, 0, sigma[0], time[0], 0, 1, tau0]));
    return { x: sizes.map((m) => m * tau0), y: [...total].map((value) => Math.sqrt(value) / sensor().rate[1]) };
  }

  function save(rate) {
    const [unit, size] = sensor().file, lines = [`time [s],${sensor().channel} [${unit}]`];
    rate.forEach((value, k) => lines.push(`${Number((k * drawn.tau0()).toFixed(6))},${(value / size).toPrecision(12)}`));
    const link = make("a", { href: URL.createObjectURL(new Blob([`${lines.join("\n")}\n`], { type: "text/csv" })), download: "simulated.csv" });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  function showState() {
    const { value } = settings;
    setText(byId("length"), `${samplesNow().toLocaleString("en")} samples, ${timeText(samplesNow() / value.rate)}${isLimited ? `. The longest record of this page has ${MAX_SAMPLES.toLocaleString("en")} samples; at a lower rate it lasts longer.` : ""}`);
    byId("length").classList.toggle("limited", isLimited);
    setText(byId("folding"), foldingText());
    document.body.classList.toggle("logged", Boolean(shown.log));
    setText(byId("verdict"), verdictText());
    setText(byId("tally"), "");
    setText(byId("of-record"), shown.log ? "The record" : "A record with this noise");
    byId("log-curve").hidden = !shown.log;
    setText(byId("source"), shown.log ? `Record: ${shown.log.name}` : "Record: simulated");
    sliders.get("corner").row.hidden = settings.order === 0;
    sliders.get("time").row.hidden = !settings.on.sigma;
    byId("order").value = String(settings.order);
    byId("sensor").value = settings.sensor;
    line.refresh();
  }

  /** What sampling makes of the filtered white noise. */
  function foldingText() {
    const { value, order, on } = settings, [units, size] = unitOf("N");
    if (!order || !on.N) return "";
    const held = shown.folded.white / size, half = text(value.rate / 2);
    if (held < 1.005 * value.N) return `Sampled at ${text(value.rate)} Hz, noise above ${half} Hz folds back: here by less than 0.5 % of N.`;
    const above = value.corner > value.rate / 2 ? ` The corner is above half the rate, ${half} Hz.` : "";
    return `${above} Sampled at ${text(value.rate)} Hz, noise above ${half} Hz folds back: the record holds N = ${text(held)} ${units}, and nothing better can be read from it. The paper: sample at 3 to 5 times the bandwidth.`.trim();
  }

  const only = (id) => () => {
    for (const key of Object.keys(settings.on)) settings.on[key] = key === id;
    change();
  };
  const sliders = new Map();
  const add = (place, id, words, options) => {
    const made = slider(id, words, change, options);
    sliders.set(id, made);
    byId(place).append(made.row);
  };
  for (const { id } of TERMS) add("terms", id, [id, "", ""], { toggled: true, only: only(id) });
  /** Names of the terms, which differ by sensor. */
  function rename() {
    for (const { id, colour, slopeText, paper } of TERMS)
      sliders.get(id).row.querySelector("label").replaceChildren(make("b", { style: `color: var(--${colour})` }, id), ` ${termName(id)}`, make("small", {}, `slope ${slopeText}; ${paper}`));
  }
  rename();
  add("process", "sigma", ["σ", "Standard deviation", "a hump"], { toggled: true, only: only("sigma") });
  add("process", "time", ["T", "Correlation time", "the hump is at τ = 1.9 T"], {});
  add("sampling", "corner", ["Corner", "of the filter", "half the power"], {});
  add("sampling", "rate", ["Rate", "", "samples a second"], {});
  add("sampling", "hours", ["Length", "of the record", ""], {});

  for (const name of Object.keys(PRESETS)) byId("presets").append(make("button", { type: "button", onclick: () => { usePreset(name); rename(); readings.clear(); change(); } }, name));
  byId("order").addEventListener("change", () => { settings.order = Number(byId("order").value); change(); });
  byId("sensor").addEventListener("change", () => { useSensor(byId("sensor").value); rename(); readings.clear(); change(); });
  for (const id of ["again", "again-below"]) byId(id).addEventListener("click", () => { settings.seed++; change(); });
  byId("save").addEventListener("click", () => recorder.ask("samples", request()));
  byId("show-parts").addEventListener("change", () => { drawn.drawDeviation(); drawn.drawDensity(); });
  for (const id of ["plan-tau", "plan-error"]) byId(id).addEventListener("change", askPlan);
  byId("deviation").before(legend([["ink", "model"], ["record", "this record, with 95 % intervals"], ["soft", "each term", "dashed"], ["record", "estimate", "dotted"]]));
  byId("error").before(legend([["axis-1", "eq. (26)", "dashed"], ["axis-0", "exact, for this noise"]]));
  const line = lineByHand(drawn, byId("by-hand"), () => showEstimate(byId("coefficients")));
  logReader(byId("log"), (log) => {
    Object.assign(shown, { log, curve: null, envelope: null, density: null, fit: null });
    readings.clear();
    rename();
    change();
    if (log) scrollTo({ top: 0 });
  });

  if (matchMedia("(max-width: 55rem)").matches) document.querySelector(".tries").open = false; // the figure comes first on a phone
  themeButton();
  change();
  // For the tests of the page, and for those who look behind it.
  window.alive = { settings, shown, frames, change, call, readings, modelNow, figures: drawn, lengths: (model, error) => samplesForCoefficients(call, model, error), grids: (samples, tau0) => ({ sizes: denseSizes(samples), frequencies: frequenciesOf(samples, tau0) }) };
}

moduleOf(byId("core").textContent).then(start).catch((error) => {
  byId("problem").hidden = false;
  byId("problem").textContent = `This browser cannot run the page: ${error.message}. A browser of 2023 or later can.`;
});
