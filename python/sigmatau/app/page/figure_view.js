// The step in which curves of a datasheet's figure are clicked: picture, controls, and the coefficients of what was clicked.

import { make } from "./page.js";
import { figureCurves, figureFacts, figurePicture, upload } from "./api.js";
import { announce, bdi, button, debounce, errorBox } from "./dom.js";
import { addSpecification } from "./comparison.js";
import { markColour, makeSettings, makeTargets, markLabel } from "./figure_controls.js";
import { curveIndex, curveName, isCurve, MIN_POINTS, missing, nextTarget, placeOf, requestBody, TICKS, turnedPlace, withPlace, without, changed } from "./figure_state.js";
import { makeStage, NARROW } from "./figure_stage.js";
import { questionBox } from "./question.js";
import { save } from "./saving.js";
import { session, setFigure } from "./session.js";
import { coefficientTables } from "./summary.js";
import { text } from "./numbers.js";

const DELAY = 250; // time without changes after which the curves are computed [ms]
const PROMPTS = { x1: "Click a tick at the left end of the x axis.", x2: "Click a tick at the right end of the x axis.", y1: "Click a tick at the lower end of the y axis.", y2: "Click a tick at the upper end of the y axis." };

let shown = null; // the step on screen: {refresh, fit}
addEventListener("resize", debounce(() => { if (session.step === "figure") shown?.fit(); }, 200));

/** Update the step after a change of the clicked points, such as an undo. */
export const figureChanged = () => shown?.refresh();

/** Show the step; `command` shows the equivalent command, `compared` opens the comparison. */
export async function showFigure(view, { command, compared }) {
  const state = { target: nextTarget(session.figure), picture: null, answer: null, request: null, opened: "" };
  const parts = Object.fromEntries(["note", "prompt", "result"].map((name) => [name, make("div", { className: `figure-${name}` })]));
  parts.prompt.setAttribute("role", "status");
  const act = { current: () => session.figure, set, choose, done };
  const targets = makeTargets(act), settings = makeSettings(act);
  const stage = makeStage({ picked: pick, moved: move, removed: remove });
  const tools = make("div", { className: "controls tools", role: "group", ariaLabel: "Zoom" }, button("+", () => stage.zoomBy(1.5), { ariaLabel: "Zoom in" }), button("−", () => stage.zoomBy(1 / 1.5), { ariaLabel: "Zoom out" }), button("Fit", () => stage.fit(), { ariaLabel: "Show the whole picture" }));
  const body = make("div", { className: "figure-step", hidden: true },
    make("div", { className: "figure-main" }, targets.element, make("div", { className: "figure-bar" }, parts.prompt, tools), stage.element,
      make("p", { className: "about" }, "Drag a point to move it; arrow keys move it by a pixel of the screen, Delete removes it, Page Up and Page Down go to the next one. Ctrl and wheel zoom, a drag of the picture moves it.")),
    make("div", { className: "figure-side" }, parts.result, make("details", { open: innerWidth > NARROW }, make("summary", {}, "Sensor, unit and record"), settings.element)));
  view.replaceChildren(make("div", { className: "head" }, make("div", {}, make("h1", {}, bdi(session.figure.name)), make("p", { className: "about" }, "Click two ticks of each axis, then points along a curve. The picture stays on this computer."))), parts.note, body);
  shown = { refresh, fit: () => { if (state.picture) stage.fit(); } };

  function set(figure, target = state.target) {
    state.target = target;
    setFigure(figure);
  }

  function choose(target) {
    state.target = target;
    refresh();
    toStage();
  }

  /** Focus the picture; scroll to it where it may be out of sight. */
  function toStage() {
    stage.element.focus({ preventScroll: innerWidth > NARROW });
  }

  const pictureSize = () => [state.picture.width, state.picture.height];

  const valueField = (key) => targets.element.querySelector(`[data-tick="${key}"]`);

  /** The value of a tick was typed and entered: go on with the next value, or with the picture. */
  function done() {
    const open = TICKS.find((each) => session.figure.ticks[each].place && !session.figure.ticks[each].value);
    if (open) valueField(open).focus();
    else toStage();
  }

  /** Set the target at a place. A mark of the target that was clicked is only selected; ticks of two axes can be at one place. */
  function pick(place, mark = "") {
    const { target } = state;
    if (mark.split(":")[0] === target) return;
    if (isCurve(target)) {
      const k = curveIndex(target), count = session.figure.curves[k].points.length;
      setFigure(changed(session.figure, (copy) => { copy.curves[k].points.push(place); copy.size ??= pictureSize(); }));
      announce(markLabel(session.figure, `c${k}:${count}`));
      return;
    }
    const next = changed(session.figure, (copy) => { copy.ticks[target].place = place; copy.size ??= pictureSize(); });
    state.target = nextTarget(next);
    setFigure(next);
    announce(`${markLabel(session.figure, target)}. Type its value.`);
    valueField(target).focus({ preventScroll: innerWidth > NARROW });
  }

  function move(key, place, isKey) {
    setFigure(withPlace(session.figure, key, place), isKey ? key : null);
    announce(markLabel(session.figure, key));
  }

  function remove(key) {
    const [curve, point] = key.split(":");
    if (!isCurve(key)) state.target = key;
    setFigure(without(session.figure, key));
    announce("Removed");
    stage.focusMark(point > 0 ? `${curve}:${point - 1}` : key);
  }

  function refresh() {
    const { figure } = session;
    if (!figure || session.step !== "figure") return;
    if (state.opened !== JSON.stringify([figure.source, figure.page])) { openPicture(); return; }
    if (!state.picture) return;
    if (isCurve(state.target) && !figure.curves[curveIndex(state.target)]) state.target = nextTarget(figure);
    targets.update(figure, state.target);
    settings.update(figure, state.picture);
    parts.prompt.replaceChildren(prompt(figure));
    showMarks();
    state.request?.abort();
    const open = missing(figure);
    if (open) { stage.draw([]); state.answer = null; showMarks(); parts.result.replaceChildren(make("p", { className: "none" }, open)); command("sigmatau app"); }
    else { parts.result.setAttribute("aria-busy", "true"); compute(); }
  }

  function prompt(figure) {
    const { target } = state;
    const open = TICKS.find((key) => figure.ticks[key].place && !figure.ticks[key].value.trim());
    if (!isCurve(target)) return PROMPTS[target];
    if (open) return "Type the values of the ticks.";
    const k = curveIndex(target), count = figure.curves[k].points.length;
    return count < MIN_POINTS ? `Click points along ${curveName(figure, k)}: ${count} of ${MIN_POINTS} or more, from end to end.` : `Click further points of ${curveName(figure, k)}, closer where it bends.`;
  }

  function showMarks() {
    const { figure } = session, described = [];
    for (const key of TICKS) if (figure.ticks[key].place) described.push({ key, place: placeOf(figure, key), kind: `tick-${key[0]}`, label: markLabel(figure, key), colour: "var(--mark-tick)", isStop: true });
    figure.curves.forEach(({ points }, k) => {
      const off = state.answer?.points[k] === points.length ? state.answer.off[k] ?? [] : [];
      points.forEach((place, j) => described.push({ key: `c${k}:${j}`, place, kind: "point", label: markLabel(figure, `c${k}:${j}`) + (off.includes(j) ? ", off the curve" : ""), colour: markColour(k), isOff: off.includes(j), isStop: j === points.length - 1 }));
    });
    stage.show(described, figure.turn);
  }

  const compute = debounce(async () => {
    const { figure } = session, { picture } = state;
    if (session.step !== "figure" || missing(figure)) return;
    const request = (state.request = new AbortController());
    try {
      const answer = await figureCurves(requestBody(figure, picture), request.signal);
      if (request.signal.aborted) return;
      showAnswer(figure, answer);
    } catch (error) {
      if (error.name === "AbortError") return;
      state.answer = null;
      stage.draw([]);
      showMarks();
      parts.result.replaceChildren(errorBox(error));
    }
    parts.result.removeAttribute("aria-busy");
  }, DELAY);

  function showAnswer(figure, answer) {
    const drawn = figure.curves.map((_, k) => k).filter((k) => figure.curves[k].points.length), back = (place) => turnedPlace(place, -figure.turn, state.picture);
    state.answer = { off: {}, points: figure.curves.map(({ points }) => points.length) };
    answer.channels.forEach(({ off }, j) => { state.answer.off[drawn[j]] = off; });
    stage.draw(answer.channels.map(({ x, y, low, high }, j) => ({
      colour: markColour(drawn[j]), line: x.map((each, i) => back([each, y[i]])),
      band: [...x.map((each, i) => back([each, high[i]])), ...x.map((each, i) => back([each, low[i]])).reverse()],
    })));
    showMarks();
    parts.result.replaceChildren(...resultParts(figure, answer, drawn));
    command(answer.command);
  }

  function resultParts(figure, answer, drawn) {
    const stem = figure.name.replace(/\.[^.]*$/, "") || "figure", problem = make("div");
    const add = button("Add to the comparison", async () => {
      add.disabled = true;
      try {
        const sent = await upload(new File([answer.model], `${stem}.toml`), () => {});
        await addSpecification({ file: sent.file });
        await compared();
      } catch (error) {
        add.disabled = false;
        problem.replaceChildren(errorBox(error));
      }
    });
    const off = drawn.filter((k) => state.answer.off[k].length).map((k) => `${curveName(figure, k)}: ${state.answer.off[k].map((j) => j + 1).join(", ")}`);
    return [
      ...(off.length ? [make("p", { className: "box partial" }, `Points off the fitted curve, marked in the picture: ${off.join("; ")}. Move or delete them.`)] : []),
      coefficientTables(answer.channels.map(({ table }) => table), "Values with their 95 % intervals, which include the error of clicking, or the upper limit of a term that is not observed."),
      ...(answer.length_s ? [make("p", { className: "about" }, `The length of the record is not stated: the shortest possible one is assumed, ${text(answer.length_s / 3600)} h, so that the intervals are too wide rather than too narrow.`)] : []),
      make("p", { className: "row" },
        button("Save clicks.csv", () => save(new Blob([answer.csv], { type: "text/csv" }), "clicks.csv"), { title: "The table that the command below reads" }),
        ...(answer.model ? [button("Save the model", () => save(new Blob([answer.model], { type: "application/toml" }), `${stem}.toml`)), add] : [])),
      problem];
  }

  async function openPicture() {
    const { source, page, name } = session.figure, key = JSON.stringify([source, page]);
    Object.assign(state, { opened: key, picture: null, answer: null });
    body.hidden = true;
    parts.note.replaceChildren(make("p", { className: "none" }, "Opening the picture…"));
    command("sigmatau app");
    try {
      const facts = await figureFacts(source, page), blob = await figurePicture(source, page);
      if (state.opened !== key || !view.contains(body)) return;
      body.hidden = false;
      parts.note.replaceChildren(...linesNote(facts.lines, source.path ?? name, page));
      const address = URL.createObjectURL(blob);
      let size;
      try {
        size = await stage.open(address, facts.form === "svg" ? facts : null);
      } catch {
        throw new Error("The browser cannot show this picture: it is damaged, or of another form. Save it as PNG.");
      } finally {
        URL.revokeObjectURL(address);
      }
      state.picture = { ...size, isVector: facts.form === "svg" };
      parts.note.append(...sizeNote(session.figure, pictureSize()));
      refresh();
      stage.fit();
    } catch (error) {
      body.hidden = true;
      const options = { all: () => ({ page: session.figure.page }), change: ({ page: stated }) => setFigure(changed(session.figure, (copy) => { copy.page = Math.round(Number(stated)) || 1; })) };
      parts.note.replaceChildren(error.hints?.some(({ option }) => option === "page") ? questionBox(error, null, options) : errorBox(error));
    }
  }

  await openPicture();
}

/** Note that the picture is not the one that was clicked. */
function sizeNote(figure, size) {
  const isOther = figure.size && [...TICKS.map((key) => figure.ticks[key].place), ...figure.curves[0].points].some(Boolean) && figure.size.join() !== size.join();
  return isOther ? [make("p", { className: "box partial", role: "alert" }, `The clicked picture had ${figure.size.join(" × ")} pixels, this one has ${size.join(" × ")}: the file has changed. Click again.`)] : [];
}

/** Note that a figure has lines that are read without clicks. */
function linesNote(count, name, page) {
  if (!count) return [];
  const command = `sigmatau curve ${/[^\w./-]/.test(name) ? `'${name.replaceAll("'", `'\\''`)}'` : name}${page ? ` --page ${page}` : ""} --list`;
  return [make("p", { className: "box partial" }, `This file has ${count === 1 ? "a line" : `${count} lines`} that can be read without clicks, and more exactly: `, make("code", {}, command))];
}
