// The picture of a figure with its marks: zoom, pan, and setting, moving and removing marks by pointer, finger and keys.

import { make } from "./page.js";
import { clickError, turnedPlace } from "./figure_state.js";

const NS = "http://www.w3.org/2000/svg";
const DRAG = 4; // smallest movement of a pointer that is not a click [pixels of the screen]
const STEPS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const FOOTER = 56, SMALLEST = 300; // height of the command line below, and smallest height of the picture [pixels of the screen]
export const NARROW = 830; // width of a window in which the picture and the controls are not in sight together [pixels]
const LARGEST_ZOOM = 40, SMALLEST_ZOOM = 0.02, ZOOM_STEP = 1.5;

/** Make the stage. `picked(place, key)` is called for a click on the picture, or on the mark `key`; `moved(key, place, isKey)` and `removed(key)` for a mark.
 *
 * Returns {element, open, show, draw, zoomBy, fit, focusMark}.
 */
export function makeStage({ picked, moved, removed }) {
  const view = { zoom: 1, width: 1, height: 1, turn: 0, cross: null, isOpen: false };
  const image = make("img", { alt: "", draggable: false }), cross = make("div", { className: "cross", hidden: true });
  const overlay = document.createElementNS(NS, "svg");
  overlay.setAttribute("aria-hidden", "true");
  overlay.setAttribute("preserveAspectRatio", "none");
  const layer = make("div", { className: "layer" }, image, overlay, cross), holder = make("div", { className: "holder" }, layer);
  const element = make("div", { className: "stage", tabIndex: 0, role: "application", ariaLabel: "Picture of the figure. Arrow keys move the cross, Enter sets a point, plus and minus zoom." }, holder);
  const marks = new Map();
  let pan = null, isClick = false; // isClick: whether a pointer went down beside the marks, and has not moved

  const holderSize = () => {
    const [c, s] = [Math.cos, Math.sin].map((f) => Math.abs(f((view.turn * Math.PI) / 180)));
    return [view.zoom * (c * view.width + s * view.height), view.zoom * (s * view.width + c * view.height)];
  };

  /** The place of the picture under a pointer: the middle of its pixel. */
  function placeAt({ clientX, clientY, pointerType }) {
    const box = holder.getBoundingClientRect(), half = 0.5 / devicePixelRatio;
    const shown = [view.width / 2 + (clientX + half - box.left - box.width / 2) / view.zoom, view.height / 2 + (clientY + half - box.top - box.height / 2) / view.zoom];
    return bounded([...turnedPlace(shown, -view.turn, view), clickError(view.zoom, pointerType === "touch")]);
  }

  const bounded = ([x, y, error]) => [Math.min(Math.max(x, 0), view.width), Math.min(Math.max(y, 0), view.height), error].map((value) => Math.round(value * 1000) / 1000);

  function layout() {
    const [width, height] = holderSize();
    Object.assign(holder.style, { width: `${width}px`, height: `${height}px` });
    Object.assign(layer.style, { width: `${view.zoom * view.width}px`, height: `${view.zoom * view.height}px`, transform: `translate(-50%, -50%) rotate(${view.turn}deg)` });
    overlay.setAttribute("viewBox", `0 0 ${view.width} ${view.height}`);
    if (view.cross) position(cross, view.cross);
  }

  function position(part, [x, y]) {
    Object.assign(part.style, { left: `${(100 * x) / view.width}%`, top: `${(100 * y) / view.height}%` });
  }

  /** Show the whole picture, in what is left of the window below the controls; in a narrow window in half of its height. */
  function fit() {
    if (!view.isOpen || !element.clientWidth) return;
    view.zoom = 1;
    const [width, height] = holderSize(), below = innerHeight - element.getBoundingClientRect().top - scrollY - FOOTER;
    element.style.height = `${innerWidth > NARROW ? Math.max(below, SMALLEST) : Math.min((height * element.clientWidth) / width + 2, innerHeight / 2)}px`;
    view.zoom = Math.min(element.clientWidth / width, element.clientHeight / height, 3);
    layout();
  }

  /** Zoom by a factor, about a point of the screen or the middle of what is visible. */
  function zoomBy(factor, about = null) {
    const box = element.getBoundingClientRect(), point = about ?? { clientX: box.left + box.width / 2, clientY: box.top + box.height / 2 };
    const before = holder.getBoundingClientRect(), share = [(point.clientX - before.left) / before.width, (point.clientY - before.top) / before.height];
    view.zoom = Math.min(Math.max(view.zoom * factor, SMALLEST_ZOOM), LARGEST_ZOOM);
    layout();
    const after = holder.getBoundingClientRect();
    element.scrollLeft += after.left + share[0] * after.width - point.clientX;
    element.scrollTop += after.top + share[1] * after.height - point.clientY;
  }

  /** A place moved by pixels of the screen, in the directions of the screen. */
  function stepped(place, [dx, dy], isFast) {
    const [c, s] = [Math.cos((view.turn * Math.PI) / 180), Math.sin((view.turn * Math.PI) / 180)], step = (isFast ? 20 : 1) / view.zoom;
    return bounded([place[0] + step * (c * dx + s * dy), place[1] + step * (c * dy - s * dx), clickError(view.zoom, false)]);
  }

  function moveCross(direction, isFast) {
    view.cross = stepped(view.cross ?? [view.width / 2, view.height / 2], direction, isFast);
    cross.hidden = false;
    position(cross, view.cross);
    cross.scrollIntoView({ block: "nearest", inline: "nearest" });
  }

  element.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const isMark = event.target !== element, direction = STEPS[event.key];
    if (event.key === "+" || event.key === "=") zoomBy(ZOOM_STEP);
    else if (event.key === "-") zoomBy(1 / ZOOM_STEP);
    else if (event.key === "0") fit();
    else if (isMark) return;
    else if (direction) moveCross(direction, event.shiftKey);
    else if ((event.key === "Enter" || event.key === " ") && view.cross) picked([...view.cross.slice(0, 2), clickError(view.zoom, false)]);
    else return;
    event.preventDefault();
  });
  element.addEventListener("blur", () => { cross.hidden = true; });
  element.addEventListener("wheel", (event) => {
    if (!event.ctrlKey) return;
    event.preventDefault();
    zoomBy(Math.exp(-event.deltaY / 300), event);
  }, { passive: false });
  element.addEventListener("pointerdown", (event) => {
    isClick = !event.target.closest(".mark");
    if (event.pointerType === "mouse" && event.button === 0 && layer.contains(event.target) && isClick) pan = { x: event.clientX, y: event.clientY, left: element.scrollLeft, top: element.scrollTop };
  });
  addEventListener("pointermove", (event) => {
    if (!pan || !(event.buttons & 1)) { pan = null; return; }
    const [dx, dy] = [event.clientX - pan.x, event.clientY - pan.y];
    isClick &&= Math.hypot(dx, dy) <= DRAG;
    if (!isClick) Object.assign(element, { scrollLeft: pan.left - dx, scrollTop: pan.top - dy });
  });
  layer.addEventListener("click", (event) => {
    pan = null;
    if (isClick) picked(placeAt(event));
  });

  function makeMark(key) {
    const mark = make("button", { type: "button", className: "mark" }, make("span"));
    let start = null;
    mark.addEventListener("keydown", (event) => {
      if (STEPS[event.key] && !event.ctrlKey && !event.metaKey && !event.altKey) moved(key, stepped(mark.place, STEPS[event.key], event.shiftKey), true);
      else if (event.key === "Delete" || event.key === "Backspace") removed(key);
      else if (event.key === "Escape") element.focus();
      else if (event.key === "PageUp" || event.key === "PageDown") next(mark, event.key === "PageDown" ? 1 : -1);
      else return;
      event.preventDefault();
      event.stopPropagation();
    });
    mark.addEventListener("pointerdown", (event) => {
      event.preventDefault();
      mark.focus({ preventScroll: true });
      mark.setPointerCapture(event.pointerId);
      start = { x: event.clientX, y: event.clientY, at: placeAt(event), place: mark.place, isDragged: false };
    });
    mark.addEventListener("pointermove", (event) => {
      if (!start || !mark.hasPointerCapture(event.pointerId)) return;
      start.isDragged ||= Math.hypot(event.clientX - start.x, event.clientY - start.y) > DRAG;
      if (!start.isDragged) return;
      const pointed = placeAt(event);
      mark.place = bounded([start.place[0] + pointed[0] - start.at[0], start.place[1] + pointed[1] - start.at[1], pointed[2]]);
      position(mark, mark.place);
    });
    mark.addEventListener("pointerup", () => {
      const drag = start;
      start = null;
      if (drag?.isDragged) moved(key, mark.place, false);
      else if (drag) picked(drag.at, key);
    });
    mark.addEventListener("pointercancel", () => { start = null; });
    layer.append(mark);
    marks.set(key, mark);
    return mark;
  }

  /** Move the focus to the next mark. */
  function next(mark, step) {
    const all = [...layer.querySelectorAll(".mark")], reached = all[all.indexOf(mark) + step];
    if (!reached) return;
    Object.assign(reached, { tabIndex: 0 }).focus();
    reached.scrollIntoView({ block: "nearest", inline: "nearest" });
  }

  /** Show marks: {key, place, kind, label, colour, isOff, isStop}. `isStop`: whether Tab stops there. */
  function show(described, turn) {
    if (view.turn !== turn) {
      view.turn = turn;
      layout();
    }
    const keys = new Set(described.map(({ key }) => key));
    for (const [key, mark] of marks) if (!keys.has(key)) { mark.remove(); marks.delete(key); }
    for (const { key, place, kind, label, colour, isOff, isStop } of described) {
      const mark = marks.get(key) ?? makeMark(key);
      mark.className = `mark ${kind}${isOff ? " off" : ""}`;
      mark.place = place;
      mark.ariaLabel = label;
      if (mark !== document.activeElement) mark.tabIndex = isStop ? 0 : -1;
      mark.style.setProperty("--paint", colour);
      mark.dataset.name = kind === "point" ? "" : label.split(" ")[1];
      position(mark, place);
    }
  }

  /** Draw lines and bands over the picture: {colour, line: [[x, y] …], band: [[x, y] …]}. */
  function draw(lines) {
    const points = (places) => places.map((place) => place.map((value) => value.toFixed(2)).join()).join(" ");
    const part = (tag, name, places, colour) => {
      const made = document.createElementNS(NS, tag);
      made.setAttribute("class", name);
      made.setAttribute("points", points(places));
      made.style.setProperty("--paint", colour);
      return made;
    };
    overlay.replaceChildren(...lines.flatMap(({ colour, line, band }) => [part("polygon", "band", band, colour), part("polyline", "halo", line, colour), part("polyline", "line", line, colour)]));
  }

  /** Open a picture of a size; resolves to the size, which is that of the picture if it is not stated. */
  async function open(address, size) {
    image.src = address;
    await image.decode();
    Object.assign(view, { width: size?.width ?? image.naturalWidth, height: size?.height ?? image.naturalHeight, isOpen: true, cross: null });
    fit();
    return { width: view.width, height: view.height };
  }

  return {
    element, open, show, draw, zoomBy, fit,
    focusMark: (key) => (marks.get(key) ?? element).focus({ preventScroll: true }),
  };
}
