// Options of reading by channel: which column is which channel, and units. Written as mappings, as TOML has them.

import { session, setOptions } from "./session.js";

/** Whose options are stated: those of the session. A live record, and a file that is added, have their own. */
export const ofSession = { all: () => session.options, change: setOptions, hasTable: true };

export const COMMON = ["time", "gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z", "temperature"];
export const SIGNAL = "signal"; // a further signal, by the name of its column

export const sensorName = (channel) => (/^(gyro|accel)(_|$)/.test(channel) ? channel.split("_")[0] : channel);

/** An option of pairs as a mapping: `gyro=deg/s,accel=g` and lists of such texts too. */
export function asPairs(value) {
  if (value === undefined || value === null) return {};
  if (typeof value === "object" && !Array.isArray(value)) return { ...value };
  const texts = (Array.isArray(value) ? value : [value]).flatMap((text) => String(text).split(","));
  return Object.fromEntries(texts.filter((text) => text.includes("=")).map((text) => { const place = text.indexOf("="); return [text.slice(0, place).trim(), text.slice(place + 1).trim()]; }));
}

const AXES = { gyro: "xyz", accel: "xyz" }; // uses that stand for three columns

/** A column and those behind it in its topic; empty if there are fewer than `count`. */
export function columnsFrom(columns, first, count) {
  const mates = columns.filter(({ topic }) => topic === first.topic), place = mates.indexOf(first);
  return place + count <= mates.length ? mates.slice(place, place + count) : [];
}

/** Use a column as a channel, `gyro` and `accel` it and the two behind it as axes, or not at all; the other columns of its topic stay what they are.
 *
 * Numbers of columns count in one topic: of a file with several the topic of the column is read, and no other.
 */
export function assign({ all, change }, columns, changed, channel, topics) {
  const channels = {}, chosen = AXES[channel] ? columnsFrom(columns, changed, 3).map((column, k) => [column, `${channel}_${AXES[channel][k]}`]) : [[changed, channel]];
  for (const column of columns.filter(({ topic }) => topic === changed.topic)) {
    const name = chosen.find(([mate]) => mate === column);
    if (name ? name[1] : column.channel && !chosen.some(([, taken]) => taken === column.channel)) channels[name?.[1] ?? column.channel] ??= column.number;
  }
  const units = asPairs(all().unit);
  for (const [column, name] of chosen) if (column.channel && column.channel !== name) delete units[column.channel]; // it was of the other use
  change({ channels, unit: units, ...(topics.length > 1 ? { topic: changed.topic } : {}) });
}

/** What changes when a topic is read, or several; what was stated about the columns of another one is dropped. */
export const topicChanges = (topic) => ({ topic, channels: undefined, unit: undefined, scale: undefined });

/** Give a unit to a channel: to the whole sensor where all its columns have one unit. */
export function setUnit({ all, change }, columns, column, unit) {
  const sensor = sensorName(column.channel), units = asPairs(all().unit);
  const mates = columns.filter((mate) => mate.channel && sensorName(mate.channel) === sensor);
  const isShared = sensor !== column.channel && mates.every((mate) => (mate.unit ?? "") === (column.unit ?? ""));
  for (const mate of isShared ? mates : [column]) delete units[mate.channel];
  if (unit.trim()) units[isShared ? sensor : column.channel] = unit.trim();
  change({ unit: units });
}

/** Add a pair to an option of pairs. */
export function setPair({ all, change }, option, key, value) {
  const pairs = asPairs(all()[option]);
  if (value === "") delete pairs[key];
  else pairs[key] = value;
  change({ [option]: pairs });
}

/** A name of a channel that options can state: letters, digits and underscores of the name of a column. */
export function signalName(column) {
  const name = column.name.replace(/\[.*$/, "").trim().replace(/[^\p{L}\p{N}]+/gu, "_").replace(/^_+|_+$/g, "");
  return name && !COMMON.includes(name) && !/^(gyro|accel)/.test(name) ? name : `column_${column.number}`;
}

export const UNITS = {
  gyro: ["deg/s", "rad/s", "deg/h", "mdeg/s", "mrad/s", "rad/h"],
  accel: ["m/s^2", "g", "mg", "ug", "mGal"],
  time: ["s", "ms", "us", "ns"],
  temperature: ["degC", "K"],
};
