// Use, unit and rate of the columns of a live record: the table of step 2, made of the first lines, and the last line.

import { make } from "./page.js";
import { liveColumns } from "./api.js";
import { bdi, chip, errorBox, keepFocus } from "./dom.js";
import { columnTable, meanLine, readingControls } from "./column_table.js";

const INTERVAL = 3000; // shortest time between two updates of the table [ms]

/** Section with the columns of a live record; `change` is called with new options. Returns {element, update(state)}. */
export function columnChoice(change) {
  const last = make("p", { className: "last-line" }), body = make("div", { className: "columns" });
  const element = make("details", { className: "live-columns", hidden: true, ontoggle: () => refresh() }, make("summary", {}, "Columns, units and rate"), last, body);
  const shown = { options: null, bytes: -1, at: 0 };
  let state = null, isAsked = false, isAnswered = false;

  async function refresh() {
    if (!element.open || element.hidden || !state) return;
    const { options, first_bytes: bytes } = state, key = JSON.stringify(options);
    const isNew = key !== shown.options, isLonger = bytes !== shown.bytes && Date.now() - shown.at > INTERVAL && !body.contains(document.activeElement);
    if (!bytes || !(isNew || isLonger)) return;
    Object.assign(shown, { options: key, bytes, at: Date.now() });
    let opened;
    try {
      opened = await liveColumns(options);
    } catch (error) {
      if (isNew) body.prepend(errorBox(error));
      return;
    }
    if (shown.options !== key) return;
    const target = { all: () => options, change };
    keepFocus(body, () => body.replaceChildren(readingControls(opened, target), columnTable(opened, target), ...opened.means.map((mean) => meanLine(mean))));
  }

  /** Close the section to make room for the coefficients, once all questions are answered. */
  function fold() {
    isAnswered = true;
    if (element.contains(document.activeElement)) element.querySelector("summary").focus();
    element.open = false;
  }

  return {
    element,
    update(next) {
      state = next;
      const { state: word, error, path, first_bytes: bytes, last_line: line } = next;
      element.hidden = !bytes || (word !== "recording" && !path);
      last.replaceChildren(chip(word === "recording" ? "last line" : "last line of the record", "info"), " ", make("code", {}, bdi(line ?? "")));
      if (error?.hint && !isAsked) element.open = isAsked = true;
      if (!error?.hint && isAsked && next.overview && !isAnswered) fold();
      refresh();
    },
  };
}
