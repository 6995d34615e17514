// The first step: drop a file, choose one of this computer, or one in the folders of the server.

import { make } from "./page.js";
import { files, upload } from "./api.js";
import { announce, bdi, button, errorBox, size } from "./dom.js";

const KINDS = { folder: "Folder", log: "Log", result: "Result", store: "Store of results", model: "Noise model", datasheet: "Datasheet", session: "Saved session", figure: "Figure" };

let dropped = () => {};

/** Show the step. `opened({source, name, kind})` is called with the chosen file. */
export function showOpen(view, about, opened) {
  const status = make("div", { className: "sending" });
  const chooser = make("input", { type: "file", id: "chooser", className: "unseen", tabIndex: -1, ariaLabel: "File of this computer", onchange: () => chooser.files[0] && sendFile(chooser.files[0], status, opened) });
  const zone = make("div", { className: "drop" },
    make("p", { className: "lead" }, "Drop a log here"),
    make("p", { className: "about" }, "A record of a sensor at rest: CSV and other tables, ROS bags, MCAP, flight logs, NumPy, MATLAB, HDF5, Parquet and more."),
    make("p", { className: "about" }, "Or the figure of a datasheet, whose curve you click: PNG, JPEG, WebP, GIF, SVG, PDF."),
    make("p", {}, button("Choose a file…", () => chooser.click(), { className: "primary" }), chooser),
    make("p", { className: "about" }, "The file is copied to a temporary folder on this computer, and deleted when sigmatau ends. Nothing leaves the computer."),
    status);
  dropped = (file) => sendFile(file, status, opened);
  const list = make("div", { className: "folder" });
  view.replaceChildren(
    make("h1", {}, "Open a log"),
    make("div", { className: "openers" },
      zone,
      make("section", { ariaLabel: "Files of the server" }, make("h2", {}, "Files in the opened folders"), list)));
  showFolder(list, null, opened);
}

/** Open a file that was dropped. */
export const openDropped = (file) => dropped(file);

/** Accept files that are dropped anywhere on the page. */
export function acceptDrops(take) {
  const mark = (isOver) => document.body.classList.toggle("over", isOver);
  document.ondragover = (event) => { event.preventDefault(); mark(true); };
  document.ondragleave = (event) => { if (!event.relatedTarget) mark(false); };
  document.ondrop = (event) => {
    event.preventDefault();
    mark(false);
    const file = event.dataTransfer.files[0];
    if (file) take(file);
  };
}

/** Copy a file of this computer to the server; `opened({source, name})` is called with it. */
export async function sendFile(file, place, opened) {
  const bar = make("progress", { max: 1, value: 0, ariaLabel: `Copying ${file.name}` });
  place.replaceChildren(make("p", {}, "Copying ", bdi(file.name), ` (${size(file.size)})`), bar);
  announce(`Copying ${file.name}`);
  try {
    const sent = await upload(file, (share) => { bar.value = share; });
    place.replaceChildren();
    opened({ source: { file: sent.file }, name: sent.name });
  } catch (error) {
    place.replaceChildren(errorBox(error));
  }
  return undefined;
}

/** List a folder; without a path, the folders of the server, or the content of a single one. Only files of `kinds` are listed. */
export async function showFolder(list, path, opened, kinds = Object.keys(KINDS)) {
  let folder;
  try {
    folder = await files(path);
  } catch (error) {
    list.replaceChildren(errorBox(error));
    return undefined;
  }
  if (!path && folder.entries.length === 1 && folder.entries[0].kind === "folder") return showFolder(list, folder.entries[0].path, opened, kinds);
  const enter = async (place) => {
    await showFolder(list, place, opened, kinds);
    list.querySelector("button")?.focus();
  };
  const up = folder.parent ? [button("↑ Parent folder", () => enter(folder.parent), { className: "entry" })] : [];
  const entries = folder.entries.filter(({ kind }) => kinds.includes(kind)).map((entry) => fileRow(entry, () => (entry.kind === "folder" ? enter(entry.path) : opened({ source: sourceOfEntry(entry), name: entry.name, kind: entry.kind }))));
  list.replaceChildren(
    ...(folder.path ? [make("p", { className: "path" }, bdi(folder.path))] : []),
    ...up,
    entries.length ? make("ul", { className: "entries" }, ...entries) : make("p", { className: "none" }, "No log in this folder. To open another folder, start sigmatau app FOLDER."),
    ...(folder.more ? [make("p", { className: "none" }, `${folder.more} more files are not listed.`)] : []));
  return undefined;
}

/** Source of a listed file, {path}, or of a store of the command line, {store}. */
export const sourceOfEntry = ({ path, store }) => (path === null ? { store } : { path });

function fileRow(entry, open) {
  const facts = [KINDS[entry.kind] ?? entry.kind, entry.bytes === null || entry.bytes === undefined ? "" : size(entry.bytes)];
  if (entry.modified && entry.kind !== "folder") facts.push(new Date(entry.modified * 1000).toISOString().slice(0, 10));
  const name = make("span", { className: "name" }, bdi(entry.name + (entry.kind === "folder" ? "/" : "")));
  return make("li", {}, make("button", { type: "button", className: "entry", onclick: open }, name, make("small", {}, facts.filter(Boolean).join(" · "))));
}
