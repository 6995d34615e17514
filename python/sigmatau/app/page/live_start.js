// The form that starts a live record: a serial port with its speed, or a file to which another program writes.

import { make } from "./page.js";
import { ports, startLive } from "./api.js";
import { announce, bdi, button, errorBox, field } from "./dom.js";
import { showFolder } from "./open_view.js";

const SPEEDS = [9600, 57600, 115200, 230400, 460800, 921600, 1000000, 2000000]; // suggested speeds [bit/s]
const stated = { port: "", baud: "115200" }; // typed values, until the page is closed

/** The form; `begun` is called with the first state of a record, which is saved in `folder`, if it is not null. */
export function startForm(folder, begun) {
  const problem = make("div"), choices = make("div", { className: "ports" }, make("p", { className: "none" }, "Looking for ports…"));
  const start = async (body, words) => {
    problem.replaceChildren();
    try {
      const state = await startLive(body);
      announce(words);
      begun(state);
    } catch (error) {
      problem.replaceChildren(errorBox(error));
      problem.scrollIntoView({ block: "nearest" });
    }
  };
  return make("div", {}, problem, make("div", { className: "openers" }, portForm(folder, choices, start), fileList(start)));
}

function input(name, attributes = {}) {
  const made = make("input", { type: "text", value: stated[name], oninput: () => { stated[name] = made.value.trim(); }, ...attributes });
  return made;
}

function portForm(folder, choices, start) {
  const port = input("port", { size: 20, placeholder: "/dev/ttyUSB0, COM3", required: true });
  const baud = input("baud", { size: 9, inputMode: "numeric", list: "speeds", required: true });
  const save = make("input", { type: "text", size: 28, value: folder ? newName() : "", disabled: !folder });
  const connect = (event) => {
    event.preventDefault();
    start({ port: stated.port, baud: Number(stated.baud) || 0, save: save.value.trim() || null, options: {} }, "Connected");
  };
  listPorts(choices, port);
  return make("form", { className: "drop port", onsubmit: connect },
    make("h2", {}, "Record a serial port"),
    choices,
    make("div", { className: "row" }, field("Port", port), field("Baud [bit/s]", baud)),
    make("datalist", { id: "speeds" }, ...SPEEDS.map((speed) => make("option", { value: String(speed) }))),
    field("Save as", save, folder ? "" : "Nothing is saved: sigmatau app was started without a folder."),
    ...(folder ? [make("p", { className: "path" }, "in ", bdi(folder))] : []),
    make("p", { className: "about" }, "Columns, units and rate are chosen after the first lines have arrived."),
    make("p", {}, make("button", { type: "submit", className: "primary", id: "connect" }, "Connect")));
}

/** List the serial ports of this computer, with a button that chooses each. */
async function listPorts(choices, port) {
  const choose = (name) => { port.value = stated.port = name; };
  const refresh = make("li", {}, button("Look again", () => listPorts(choices, port), { className: "small" }));
  try {
    const { ports: listed } = await ports();
    const described = listed.filter(({ text }) => text); // others are usually connectors without a device
    if (!port.value && described.length === 1) choose(described[0].name);
    const rows = listed.map(({ name, text }) => make("li", {}, button(name, () => { choose(name); port.focus(); }, { className: "small" }), " ", make("small", {}, bdi(text))));
    choices.replaceChildren(
      make("p", { className: "about" }, rows.length ? "Choose a port of this computer, or type its name." : "No serial port was found. Plug the device in, or type the name of its port."),
      make("ul", { className: "choices" }, ...rows, refresh));
  } catch (error) {
    choices.replaceChildren(errorBox(error));
  }
}

function fileList(start) {
  const list = make("div", { className: "folder" }, make("p", { className: "none" }, "Looking for files…"));
  showFolder(list, null, ({ source, name }) => start({ ...source, options: {} }, `Watching ${name}`), ["folder", "log"]);
  return make("section", { ariaLabel: "Files that grow" }, make("h2", {}, "Watch a file that grows"), make("p", { className: "about" }, "A text table to which a logger appends lines, such as CSV."), list);
}

/** A file name with the current date and time. */
function newName() {
  const two = (value) => String(value).padStart(2, "0"), now = new Date();
  return `live-${now.getFullYear()}${two(now.getMonth() + 1)}${two(now.getDate())}-${two(now.getHours())}${two(now.getMinutes())}${two(now.getSeconds())}.csv`;
}
